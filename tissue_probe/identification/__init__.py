"""The basis of calibrations: an instrument's constants from its own signals.

Contents: fits on arrays, with 95 % confidence intervals.
"""
