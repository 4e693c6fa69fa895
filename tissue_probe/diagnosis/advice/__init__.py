"""What an excitation could not show, and the experiment or calibration that would tell.

Contents: predictions by fitted models of what was not measured yet.
"""
