"""Whether samples are fit to be fitted, before any model: what is wrong, and what to do.

What belongs here: checks of positions and forces by themselves and against each other, each with
its sentence. What does not: what only a fit tells (``fit_checks``).
"""
