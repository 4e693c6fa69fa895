"""What an excitation could not show, and the experiment or calibration that would tell.

What belongs here: predictions by fitted models of what was not measured yet. What does not: which
effects are missing in what was (``ranking``, ``improvement``).
"""
