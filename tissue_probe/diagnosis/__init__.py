"""The missing effects of a model: where it fails, which effect explains it, and the gain.

Contents: judging models by measurements, as pure functions on arrays.
"""
