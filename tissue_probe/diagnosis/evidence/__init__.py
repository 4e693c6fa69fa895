"""How sure it is what is missing: one number for what a model leaves, one for its probability.

What belongs here: adequacy, evidence, probabilities, and the verdict that follows from them. What
does not: which models are tried (``improvement``), how they are fitted (``fitting``).
"""
