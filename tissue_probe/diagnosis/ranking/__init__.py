"""Every effect of the library added to a model in its turn, and the rules by which they compare.

Contents: one effect more.
"""
