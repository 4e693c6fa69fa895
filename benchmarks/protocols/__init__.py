"""Records of laboratories, by SciPy's integrators alone: a ruler that others made.

What belongs here: courses, specimens, rigs, sensors, protocols, and the marks of what the
diagnosis says of them. What does not: this project's physics, excitations or challenges; of
``tissue_probe`` only the public interface is imported, by ``marks``, which a test holds. So what is
found here is found without a formula or a line of code in common.
"""
