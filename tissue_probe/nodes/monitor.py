"""The monitor node: tests the current model on all samples, and diagnoses where it fails."""

from __future__ import annotations

import threading

from rclpy.node import Node
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from tissue_probe.errors import TissueProbeError
from tissue_probe.monitoring.monitor import Monitor
from tissue_probe.monitoring.question import MonitorAnswer, question
from tissue_probe.monitoring.settings import MonitorSettings
from tissue_probe.monitoring.tested_model import TestedModelToCompile, load_tested_model
from tissue_probe.monitoring.window_test import Tested
from tissue_probe.nodes.conversions import to_time
from tissue_probe.nodes.diagnosis_process import start_diagnosis
from tissue_probe.nodes.diagnostics import ERROR, OK, STALE, WARN, Diagnostics, Health, Rate
from tissue_probe.nodes.model_changes import OF_MODEL, ModelChanges
from tissue_probe.nodes.parameters import declare, read
from tissue_probe.nodes.process import run
from tissue_probe.nodes.qos import LATCHED
from tissue_probe.nodes.sample_stream import SampleStream
from tissue_probe.nodes.side_process import SideFailed, SideProcess
from tissue_probe.nodes.timers import every
from tissue_probe.one_line import sentence
from tissue_probe.settings import SettingsError
from tissue_probe.signals import PalpationSite, SampleBlock
from tissue_probe_msgs.msg import ModelVerdict

#: Time between two looks at a diagnosis under way [s]: it takes many times as long.
DIAGNOSIS_LOOK_INTERVAL = 0.25
SILENT = "no samples come: activate the driver, or start the adapter, then ask again"
SECOND = (
    "several nodes publish model_verdict, so verdicts are mixed: end all monitors of this "
    "namespace but one"
)


