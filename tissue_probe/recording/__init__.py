"""Recordings: what a run leaves on disk, and how it is read back.

Contents: MCAP in and out, bags of other recorders, CSV in, tables out.
"""
