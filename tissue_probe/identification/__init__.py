"""What calibrations are made of: an instrument's constants from its own signals.

Contents: fits on arrays, with 95 % confidence intervals.
"""
