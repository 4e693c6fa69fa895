"""Probes behind one small interface.

Contents: one file a device, the interface they share, and the guard between every command and every
device.
"""
