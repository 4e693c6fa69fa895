"""Recordings: the files of a run, and how they are read back.

Contents: MCAP in and out, bags of other recorders, CSV in, tables out.
"""
