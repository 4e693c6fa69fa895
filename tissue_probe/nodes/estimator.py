"""The estimator node: one filter on the stream of samples, chosen by name."""

from __future__ import annotations

import sys
import threading
from collections.abc import Sequence
from typing import Literal

from pydantic import BaseModel
from rclpy.node import Node
from std_msgs.msg import Float64

from tissue_probe.estimation import ESTIMATORS, Estimator, EstimatorSettings
from tissue_probe.estimation.drafting import FilterToCompile
from tissue_probe.estimation.kernel import Plan, find_kernel
from tissue_probe.nodes.cdr import float64_to_cdr, last_estimate_to_cdr
from tissue_probe.nodes.conversions import model_to_message
from tissue_probe.nodes.diagnostics import ERROR, OK, STALE, WARN, Diagnostics, Health, Rate
from tissue_probe.nodes.model_changes import OF_MODEL, ModelChanges
from tissue_probe.nodes.parameters import declare, read
from tissue_probe.nodes.process import run_together
from tissue_probe.nodes.qos import LATCHED, SAMPLE_BLOCKS
from tissue_probe.nodes.repeats import SINGLE_VALUES
from tissue_probe.nodes.sample_stream import SampleStream
from tissue_probe.settings import setting
from tissue_probe.signals import (
    EstimatorModel,
    PalpationSite,
    Phase,
    SampleBlock,
    Status,
    TissueEstimates,
)
from tissue_probe_msgs import msg

#: Longest start without a word [s]: a filter is found again in less, and else is compiled first.
LONGEST_SILENT_START = 3.0
#: The health's sentence on a status that gives reason to look.
_DOUBTS = {
    Status.MODEL_REJECTED.name: "the innovations contradict the model; the estimate is not usable",
    Status.DISTURBED.name: "a force away from the drive's frequency disturbs the estimate",
}
COMPILING = (
    "the filter is being compiled, once for each model: seconds, or a minute or two for a model of "
    "many states, such as springpot"
)


class EstimatorNodeSettings(BaseModel):
    """The node's settings beside the filter's own."""

    # The table of estimators is known when the program runs.
    estimator: Literal[tuple(ESTIMATORS)] = setting(  # type: ignore[valid-type]
        "ekf", "", "the filter to run"
    )
    restart_at_site: bool = setting(True, "", "forget the tissue when a dwell at a new site begins")


