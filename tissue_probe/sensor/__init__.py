"""A robot's force sensor where nothing is touched: its load, bias, drift, delay, cable.

Contents: a fit on arrays of poses and wrenches, and the wrench that is left without these.
"""
