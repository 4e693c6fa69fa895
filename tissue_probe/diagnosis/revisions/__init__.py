"""What a fit says of the samples that it was fitted to: how they are to be weighed and simulated.

Contents: one revision a file, each from a fit to measurements of which more is known. What does
not: noise, courses and steps themselves (``fitting``, ``physics``), the search for effects.
"""
