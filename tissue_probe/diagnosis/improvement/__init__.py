"""Effect after effect until what is left is noise: the ladder, and what gives way on it.

What belongs here: models of several effects. What does not: comparing those of one (``ranking``),
proving them on other recordings (``diagnosis``).
"""
