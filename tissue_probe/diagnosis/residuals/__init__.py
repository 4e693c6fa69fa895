"""The residual of a model: its noise, its tests, and where in a record it stands out.

Contents: measured minus predicted output as mere signals.
"""
