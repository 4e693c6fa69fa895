"""Records by simulators of others: MuJoCo, scikit-fem, felupe; development dependencies only.

Contents: their models of a probe on tissue, and records with their truth. A record hides what these
simulators have, in their own terms; which effect or family that is, is said in a table of each
module.
"""
