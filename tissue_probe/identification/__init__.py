"""What calibrations are made of: an instrument's constants from its own signals.

What belongs here: fits on arrays, with 95 % confidence intervals. What does not: the file in which
the constants are kept (``devices.calibration``), and the tissue (``estimation``).
"""
