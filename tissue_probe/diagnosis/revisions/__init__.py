"""Changes of the weights, noise and course of samples that a fit to them has shown to be needed.

Contents: one revision a file, each from a fit to measurements of which more is known. Not here:
noise, courses and steps themselves (``fitting``, ``physics``), the search for effects.
"""
