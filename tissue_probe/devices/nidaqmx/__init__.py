"""The probe on a National Instruments DAQ, on this machine or behind NI's gRPC device server.

What belongs here: all that knows the package ``nidaqmx``. What does not: limits (``safety``), and
volts and counts as forces and positions (``calibration``).
"""
