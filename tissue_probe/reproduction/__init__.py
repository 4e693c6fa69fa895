"""The results figures of the paper, made again from simulated experiments.

Contents: for each figure an experiment, what the paper's filters and ours make of it, a drawing,
and what the paper states beside what is found. The simulator of these experiments shares no
integration code with the estimators.

J. Gafford, "Real-Time Parameter Estimation of Biological Tissue Using Kalman Filtering".
"""
