"""Several estimators in one process, each a node as it is alone: samples are decoded once.

Contents: which estimators, and that they share a process.
"""

from __future__ import annotations

from pydantic import BaseModel, model_validator
from rclpy.node import Node

from tissue_probe.estimation import ESTIMATORS
from tissue_probe.nodes.estimator import EstimatorNode, listening
from tissue_probe.nodes.parameters import declare, read
from tissue_probe.nodes.process import run_together
from tissue_probe.settings import setting


class EstimatorsSettings(BaseModel):
    """Which estimators share the process."""

    estimators: list[str] = setting(
        ["robust_ekf", "ekf", "ukf", "afekf"], "", "the filters to run, each as a node of its name"
    )

    @model_validator(mode="after")
    def _each_once(self) -> EstimatorsSettings:
        if unknown := [name for name in self.estimators if name not in ESTIMATORS]:
            raise ValueError(
                f"no estimator {', '.join(unknown)}; there are {', '.join(ESTIMATORS)}"
            )
        if not self.estimators or len(set(self.estimators)) < len(self.estimators):
            raise ValueError(f"{self.estimators}: name at least one filter, and each only once")
        return self


def make() -> list[Node]:
    """Return the process's own node, and those of the estimators."""
    owner = Node("estimators")
    declare(owner, EstimatorsSettings)
    nodes = [EstimatorNode(name) for name in read(owner, EstimatorsSettings).estimators]
    listening(owner, nodes)
    # The estimators end the stream, whose subscriptions are relative to the owner, before it ends.
    return [*nodes, owner]


def main() -> int:
    """Run several estimator nodes."""
    return run_together(make)


if __name__ == "__main__":
    raise SystemExit(main())
