"""How sure a missing effect is: one number for a model's residual, one for its probability.

Contents: adequacy, evidence, probabilities, and the verdict that follows from them.
"""
