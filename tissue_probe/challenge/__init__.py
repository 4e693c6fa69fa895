"""Recordings with a hidden effect, to learn how far a diagnosis can be trusted.

Contents: a simulator that shares nothing with the models that are fitted, the search for the
strength of what it hides, sealed answers, and marks.
"""

from tissue_probe.challenge.simulator import (
    LIBRARY,
    SIMULATED_EFFECTS,
    Challenge,
    HiddenTruth,
    SimulatedRecord,
    make_challenge,
)

__all__ = [
    "LIBRARY",
    "SIMULATED_EFFECTS",
    "Challenge",
    "HiddenTruth",
    "SimulatedRecord",
    "make_challenge",
]
