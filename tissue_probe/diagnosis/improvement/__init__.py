"""Effect after effect until what is left is noise: the ladder, and what gives way on it.

Contents: models of several effects.
"""
