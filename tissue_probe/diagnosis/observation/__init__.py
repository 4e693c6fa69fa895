"""A recording as a model meets it: the instrument, samples at their times, and their noise.

Contents: what is measured, what is known of the rig, what each kind of noise does to a residual.
"""
