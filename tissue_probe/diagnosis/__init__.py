"""What a model of tissue misses: where it fails, which effect explains it, what adding it gains.

Contents: judging models by measurements, as pure functions on arrays.
"""
