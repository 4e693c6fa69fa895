"""Probes behind one small interface.

What belongs here: one file a device, the interface they share, and the guard between every command
and every device. What does not: ROS, and what the samples mean.
"""
