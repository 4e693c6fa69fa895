"""How sure it is what is missing: one number for what a model leaves, one for its probability.

Contents: adequacy, evidence, probabilities, and the verdict that follows from them.
"""
