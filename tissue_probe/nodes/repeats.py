"""Topics that repeat, value by value, a block of samples or an estimate.

They are for surgical stacks and plots that know only common messages; they go out only while
someone subscribes, and a recording is complete without them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

#: Beside the driver's ``samples``: coil displacement and load-cell force, a message each sample.
SINGLE_SAMPLES = ("measured_cp", "measured_cf")
#: Beside an estimator's ``estimate``: a number each.
SINGLE_VALUES = ("stiffness", "damping", "covariance_trace")

_REPEATED = {
    "tissue_probe_msgs/msg/ProbeSamples": ("samples", SINGLE_SAMPLES),
    "tissue_probe_msgs/msg/TissueEstimate": ("estimate", SINGLE_VALUES),
}


def repeats(topics: Mapping[str, Collection[str]]) -> set[str]:
    """Return those of ``topics`` (the types of each, by its name) that repeat another of them."""
    found: set[str] = set()
    for topic, types in topics.items():
        namespace, _, name = topic.rpartition("/")
        for typename in types:
            whole, single = _REPEATED.get(typename, (None, ()))
            if name == whole:
                found |= {f"{namespace}/{each}" for each in single}
    return found & topics.keys()
