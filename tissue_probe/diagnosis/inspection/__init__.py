"""Whether samples are fit to be fitted, before any model: the faults, and their remedies.

Contents: checks of positions and forces by themselves and against each other, each with its
sentence.
"""
