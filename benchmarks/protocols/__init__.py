"""Records of laboratories, by SciPy's integrators alone: a ruler that others made.

Contents: courses, specimens, rigs, sensors, protocols, and the marks of what the diagnosis says of
them. So what is found here is found without a formula or a line of code in common.
"""
