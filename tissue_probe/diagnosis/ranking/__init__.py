"""Every effect of the library added to a model in its turn, and the rules by which they compare.

What belongs here: one effect more. What does not: several, one after the other (``improvement``).
"""
