"""The node identify: records, diagnoses, excites as the answer suggests, until it is sure."""

from __future__ import annotations

import math
import threading
import time
import traceback
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from pydantic import BaseModel
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String

from tissue_probe.errors import TissueProbeError
from tissue_probe.monitoring.experiments import (
    ExcitationBounds,
    find_bounds,
    own_settings,
    refuse_beyond,
)
from tissue_probe.monitoring.identification import (
    LiveRecord,
    RecordsVerdict,
    ask_about_records,
    find_end,
)
from tissue_probe.monitoring.record_collector import RecordCollector
from tissue_probe.monitoring.settings import HOUR, MonitorSettings, TestedModelSettings
from tissue_probe.monitoring.tested_model import load_tested_model
from tissue_probe.nodes.asking import Wait
from tissue_probe.nodes.diagnosis_process import start_diagnosis
from tissue_probe.nodes.diagnostics import OK, Diagnostics, Health
from tissue_probe.nodes.hearing import DISCOVERY_TIME, hear
from tissue_probe.nodes.parameters import declare, read
from tissue_probe.nodes.process import run
from tissue_probe.nodes.qos import LATCHED
from tissue_probe.nodes.record_file import RecordFile
from tissue_probe.nodes.remote_driver import DriverState, DriverUnwilling, RemoteDriver
from tissue_probe.nodes.sample_stream import SITES, SampleStream
from tissue_probe.one_line import sentence
from tissue_probe.settings import SettingsError, build, setting
from tissue_probe.signals import PalpationSite, Phase, SampleBlock
from tissue_probe_msgs.action import Identify

DRIVER_NAME = "driver"
#: Time between two looks at what is waited for [s].
EVENT_LOOK_INTERVAL = 0.02
#: Time between two messages of feedback [s].
FEEDBACK = 1.0
#: Longest wait for an answer of the driver [s]: it ends its samples' delivery before it answers,
#: for which it takes 5 s at the most, and a request that was lost is repeated after as many.
LONGEST_DRIVER_WAIT = 12.0
#: Longest wait until samples of an excitation come [s]: they come at once, but for a late machine.
LONGEST_EXCITATION_WAIT = 5.0
#: Longest time that the node takes to put the driver back when it is told to end [s]: ros2 launch
#: kills a process ten seconds after Ctrl-C.
ENDING = 8.0
#: Length of the first record [s]: forty periods of the usual sine.
FIRST_SECONDS = 4.0
#: The probability of the answer where the goal asks for none: that of a verdict that is sure.
SURE = 0.95


class IdentifySettings(TestedModelSettings):
    """Which model is asked about, and where the records are kept."""

    output: str = setting(
        "", "", "folder of the records: each goal makes one in it; empty for the present one"
    )


class IdentifyGoal(BaseModel):
    """What a goal may ask for; see ``Identify.action``."""

    seconds: float = setting(120.0, "s", "budget of time", ge=5.0, le=HOUR)
    records: int = setting(3, "", "budget of records", ge=1, le=10)
    probability: float = setting(SURE, "", "of a settled answer", ge=0.5, lt=1.0)
    amplitude_limit: float = setting(0.0, "V", "largest command", ge=0.0, le=10.0)
    lowest_frequency: float = setting(0.0, "Hz", "slowest excitation", ge=0.0, le=100.0)
    highest_frequency: float = setting(0.0, "Hz", "fastest excitation", ge=0.0, le=100.0)


class IdentificationStopped(RuntimeError):
    """The identification cannot go on; the message says why."""


class IdentificationCancelled(Exception):
    """Its client has cancelled it."""


class TimeSpent(Exception):
    """The budget of time is spent."""


#: Errors by which an identification ends with a sentence.
IDENTIFICATION_FAILURES = (IdentificationStopped, DriverUnwilling, TissueProbeError, OSError)


class _Recording:
    """The record that is being made: its samples here and in a file; taken in the stream's thread.

    Attributes
    ----------
    failure : Exception or None
        The error that ended it.
    """

    def __init__(self, collector: RecordCollector, file: RecordFile) -> None:
        self.collector, self._file = collector, file
        self.failure: Exception | None = None
        self.heard = time.monotonic()
        self._lock = threading.Lock()
        self._ended = False

    def take(self, block: SampleBlock, frame_id: str) -> None:
        with self._lock:
            if self._ended or self.failure or self.collector.record() is not None:
                return
            try:
                if self.collector.takes(block):
                    self.heard = time.monotonic()
                    self._file.write(block, frame_id)
            except (ValueError, OSError) as error:
                self.failure = error

    def end(self) -> None:
        with self._lock:
            self._ended = True
            self._file.close()


