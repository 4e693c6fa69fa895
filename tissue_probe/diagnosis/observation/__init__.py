"""A recording as a model meets it: the instrument, samples at their times, and their noise.

Contents: the samples, the rig with its tolerances, the whitening of each kind of noise.
"""
