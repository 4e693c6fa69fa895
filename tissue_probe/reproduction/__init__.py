"""The results figures of the paper, made again from simulated experiments.

Contents: for each figure an experiment, the estimates of the paper's filters and ours, a drawing,
and the paper's values beside those found. The simulator of these experiments shares no integration
code with the estimators.

J. Gafford, "Real-Time Parameter Estimation of Biological Tissue Using Kalman Filtering".
"""
