"""The probe on a National Instruments DAQ, on this machine or behind NI's gRPC device server.

Contents: all that knows the package ``nidaqmx``.
"""
