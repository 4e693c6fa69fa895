"""Effects that an excitation could not show, and the experiment or calibration that would.

Contents: predictions by fitted models of experiments that were not made yet.
"""
