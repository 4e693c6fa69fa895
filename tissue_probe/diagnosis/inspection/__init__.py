"""Whether samples are fit to be fitted, before any model: what is wrong, and what to do.

Contents: checks of positions and forces by themselves and against each other, each with its
sentence.
"""