class IdentifyNode(Node):
    """Identifies the model of the tissue under the tip, one identification at a time.

    The first record is of the driver's present excitation. After each record the driver is put back
    as it was found, and all records are diagnosed together in a process of low priority; the answer
    names the next excitation. At any end the driver is as it was found, or, where it is gone or a
    fault has stopped it, the coil at zero by its own guard.

    Raises
    ------
    SettingsError
        If the model cannot be tested.
    """

    def __init__(self) -> None:
        super().__init__("identify")
        self._created = time.monotonic()
        declare(self, IdentifySettings)
        self._settings = read(self, IdentifySettings)
        given = self._settings.model_dump(exclude={"output"})
        try:
            self._model = load_tested_model(MonitorSettings(**given))
        except TissueProbeError as error:
            raise SettingsError(sentence(error)) from None
        self._driver = RemoteDriver(self, DRIVER_NAME)
        self._busy = threading.Lock()
        self._told_to_end = threading.Event()
        self._site: PalpationSite | None = None
        self._fault = ""
        self._doing = "waiting for a goal"
        self._recording: _Recording | None = None
        hear(self, String, "fault", self._on_fault, LATCHED)
        self._stream = SampleStream(self, [self])
        self._server = ActionServer(
            self,
            Identify,
            "identify",
            self._execute,
            goal_callback=lambda goal: GoalResponse.ACCEPT,
            cancel_callback=lambda goal: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )
        Diagnostics(self, self._examine)

    def destroy_node(self) -> None:
        """Put the driver back as it was found, end an identification, then the node."""
        self._told_to_end.set()
        deadline = time.monotonic() + ENDING
        while self._busy.locked() and time.monotonic() < deadline:
            assert self.executor is not None, "it is busy, so it is spun"
            self.executor.spin_once(
                timeout_sec=EVENT_LOOK_INTERVAL
            )  # answers of the driver, and the result
        self._stream.end()
        self._server.destroy()
        super().destroy_node()

    def on_site(self, site: PalpationSite) -> None:
        """Note where a scan is."""
        self._site = site

    def on_samples(self, block: SampleBlock, frame_id: str) -> None:
        """Add samples to the record that is being made."""
        if (recording := self._recording) is not None:
            recording.take(block, frame_id)

    def _on_fault(self, message: String) -> None:
        self._fault = message.data

    def _execute(self, goal: ServerGoalHandle) -> Identify.Result:
        if not self._busy.acquire(blocking=False):
            goal.abort()
            return Identify.Result(
                message="refused: an identification is under way, or the node ends; wait for it, "
                "or cancel it"
            )
        try:
            return self._answer(goal)
        finally:
            self._doing = "waiting for a goal"
            self._busy.release()

    def _answer(self, goal: ServerGoalHandle) -> Identify.Result:
        """Identify; return what was found by whatever end."""
        work = _Work(goal)
        try:
            work.asked = _read_goal(goal.request)
            self._refuse_others()
            work.end = self._identify(work)
            ended = goal.succeed
        except TimeSpent:
            work.end = f"the budget of {work.asked.seconds:g} s is spent{work.reached}"
            ended = goal.succeed
        except IdentificationCancelled:
            work.end, ended = f"cancelled{work.reached}", goal.canceled
        except Exception as error:  # someone must hear of any error
            work.end, ended = f"stopped: {_say(error)}", goal.abort
            if not isinstance(error, IDENTIFICATION_FAILURES):
                self.get_logger().error(traceback.format_exc())
        result = work.result()
        ended()
        self.get_logger().info(result.message)
        return result

    def _refuse_others(self) -> None:
        """Refuse where another node would command the driver as well."""
        # A node that has only just started has not heard of all the others.
        time.sleep(max(0.0, self._created + DISCOVERY_TIME - time.monotonic()))
        status = self.resolve_topic_name("identify/_action/status")
        if self.count_publishers(status) > 1:
            raise IdentificationStopped(
                f"several nodes take goals of {self.resolve_topic_name('identify')}, and would "
                "command one driver: end all but one"
            )

    def _identify(self, work: _Work) -> str:
        """Record and diagnose until there is an end; return which."""
        found = self._look(work)
        bounds = find_bounds(
            found.limits, found.current_per_volt, work.asked.amplitude_limit,
            work.asked.lowest_frequency, work.asked.highest_frequency,
        )  # fmt: skip
        if not found.active:
            refuse_beyond(found.excitation, bounds)
        excitation: Mapping[str, object] = {}
        seconds = FIRST_SECONDS
        while True:
            work.records.append(self._record(work, found, excitation, seconds))
            work.verdict = self._diagnose(work, bounds)
            work.keep_model(self._settings.output)
            if end := find_end(
                work.verdict, work.asked.probability, len(work.records), work.asked.records
            ):
                return end
            excitation, seconds = work.verdict.excitation, work.verdict.duration
            if work.left() < seconds:
                raise TimeSpent

    def _look(self, work: _Work) -> DriverState:
        self._tell(work, "looks at the driver")
        self._check(work)
        return self._driver.look(self._patience(partial(self._check, work)))

    def _record(
        self, work: _Work, found: DriverState, excitation: Mapping[str, object], seconds: float
    ) -> LiveRecord:
        """Make one record; whatever happens, the driver is then as it was found."""
        number = len(work.records) + 1
        whole = {**found.excitation, **excitation}
        work.excitation = ", ".join(
            str(value) if name == "kind" else f"{name} {value:g}"
            for name, value in own_settings(whole).items()
        )
        path = work.folder(self._settings.output) / f"record_{number}.mcap"
        parameters = {f"excitation.{name}": value for name, value in whole.items()}
        samples, driver = self.resolve_topic_name("samples"), self.resolve_service_name(DRIVER_NAME)
        recording = _Recording(
            RecordCollector(whole, seconds, str(path)),
            RecordFile(path, samples, driver, parameters),
        )
        work.files.append(str(path))
        check = partial(self._check, work)
        try:
            with self._driver.excite(
                found, excitation, self._patience(check), self._patience(lambda: None)
            ):
                self._recording = recording
                return self._collect(work, recording)
        finally:
            self._recording = None
            recording.end()

    def _collect(self, work: _Work, recording: _Recording) -> LiveRecord:
        """Wait until a record is complete."""
        recording.heard = time.monotonic()
        while (record := recording.collector.record()) is None:
            self._driver.show_alive()
            self._check(work)
            if recording.failure is not None:
                raise IdentificationStopped(str(recording.failure))
            if time.monotonic() - recording.heard > LONGEST_EXCITATION_WAIT:
                topic = self.resolve_topic_name("samples")
                raise IdentificationStopped(
                    f"no samples of this excitation come on {topic} for "
                    f"{LONGEST_EXCITATION_WAIT:g} s: is the driver running, and does nobody else "
                    "command it?"
                )
            self._tell(work, f"records, {recording.collector.seconds:.1f} s so far")
            time.sleep(EVENT_LOOK_INTERVAL)
        return record

    def _diagnose(self, work: _Work, bounds: ExcitationBounds) -> RecordsVerdict:
        """Diagnose all records together."""
        settings = self._settings
        asked = ask_about_records(
            self._model, work.records, bounds, work.asked.probability, settings.model,
            tuple(settings.effects),
        )  # fmt: skip
        process = start_diagnosis(asked)
        try:
            while not process.has_said():
                self._check(work)
                self._tell(work, f"diagnoses {len(work.records)} records")
                time.sleep(EVENT_LOOK_INTERVAL)
            verdict = process.hear()
        finally:
            process.close()
        assert isinstance(verdict, RecordsVerdict), "records were asked about"
        return verdict

    def _check(self, work: _Work) -> None:
        """Raise where the identification must end."""
        if work.goal.is_cancel_requested:
            raise IdentificationCancelled
        if self._told_to_end.is_set():
            raise IdentificationStopped("the node is told to end")
        if self._stream.failure is not None:
            raise self._stream.failure
        if self._fault:
            raise IdentificationStopped(f"the driver has stopped the coil: {self._fault}")
        site = self._site
        if site is not None and site.phase != Phase.LIFTED and self.count_publishers(SITES):
            raise IdentificationStopped(
                f"a scan is under way, at site {site.site}: wait until it has ended, and let the "
                "tip rest on the tissue"
            )
        if work.left() < 0.0:
            raise TimeSpent

    def _patience(self, check: Callable[[], None]) -> Wait:
        """Return how to wait for an answer of the driver."""

        def wait(condition: Callable[[], bool]) -> None:
            deadline = time.monotonic() + LONGEST_DRIVER_WAIT
            while not condition():
                check()
                if time.monotonic() > deadline:
                    raise IdentificationStopped(
                        f"the driver does not answer for {LONGEST_DRIVER_WAIT:g} s: if it runs, "
                        "look whether its excitation is the one that you gave"
                    )
                time.sleep(EVENT_LOOK_INTERVAL)

        return wait

    def _tell(self, work: _Work, doing: str) -> None:
        """Publish feedback when a step begins, and now and then."""
        self._doing = doing
        work.tell(doing)

    def _examine(self) -> Health:
        if self._stream.failure is not None:
            raise self._stream.failure
        return Health(OK, self._doing, {"messages malformed": self._stream.malformed})


