"""The test of the current model while samples come in: window after window, without ROS.

Contents: settings, the model under test, the test of one window, the cut of a stream into windows.
"""
