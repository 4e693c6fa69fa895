"""What a robot's force sensor says where nothing is touched: its load, bias, drift, delay, cable.

Contents: a fit on arrays of poses and wrenches, and what is left of a wrench without these.
"""