class EstimatorNode(Node):
    """Runs one filter on every sample and publishes an estimate for each block.

    At a dwell's announced begin the filter restarts, if so set: at the first sample stamped at or
    after the announcement's stamp, so a bag gives the same estimates again. The values in
    ``SINGLE_VALUES`` go out one by one, too, while someone subscribes to them.

    The parameters ``model`` and ``effects`` may change while it runs (``ModelChanges``); by which
    model it goes on from which sample on is published, too.

    It hears nothing before ``hear`` is called.
    """

    def __init__(self, estimator: str) -> None:
        super().__init__(estimator)
        node_settings = EstimatorNodeSettings
        node_settings.model_fields["estimator"].default = estimator
        declare(self, node_settings)
        declare(self, EstimatorSettings, live=OF_MODEL)
        settings = read(self, node_settings)
        self._name = settings.estimator
        self._restart_at_site = settings.restart_at_site
        self._estimator = self._made(read(self, EstimatorSettings))
        self._changes = ModelChanges(self, EstimatorSettings, self._ask, self._take)
        self._told: tuple[int, int] | None = None
        self._stream: SampleStream | None = None
        self._expected: int | None = None
        self.received = 0
        self.lost = 0
        self._missed = Rate()
        self._rate = Rate()
        self._latest: TissueEstimates | None = None
        publish = self.create_publisher
        self._estimates = publish(msg.TissueEstimate, f"{self._name}/estimate", SAMPLE_BLOCKS)
        self._models = publish(msg.EstimatorModel, f"{self._name}/model", LATCHED)
        self._values = {
            name: publish(Float64, f"{self._name}/{name}", SAMPLE_BLOCKS) for name in SINGLE_VALUES
        }

    def hear(self, stream: SampleStream) -> None:
        """Say how it goes with a stream of which this node is a listener."""
        self._stream = stream
        Diagnostics(self, lambda: self._examine(stream))

    def _made(self, settings: EstimatorSettings) -> Estimator:
        """Make the filter; where that takes long, say why."""
        told = threading.Timer(LONGEST_SILENT_START, self.get_logger().info, [COMPILING])
        told.daemon = True
        told.start()
        try:
            return Estimator(self._name, settings)
        finally:
            told.cancel()

    def _ask(self, settings: EstimatorSettings) -> FilterToCompile:
        return FilterToCompile(self._name, settings)

    def _take(self, settings: EstimatorSettings, plan: object) -> None:
        """Let the filter go on by another model from the next sample on."""
        assert isinstance(plan, Plan)
        self._estimator.take_model(settings, kernel=find_kernel(plan))
        self.get_logger().info(f"from the next sample on: {plan.model}")

    def destroy_node(self) -> None:
        """End the stream and a model under way, then the node."""
        self._changes.close()
        if self._stream is not None:
            self._stream.end()
        super().destroy_node()

    def on_site(self, site: PalpationSite) -> None:
        """Note when the filter is to restart."""
        if self._restart_at_site and site.phase == Phase.DWELL:
            self._estimator.restart_at(site.stamp)

    def on_samples(self, block: SampleBlock, frame_id: str) -> None:
        """Filter the next samples, and publish the estimate after the last of them."""
        self._count(block.sequence, len(block))
        estimates = self._estimator.process(block)
        if len(estimates) == 0:
            return
        self._latest = estimates
        if self._estimator.first != self._told:
            self._tell_model(frame_id)
        self._estimates.publish(last_estimate_to_cdr(estimates, frame_id))
        for name, publisher in self._values.items():
            if publisher.get_subscription_count():
                publisher.publish(float64_to_cdr(getattr(estimates, name)[-1]))

    def _tell_model(self, frame_id: str) -> None:
        """Publish by which model the filter goes on, before the first estimate made by it."""
        assert self._estimator.first is not None, "it has filtered samples"
        self._told = stamp, sequence = self._estimator.first
        plan, settings = self._estimator.plan, self._estimator.settings
        told = (self._name, plan.model, settings.model, plan.content, settings.effects)
        self._models.publish(model_to_message(EstimatorModel(stamp, sequence, *told), frame_id))

    def _count(self, sequence: int, count: int) -> None:
        """Count samples received, and lost by their sequence numbers."""
        if self._expected is not None and sequence > self._expected:
            self.lost += sequence - self._expected
        self._expected = sequence + count
        self.received += count

    def _examine(self, stream: SampleStream) -> Health:
        if stream.failure is not None:
            raise stream.failure
        rate = self._rate(self.received)
        missed = self._missed(self.lost + stream.malformed)
        values = {
            "subscribers": self._estimates.get_subscription_count(),
            "publishers": stream.publishers(),
            "samples received": self.received,
            "samples lost": self.lost,
            "messages malformed": stream.malformed,
            "achieved rate [samples/s]": f"{rate:.0f}",
            "model": self._estimator.plan.model,
            **self._changes.values(),
            **_convergence(self._latest),
        }
        if self.count_publishers("samples") > 1:
            return Health(ERROR, "several nodes publish samples: their sequences are mixed", values)
        if missed:
            return Health(WARN, "samples or blocks were lost in the last second", values)
        if not rate:
            return Health(STALE, "no samples in the last second", values)
        if self._changes.failure:
            return Health(WARN, self._changes.failure, values)
        if doubt := _DOUBTS.get(str(values.get("status"))):
            return Health(WARN, doubt, values)
        return Health(OK, "estimating", values)


def _convergence(estimates: TissueEstimates | None) -> dict[str, object]:
    """Say how well the tissue is known after the last sample."""
    if estimates is None:
        return {}
    k, beta = estimates.stiffness[-1], estimates.damping[-1]
    return {
        "status": Status(estimates.status[-1]).name,
        "stiffness [N/m]": f"{k:.2f}",
        "standard deviation of stiffness [N/m]": f"{estimates.stiffness_variance[-1] ** 0.5:.3g}",
        "damping [N s/m]": f"{beta:.3f}",
        "standard deviation of damping [N s/m]": f"{estimates.damping_variance[-1] ** 0.5:.3g}",
    }


def listening(owner: Node, nodes: Sequence[EstimatorNode]) -> None:
    """Let estimators hear one stream of samples, whose topics are relative to ``owner``."""
    stream = SampleStream(owner, nodes)
    for node in nodes:
        node.hear(stream)


def make(name: str) -> list[Node]:
    """Return an estimator that hears samples, alone in its process."""
    node = EstimatorNode(name)
    listening(node, [node])
    return [node]


def main() -> int:
    """Run an estimator node; the executable's name is the filter's name."""
    name = sys.argv[0].rsplit("/", 1)[-1]
    return run_together(lambda: make(name if name in ESTIMATORS else "ekf"))


if __name__ == "__main__":
    raise SystemExit(main())