class _Work:
    """One identification: the goal, what was recorded and found so far."""

    def __init__(self, goal: ServerGoalHandle) -> None:
        self.goal = goal
        self.asked = IdentifyGoal()
        self.records: list[LiveRecord] = []
        self.files: list[str] = []
        self.verdict: RecordsVerdict | None = None
        self.excitation = self.end = ""
        self._begun = time.monotonic()
        self._told_at, self._told_of = -math.inf, ""
        self._folder: Path | None = None

    @property
    def reached(self) -> str:
        """What is known so far, to go on a sentence."""
        if self.verdict is None:
            return "; there is no verdict yet"
        return f": {self.verdict.verdict}, with a probability of {self.verdict.probability:.3f}"

    def left(self) -> float:
        """Return the time that is left [s]."""
        return self.asked.seconds - (time.monotonic() - self._begun)

    def folder(self, parent: str) -> Path:
        """Return the folder of the records; it is made once."""
        if self._folder is None:
            self._folder = Path(parent, time.strftime("identify_%Y%m%d_%H%M%S")).absolute()
            self._folder.mkdir(parents=True, exist_ok=True)
        return self._folder

    def keep_model(self, parent: str) -> None:
        """Write the model that is proposed so far beside the records."""
        if self.verdict is not None:
            path = self.folder(parent) / "model.yaml"
            path.write_text(self.verdict.proposed_model, encoding="utf-8")

    def tell(self, doing: str) -> None:
        """Publish feedback if the step is another one, or the last was long ago."""
        step = doing.partition(",")[0]
        now = time.monotonic()
        if step == self._told_of and now - self._told_at < FEEDBACK:
            return
        self._told_of, self._told_at = step, now
        feedback = Identify.Feedback(
            record=max(len(self.files), 1), doing=doing, excitation=self.excitation
        )
        if (found := self.verdict) is not None:
            feedback.verdict, feedback.probability = found.verdict, found.probability
            feedback.effects = [name for name, _ in found.effects]
            feedback.probabilities = [probability for _, probability in found.effects]
        self.goal.publish_feedback(feedback)

    def result(self) -> Identify.Result:
        """Return what was found."""
        result = Identify.Result(recordings=self.files, message=self.end)
        if (found := self.verdict) is not None:
            result.settled = found.is_settled(self.asked.probability)
            result.verdict, result.text = found.verdict, found.text
            result.effects = [name for name, _ in found.effects]
            result.probabilities = [probability for _, probability in found.effects]
            result.probability = found.probability
            result.error_current = found.error_current
            result.error_proposed = found.error_proposed
            result.unseen = list(found.unseen)
            result.model = found.proposed_model
        return result


def _say(error: BaseException) -> str:
    """Say why an identification ends; if two errors came one after the other, both."""
    before = (
        f"{_say(error.__context__)}; "
        if isinstance(error.__context__, IDENTIFICATION_FAILURES)
        else ""
    )
    if not isinstance(error, IDENTIFICATION_FAILURES):
        return f"{before}a fault of the node identify, {type(error).__name__}: {error}"
    return f"{before}{sentence(error)}"


def _read_goal(goal: Identify.Goal) -> IdentifyGoal:
    """Return a goal within its ranges; a probability of 0 is the usual one."""
    values = {name: getattr(goal, name) for name in IdentifyGoal.model_fields}
    return build(IdentifyGoal, {**values, "probability": values["probability"] or SURE}, "goal ")


def main() -> int:
    """Run the node identify."""
    # One thread for an identification, others for its cancelling and the driver's answers.
    return run(IdentifyNode, partial(MultiThreadedExecutor, num_threads=3))


if __name__ == "__main__":
    raise SystemExit(main())
