"""The estimator node: one filter on the stream of samples, chosen by name."""

from __future__ import annotations

import sys
import threading
from functools import partial
from typing import Literal

from pydantic import BaseModel
from rclpy.node import Node
from std_msgs.msg import Float64

from tissue_probe.estimation import ESTIMATORS, Estimator, EstimatorSettings
from tissue_probe.nodes.cdr import float64_to_cdr, last_estimate_to_cdr, samples_from_cdr
from tissue_probe.nodes.conversions import site_from_message
from tissue_probe.nodes.diagnostics import ERROR, OK, STALE, WARN, Diagnostics, Health, Rate
from tissue_probe.nodes.inbox import Inbox
from tissue_probe.nodes.parameters import declare, read
from tissue_probe.nodes.process import run
from tissue_probe.nodes.qos import ANNOUNCEMENTS, BLOCKS
from tissue_probe.settings import setting
from tissue_probe.signals import Phase, Status, TissueEstimates
from tissue_probe_msgs.msg import PalpationSite, ProbeSamples, TissueEstimate

SITES = "palpation_site"
#: How long the estimation waits before it looks whether it is to end [s].
PATIENCE = 0.1
#: Longest start without a word [s]: a filter is found again in less, and else is compiled first.
SILENCE = 3.0
#: What the health says of a status that gives reason to look.
_DOUBTS = {
    Status.MODEL_REJECTED.name: "the innovations contradict the model; the estimate is not usable",
    Status.DISTURBED.name: "a force away from the drive's frequency disturbs the estimate",
}
COMPILING = (
    "the filter is being compiled, once for each model: seconds, or a minute or two for a model of "
    "many states, such as springpot"
)


class EstimatorNodeSettings(BaseModel):
    """What the node adds to the filter's own settings."""

    estimator: Literal[tuple(ESTIMATORS)] = setting("ekf", "", "the filter to run")
    restart_at_site: bool = setting(True, "", "forget the tissue when a dwell at a new site begins")


class EstimatorNode(Node):
    """Runs one filter on every sample and publishes an estimate for each block.

    At a dwell's announced begin the filter restarts, if so set: at the first sample stamped at or
    after the announcement's stamp, so a bag gives the same estimates again.
    """

    def __init__(self, estimator: str) -> None:
        super().__init__(estimator)
        node_settings = EstimatorNodeSettings
        node_settings.model_fields["estimator"].default = estimator
        declare(self, node_settings)
        declare(self, EstimatorSettings)
        settings = read(self, node_settings)
        self._name = settings.estimator
        self._restart_at_site = settings.restart_at_site
        self._estimator = self._made(read(self, EstimatorSettings))
        self._expected: int | None = None
        self.received = 0
        self.lost = 0
        self._malformed = 0
        self._missed = Rate()
        self._rate = Rate()
        self._latest: TissueEstimates | None = None
        publish = self.create_publisher
        self._estimates = publish(TissueEstimate, f"{self._name}/estimate", BLOCKS)
        self._values = {
            name: publish(Float64, f"{self._name}/{name}", BLOCKS)
            for name in ("stiffness", "damping", "covariance_trace")
        }
        self._inbox = Inbox(self)
        self._inbox.subscribe(PalpationSite, SITES, ANNOUNCEMENTS, self._on_site)
        self._inbox.subscribe(ProbeSamples, "samples", BLOCKS, self._on_samples, raw=True)
        Diagnostics(self, self._examine)
        self._failure: Exception | None = None
        self._stopping = threading.Event()
        # A daemon: if it hangs, the process still ends.
        self._thread = threading.Thread(target=self._estimate, name="estimation", daemon=True)
        self._thread.start()

    def _made(self, settings: EstimatorSettings) -> Estimator:
        """Make the filter; where that takes long, say why."""
        told = threading.Timer(SILENCE, self.get_logger().info, [COMPILING])
        told.daemon = True
        told.start()
        try:
            return Estimator(self._name, settings)
        finally:
            told.cancel()

    def destroy_node(self) -> None:
        """End the estimation, then the node."""
        self._stopping.set()
        self._thread.join(10 * PATIENCE)
        self._inbox.destroy()
        super().destroy_node()

    def _estimate(self) -> None:
        """Take samples as they come; in its own thread, without the executor's expense."""
        try:
            while not self._stopping.is_set():
                self._inbox.wait(PATIENCE)
                self._inbox.empty()
        except Exception as error:  # told by the main thread, which ends the process
            if self.context.ok():
                self._failure = error

    def _on_site(self, message: PalpationSite, info: dict) -> None:
        site = site_from_message(message)
        if self._restart_at_site and site.phase == Phase.DWELL:
            self._estimator.restart_at(site.stamp)

    def _on_samples(self, message: bytes, info: dict) -> None:
        # A restart must be known before the samples that it is for, however many wait here.
        self._inbox.empty(SITES)
        try:
            block, frame_id = samples_from_cdr(message)
        except ValueError as error:
            self._malformed += 1
            self.get_logger().error(f"a block is left out: {error}", throttle_duration_sec=1.0)
            return
        self._count(block.sequence, len(block))
        estimates = self._estimator.process(block)
        if len(estimates) == 0:
            return
        self._latest = estimates
        self._estimates.publish(last_estimate_to_cdr(estimates, frame_id))
        for name, publisher in self._values.items():
            publisher.publish(float64_to_cdr(getattr(estimates, name)[-1]))

    def _count(self, sequence: int, count: int) -> None:
        """Count samples received, and lost by their sequence numbers."""
        if self._expected is not None and sequence > self._expected:
            self.lost += sequence - self._expected
        self._expected = sequence + count
        self.received += count

    def _examine(self) -> Health:
        if self._failure is not None:
            raise self._failure
        rate = self._rate(self.received)
        missed = self._missed(self.lost + self._malformed)
        values = {
            "subscribers": self._estimates.get_subscription_count(),
            "publishers": self._inbox.publishers(),
            "samples received": self.received,
            "samples lost": self.lost,
            "blocks malformed": self._malformed,
            "achieved rate [samples/s]": f"{rate:.0f}",
            **_convergence(self._latest),
        }
        if self.count_publishers("samples") > 1:
            return Health(ERROR, "several nodes publish samples: their sequences are mixed", values)
        if missed:
            return Health(WARN, "samples or blocks were lost in the last second", values)
        if not rate:
            return Health(STALE, "no samples in the last second", values)
        if values.get("status") in _DOUBTS:
            return Health(WARN, _DOUBTS[values["status"]], values)
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


def main() -> int:
    """Run an estimator node; the executable's name is the filter's name."""
    name = sys.argv[0].rsplit("/", 1)[-1]
    return run(partial(EstimatorNode, name if name in ESTIMATORS else "ekf"))


if __name__ == "__main__":
    raise SystemExit(main())
