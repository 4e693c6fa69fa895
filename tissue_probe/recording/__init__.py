"""Recordings: what a run leaves on disk, and how it is read back.

What belongs here: MCAP in and out, bags of other recorders, CSV in, tables out.
What does not: what is done with the samples (``estimation``, ``mapping``), or ROS itself:
messages come and go as CDR bytes, so a recording is read on a machine without ROS.
"""
