"""Where to probe next, and when the question is answered.

Contents: what the states of a posterior say of sites that were not felt yet, and of the inclusions
that are sought.
"""