class MonitorNode(Node):
    """Tests windows of the stream; diagnoses the last seconds, one diagnosis at a time.

    A diagnosis begins when a window is rejected and the samples that it is to get are there, and
    when the service ``~/diagnose`` asks for one. What was diagnosed is not diagnosed again before
    the test has passed, or the tip is at another site.

    Raises
    ------
    SettingsError
        If the model cannot be tested.
    """

    def __init__(self) -> None:
        super().__init__("monitor")
        declare(self, MonitorSettings, live=OF_MODEL)
        settings = read(self, MonitorSettings)
        try:
            self._monitor = Monitor(settings)
        except TissueProbeError as error:
            raise SettingsError(sentence(error)) from None
        self._changes = ModelChanges(self, MonitorSettings, TestedModelToCompile, self._take)
        #: Between the stream's thread and the executor's.
        self._lock = threading.Lock()
        self._frame = ""
        self._tested: Tested | None = None
        self._count = self._received = 0
        self._rate = Rate()
        self._suspect = self._is_known = False
        self._process: SideProcess | None = None
        self._of: SampleBlock | None = None
        self._cause = ModelVerdict.TEST_FAILED
        self._failure = ""
        self._latest = ""
        self._verdicts = self.create_publisher(ModelVerdict, "model_verdict", LATCHED)
        self.create_service(Trigger, "~/diagnose", self._on_request)
        self._stream = SampleStream(self, [self])
        every(DIAGNOSIS_LOOK_INTERVAL, self, self._look)
        Diagnostics(self, self._examine)

    def destroy_node(self) -> None:
        """End the stream, a diagnosis and a model under way, then the node."""
        self._stream.end()
        self._changes.close()
        if self._process is not None:
            self._process.close()
        super().destroy_node()

    def _take(self, settings: MonitorSettings, compiled: object) -> None:
        """Test by another model from now on; a diagnosis of the old one is ended."""
        model = load_tested_model(settings)
        with self._lock:
            self._monitor.take_model(settings, model)
            self._tested, self._suspect, self._is_known = None, False, False
            if self._process is not None:
                self._process.close()
                self._process = None
        self.get_logger().info(
            f"from now on {settings.model or 'the tissue without effects'} is tested"
        )

    def on_site(self, site: PalpationSite) -> None:
        """Note a site, of which another model may hold."""
        with self._lock:
            self._monitor.announce(site)
            self._suspect = self._is_known = False

    def on_samples(self, block: SampleBlock, frame_id: str) -> None:
        """Test the window that ends with these samples, if one is due."""
        with self._lock:
            self._frame = frame_id
            self._received += len(block)
            tested = self._monitor.take(block)
            if tested is None:
                return
            self._tested = tested
            self._count += 1
            self._suspect = tested.rejected
            self._is_known &= tested.rejected

    def _on_request(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Diagnose what is kept, whether the test failed or not."""
        with self._lock:
            block = self._monitor.last()
            response.message = self._why_not(block)
            if block is not None and not response.message:
                self._diagnose(block, ModelVerdict.REQUESTED)
                span = len(block) * block.sample_period
                response.success = True
                response.message = f"the last {span:.2f} s are being diagnosed; see model_verdict"
        return response

    def _why_not(self, block: SampleBlock | None) -> str:
        """Say why nothing can be diagnosed now; empty where it can."""
        if self._process is not None:
            return f"a diagnosis is under way since {self._process.seconds:.0f} s: wait for it"
        if block is None:
            return self._monitor.untested or SILENT
        span = len(block) * block.sample_period
        window = self._monitor.settings.window
        if span < window:
            return f"the samples began {span:.2f} s ago: ask again after {window:g} s"
        return ""

    def _look(self) -> None:
        """Publish a verdict that has come; begin a diagnosis that is due."""
        with self._lock:
            if self._process is not None:
                self._take_verdict(self._process)
            block = self._monitor.last()
            if self._process is None and self._suspect and not self._is_known and block is not None:
                # Up to a block less may be kept.
                kept = len(block) * block.sample_period
                if kept > self._monitor.settings.kept - self._monitor.settings.step:
                    self._diagnose(block, ModelVerdict.TEST_FAILED)

    def _diagnose(self, block: SampleBlock, cause: int) -> None:
        self._of, self._cause, self._is_known, self._failure = block, cause, True, ""
        settings = self._monitor.settings
        asked = question(self._monitor.model, block, settings.model, tuple(settings.effects))
        self._process = start_diagnosis(asked)

    def _take_verdict(self, process: SideProcess) -> None:
        if not process.has_said():
            return
        self._process = None
        try:
            verdict = process.hear()
        except SideFailed as error:
            self._failure = str(error)
            self.get_logger().error(f"no verdict: {error}")
            return
        finally:
            process.close()
        assert self._of is not None, "they were asked about"
        self._latest = verdict.text.partition("\n")[0]
        self.get_logger().info(self._latest)
        self._verdicts.publish(self._message(verdict, self._of))

    def _message(self, verdict: MonitorAnswer, block: SampleBlock) -> ModelVerdict:
        return ModelVerdict(
            header=Header(stamp=to_time(block.stamp), frame_id=self._frame),
            span=len(block) * block.sample_period,
            cause=self._cause,
            verdict=verdict.verdict,
            effects=[name for name, _ in verdict.effects],
            probabilities=[probability for _, probability in verdict.effects],
            error_current=verdict.error_current,
            error_proposed=verdict.error_proposed,
            unseen=list(verdict.unseen),
            experiment=verdict.experiment,
            text=verdict.text,
            proposed_model=verdict.proposed_model,
        )

    def _examine(self) -> Health:
        if self._stream.failure is not None:
            raise self._stream.failure
        with self._lock:
            return self._health()

    def _health(self) -> Health:
        rate, tested, under_way = self._rate(self._received), self._tested, self._process
        values: dict[str, object] = {
            "samples received": self._received,
            "messages malformed": self._stream.malformed,
            "windows tested": self._count,
            "verdict": self._latest or "none yet",
            "model": self._monitor.settings.model or "none",
            **self._changes.values(),
            "diagnosis": f"under way since {under_way.seconds:.0f} s" if under_way else "none",
        }
        if tested is not None:
            values |= {
                "residual over noise": f"{tested.error_over_noise:.2f}",
                "chance of that": f"{tested.chance:.2g}",
                "noise [N]": f"{tested.noise:.3g}",
            }
        if self.count_publishers("model_verdict") > 1:
            return Health(ERROR, SECOND, values)
        if self._changes.failure:
            return Health(WARN, self._changes.failure, values)
        if self._failure:
            return Health(WARN, f"no verdict: {self._failure}", values)
        if not rate:
            return Health(STALE, "no samples in the last second", values)
        if self._monitor.untested:
            return Health(WARN, f"nothing is tested: {self._monitor.untested}", values)
        if tested is not None and tested.rejected:
            told = f"the model leaves {tested.error_over_noise:.2f} times the noise"
            return Health(WARN, f"{told}; {self._latest or 'no verdict yet'}", values)
        return Health(OK, "the model holds" if tested else "waits for a window", values)


def main() -> int:
    """Run the monitor node."""
    return run(MonitorNode)


if __name__ == "__main__":
    raise SystemExit(main())
