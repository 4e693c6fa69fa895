"""Effect after effect until the residual is noise: the ladder, and effects that give way on it.

Contents: models of several effects.
"""
