"""The driver node: runs a device, excites the tissue, and publishes the device's samples."""

from __future__ import annotations

import sys
import threading
import time
from typing import TYPE_CHECKING, Literal, NamedTuple, cast

import numpy as np
from geometry_msgs.msg import PoseStamped
from pydantic import BaseModel, model_validator
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter
from rclpy.subscription import Subscription
from std_srvs.srv import Trigger

from tissue_probe.configuration import stock_configuration
from tissue_probe.devices.calibration import Calibration
from tissue_probe.devices.device import DeviceError
from tissue_probe.devices.interlock import Interlock
from tissue_probe.devices.limits import LimitExceeded, Limits
from tissue_probe.devices.registry import DEVICES
from tissue_probe.devices.safety import GuardedDevice
from tissue_probe.excitation import EXCITATIONS, Excitation, parse_excitation
from tissue_probe.identification.free_air import Refused
from tissue_probe.nodes.cdr import samples_from_cdr
from tissue_probe.nodes.conversions import place_from_message
from tissue_probe.nodes.crtk import DISABLED, ENABLED, FAULT, OperatingStateInterface
from tissue_probe.nodes.diagnostics import ERROR, OK, WARN, Diagnostics, Health, Rate
from tissue_probe.nodes.emergency_stop import EmergencyStop
from tissue_probe.nodes.hearing import DISCOVERY_TIME, Hearing
from tissue_probe.nodes.inbox import Inbox
from tissue_probe.nodes.lifecycle import SturdyLifecycleNode
from tissue_probe.nodes.loan_watch import LoanWatch
from tissue_probe.nodes.parameters import declare, follow_changes, read
from tissue_probe.nodes.process import run
from tissue_probe.nodes.qos import POSES, SAMPLE_BLOCKS
from tissue_probe.nodes.real_time import ask_for_locked_memory, ask_for_priority
from tissue_probe.nodes.sample_publisher import SamplePublisher
from tissue_probe.nodes.scan_watch import ScanWatch
from tissue_probe.nodes.tare import RunningTare
from tissue_probe.nodes.timers import every
from tissue_probe.settings import SettingsError, setting
from tissue_probe_msgs.msg import ProbeSamples

if TYPE_CHECKING:
    from tissue_probe.devices.simulated import SimulatedProbe

#: Most samples that are read, and checked against the limits, at once.
LONGEST_READ = 10

#: Parameters of the driver that others record.
TOLD = ("device_description", "calibration")

#: Below this part of its rate the device is too slow, and the driver warns.
SLOW_DEVICE_SHARE = 0.95

#: Above this delay of a wake-up, the driver warns [s].
LATE = 0.05


class DriverSettings(BaseModel):
    """The driver's own settings, and its device's description."""

    # Both tables are known when the program runs.
    device: Literal[tuple(DEVICES)] = setting(  # type: ignore[valid-type]
        "simulated", "", "which probe to run"
    )
    block_size: int = setting(10, "", "samples in one message of `samples`", ge=1, le=2000)
    frame_id: str = setting("probe", "", "frame of the samples")
    stage_pose: str = setting(
        "/stage/measured_cp", "", "topic on which a simulated probe hears where it stands"
    )
    calibration_file: str = setting(
        "",
        "",
        "YAML file of the calibration; empty for the nominal values of the stock one",
    )
    calibration: str = setting(
        "", "", "the calibration in use, in YAML, with its tares; set by the driver, for recordings"
    )
    device_description: str = setting(
        "", "", "description of the configured device, in YAML; set by the driver, for recordings"
    )
    autostart: bool = setting(
        False, "", "configure and activate as soon as the node runs, and drive the coil"
    )


class ExcitationSettings(BaseModel):
    """The excitation; which of the values count depends on its kind."""

    kind: Literal[tuple(EXCITATIONS)] = setting(  # type: ignore[valid-type]
        "sine", "", "shape of the coil's command"
    )
    amplitude: float = setting(0.85, "V", "largest command", ge=0.0, le=10.0)
    frequency: float = setting(10.0, "Hz", "of a sine", ge=0.01, le=100.0)
    start: float = setting(1.0, "Hz", "lowest frequency", ge=0.01, le=100.0)
    stop: float = setting(30.0, "Hz", "highest frequency", ge=0.01, le=100.0)
    duration: float = setting(10.0, "s", "time of one sweep", gt=0.0, le=3600.0)
    steps: int = setting(10, "", "frequencies of a stepped sweep", ge=2, le=1000)
    spacing: float = setting(1.0, "Hz", "between the frequencies of a multisine", ge=0.01, le=100.0)

    @model_validator(mode="after")
    def _go_together(self) -> ExcitationSettings:
        self.make()
        return self

    def make(self) -> Excitation:
        """Return the excitation that the settings describe.

        Raises
        ------
        SettingsError
            If the values do not go together.
        """
        names = EXCITATIONS[self.kind].model_fields
        return parse_excitation({name: getattr(self, name) for name in names})


class _Acquisition(NamedTuple):
    """What a configured driver has."""

    device: GuardedDevice
    publisher: SamplePublisher
    tare: RunningTare


class Driver(SturdyLifecycleNode):
    """Runs one device; unconfigured, inactive or active as a lifecycle node.

    configure makes the device, activate starts the excitation and the samples, deactivate puts
    the coil at zero, cleanup lets go of the device. A failure while active, and an emergency stop,
    put the coil at zero, are logged, shown in /diagnostics and on the topic fault, and deactivate;
    the driver is not activated again before the service reset is called.
    """

    def __init__(self) -> None:
        super().__init__("driver")
        self._created = time.monotonic()
        self._models: dict[str, type[BaseModel]] = {
            "": DriverSettings,
            "limits.": Limits,
            "excitation.": ExcitationSettings,
            **{f"{name}.": device.settings for name, device in DEVICES.items()},
        }
        for prefix, settings in self._models.items():
            declare(self, settings, prefix, live=settings.model_fields)
            read(self, settings, prefix)
        self._telling = False
        follow_changes(self, self._models, self._on_change, self._refuse_change)
        self._device: GuardedDevice | None = None
        self._simulated: SimulatedProbe | None = None
        self._stage: Inbox | None = None
        self._stage_poses: Hearing | None = None
        self._publisher: SamplePublisher | None = None
        self._thread: threading.Thread | None = None
        self._stopping = threading.Event()
        self._interlock = Interlock()
        self._tare: RunningTare | None = None
        self._real_time: dict[str, object] = {}
        self._shed_told = False
        self._malformed_poses = 0
        self._foreign_samples: Subscription | None = None
        self.create_service(Trigger, "tare", self._on_tare)
        self._crtk = OperatingStateInterface(self, self._operating_state, self._on_command)
        self._emergency_stop = EmergencyStop(
            self, self._interlock, self._trip, lambda: self._thread is not None
        )
        patience = read(self, Limits, "limits.").palpation_timeout
        self._scan_watch = ScanWatch(self, patience, self._on_silent_scan)
        #: An excitation that was changed for a record by a node that is silent.
        self._owed: ExcitationSettings | None = None
        self._loan_watch = LoanWatch(self, ExcitationSettings, patience, self._on_silent_borrower)
        self._rate = Rate()
        self._diagnostics = Diagnostics(self, self._examine)
        every(0.05, self, self._deactivate_after_fault)
        if read(self, DriverSettings).autostart:
            self._begin = every(0.0, self, self._autostart)

    def _autostart(self) -> None:
        """Configure and activate once; a failure is told in the log, as at any other time."""
        self._begin.cancel()
        if self.trigger_configure() == TransitionCallbackReturn.SUCCESS:
            self.trigger_activate()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Make the device; fails, with one sentence in the log, if that cannot be done.

        It fails, too, if another node publishes samples: this one would then look like a second
        source of them to everyone, and might take the device from the first.
        """
        try:
            self._refuse_second_driver()
            settings = read(self, DriverSettings)
            calibration_file = settings.calibration_file or stock_configuration("calibration.yaml")
            calibration = Calibration.load(calibration_file)
            self._tare = RunningTare(calibration)
            chosen = DEVICES[settings.device]
            device_settings = read(self, chosen.settings, f"{settings.device}.")
            limits = read(self, Limits, "limits.")
            device = chosen.load()(device_settings, calibration)
            self._device = GuardedDevice(
                device, limits, calibration.current_per_volt, self._interlock
            )
        except (SettingsError, DeviceError, OSError, ValueError) as error:
            self.get_logger().error(f"cannot configure: {error}")
            return TransitionCallbackReturn.FAILURE
        if settings.device == "simulated":
            self._simulated = cast("SimulatedProbe", device)
            self._stage = Inbox(self)
            self._stage_poses = self._stage.subscribe(
                PoseStamped, settings.stage_pose, POSES, self._on_stage_pose
            )
        self._tell("device_description", device.description)
        self._tell("calibration", self._tare.calibration.text)
        self._publisher = SamplePublisher(self, settings.frame_id, settings.block_size)
        self.get_logger().info(f"configured: the device is {settings.device}")
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start the excitation and the samples; fails if another driver publishes them already."""
        try:
            device, publisher, tare = self._configured()
            self._refuse_after_fault()
            self._refuse_second_driver()
            excitation = read(self, ExcitationSettings, "excitation.").make()
            self._refuse_deaf_stage()
            self._hear_stage()
            device.start(excitation)
        except (SettingsError, DeviceError, LimitExceeded, ValueError) as error:
            self.get_logger().error(f"cannot activate: {error}")
            return TransitionCallbackReturn.FAILURE
        self._stopping.clear()
        self._began = time.monotonic()
        start = self.get_clock().now().nanoseconds - (time.monotonic_ns() - device.started)
        publisher.begin(start, device.sample_period)
        tare.begin(start, device.sample_period)
        self._thread = threading.Thread(target=self._acquire, name="acquisition")
        self._thread.start()
        self.get_logger().info(
            f"active: {1.0 / device.sample_period:g} samples a second, the coil is driven by "
            f"{excitation}"
        )
        self._crtk.publish()
        return TransitionCallbackReturn.SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Put the coil at zero and end the samples."""
        self._stop()
        self._put_excitation_back()
        self._hear_foreign_samples(False)
        self._crtk.publish()
        # The one who deactivates may end this process next.
        self._configured().publisher.deliver()
        self.get_logger().info("deactivated: the coil is at zero")
        return TransitionCallbackReturn.SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Let go of the device."""
        self._release()
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Put the coil at zero and let go of the device, from any state."""
        self._release()
        return TransitionCallbackReturn.SUCCESS

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Put the coil at zero and let go of the device; the node can be configured again."""
        self._release()
        return TransitionCallbackReturn.SUCCESS

    def destroy_node(self) -> None:
        """Put the coil at zero, then end the node."""
        self._release()
        super().destroy_node()

    def _acquire(self) -> None:
        """Fetch and publish samples until told to stop; in its own thread."""
        device, publisher, tare = self._configured()
        self._real_time = {
            "real-time priority": ask_for_priority(),
            "memory locked": ask_for_locked_memory(),
        }
        told = ", ".join(f"{what}: {came}" for what, came in self._real_time.items())
        self.get_logger().info(told)
        try:
            while not self._stopping.is_set():
                samples = tare.apply(device.read(_samples_to_read(device, publisher)))
                if publisher.add(samples):
                    self._hear_stage()
        except LimitExceeded as exceeded:  # the samples of that moment are worth most
            if exceeded.samples is not None:
                publisher.add(tare.apply(exceeded.samples))
        except Exception as error:  # after any error the coil must stop and someone must hear
            if self.context.ok():
                device.trip(str(error) or type(error).__name__)
        finally:
            device.stop()
            tare.end()
        if self.context.ok():
            publisher.flush()

    def _on_tare(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """Make the load cell's present reading its zero, unless the probe is in contact."""
        try:
            if self._tare is None:
                raise Refused("the driver is not configured: activate it, in free air, then tare")
            response.message = f"{self._tare.take():.4f} N are taken off the force from now on"
            self._tell("calibration", self._tare.calibration.text)
            response.success = True
        except Refused as reason:
            response.message = str(reason)
        self.get_logger().info(f"tare: {response.message}")
        return response

    def _tell(self, name: str, value: str) -> None:
        """Set a parameter that only the driver itself may set."""
        self._telling = True
        try:
            self.set_parameters([Parameter(name, value=value)])
        finally:
            self._telling = False

    def _refuse_change(self, name: str) -> str:
        """Say why a parameter would not take effect now: only limits do in every state."""
        if self._telling or name.startswith("limits."):
            return ""
        if name in TOLD:
            return f"{name} is told by the driver, not set"
        if name.startswith("excitation."):
            active = self._thread is not None
            return f"{name} holds from activation on: deactivate first" if active else ""
        ours = name.startswith(tuple(f"{device}." for device in DEVICES))
        if self._device is not None and (ours or name in DriverSettings.model_fields):
            return f"{name} holds from configuration on: deactivate and clean up first"
        return ""

    def _on_change(self) -> None:
        limits = read(self, Limits, "limits.")
        self._scan_watch.change_timeout(limits.palpation_timeout)
        self._loan_watch.change_timeout(limits.palpation_timeout)
        if self._device is not None:
            self._device.change_limits(limits)

    def _configured(self) -> _Acquisition:
        """Return the parts that ``on_configure`` made."""
        if self._device is None or self._publisher is None or self._tare is None:
            raise DeviceError("the driver is not configured")
        return _Acquisition(self._device, self._publisher, self._tare)

    def _hear_stage(self) -> None:
        if self._stage is not None:
            self._stage.empty()

    def _refuse_deaf_stage(self) -> None:
        if self._stage_poses is not None and (mismatch := self._stage_poses.mismatch()):
            topic = read(self, DriverSettings).stage_pose
            raise DeviceError(f"where the probe stands is not heard on {topic}: {mismatch}")

    def _on_stage_pose(self, pose: PoseStamped, info: dict[str, int]) -> None:
        if self._simulated is None:
            return
        try:
            self._simulated.place(*place_from_message(pose))
        except ValueError as error:
            self._malformed_poses += 1
            self.get_logger().error(
                f"a pose of the stage is left out: {error}", throttle_duration_sec=1.0
            )

    def _stop(self) -> None:
        self._stopping.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        if self._device is not None:
            self._device.stop()

    def _release(self) -> None:
        """Stop, and let go of a device that may be half made: configuring may have failed."""
        self._stop()
        self._hear_foreign_samples(False)
        if self._device is not None:
            self._device.close()
        for each in (self._publisher, self._stage):
            if each is not None:
                each.destroy()
        self._device = self._simulated = self._publisher = None
        self._stage = self._stage_poses = None

    def _deactivate_after_fault(self) -> None:
        self._emergency_stop.publish()
        if self._interlock.tripped and self._thread is not None:
            self.get_logger().fatal(self._interlock.reason)
            self._diagnostics.publish()
            self.trigger_deactivate()

    def _operating_state(self) -> tuple[str, bool]:
        """Return CRTK's state, and whether the coil is driven."""
        if self._interlock.tripped:
            return FAULT, False
        return (ENABLED, True) if self._thread is not None else (DISABLED, False)

    def _on_command(self, command: str) -> None:
        """Do CRTK's enable and disable: activate and deactivate, of the lifecycle."""
        state, _ = self._operating_state()
        if command == "enable" and state == DISABLED and self._device is not None:
            self.trigger_activate()
        elif command == "disable" and state == ENABLED:
            self.trigger_deactivate()
        elif command != {ENABLED: "enable", DISABLED: "disable"}.get(state):
            self.get_logger().error(
                f"'{command}' is no command for a driver that is {state}: it knows enable, once "
                "configured, and disable"
            )

    def _trip(self, reason: str) -> None:
        if self._device is not None:
            self._device.trip(reason)
        else:
            self._interlock.trip(reason)

    def _on_silent_scan(self, reason: str) -> None:
        if self._thread is not None:  # else the coil is at zero already
            self._trip(
                f"{reason}; the coil is at zero, but the tip may rest in the tissue: lift it at "
                "the robot before you reset"
            )

    def _on_silent_borrower(self, reason: str, lent: ExcitationSettings) -> None:
        """Put the coil at zero, then the excitation back."""
        self._owed = lent
        if self._thread is not None:
            self._trip(f"{reason}; the coil is at zero, and the excitation as it was before")
        else:
            self.get_logger().error(f"{reason}; the excitation is as it was before")
            self._put_excitation_back()

    def _put_excitation_back(self) -> None:
        """Put back what is owed, while the coil is not driven."""
        owed, self._owed = self._owed, None
        if owed is not None:
            values = owed.model_dump().items()
            self.set_parameters_atomically(
                [Parameter(f"excitation.{name}", value=value) for name, value in values]
            )

    def _refuse_after_fault(self) -> None:
        if self._interlock.tripped:
            raise DeviceError(
                f"after a fault, first call the service reset; the fault was: "
                f"{self._interlock.reason}"
            )

    def _refuse_second_driver(self) -> None:
        # A node that has only just started has not heard of all the others.
        time.sleep(max(0.0, self._created + DISCOVERY_TIME - time.monotonic()))
        others = self._other_drivers()
        if others:
            raise DeviceError(
                f"{', '.join(others)} publishes {self._samples_topic()} already: two drivers on "
                "one topic would mix their samples; stop the other, or give this one a namespace"
            )

    def _other_drivers(self) -> list[str]:
        me = (self.get_namespace(), self.get_name())
        publishers = self.get_publishers_info_by_topic(self._samples_topic())
        names = [(info.node_namespace, info.node_name) for info in publishers]
        if self._publisher is not None:
            if len(names) == 1:
                return []  # ourselves, even where the graph has not learnt our name yet
            if me in names:
                names.remove(me)
        return [f"{namespace.rstrip('/')}/{name}" for namespace, name in names]

    def _hear_foreign_samples(self, wanted: bool) -> None:
        """Hear the topic of samples, or cease to: it costs as much as an estimator."""
        if wanted and self._foreign_samples is None:
            self._foreign_samples = self.create_subscription(
                ProbeSamples, "samples", self._on_any_samples, SAMPLE_BLOCKS, raw=True
            )
        elif not wanted and self._foreign_samples is not None:
            self.destroy_subscription(self._foreign_samples)
            self._foreign_samples = None

    def _on_any_samples(self, data: bytes) -> None:
        """Give way to another driver that came unseen: who only can publish disturbs nobody."""
        try:
            block, _ = samples_from_cdr(data)
        except ValueError:
            return  # which everyone leaves out
        publisher = self._publisher
        if self._thread is not None and publisher is not None and not publisher.is_own(block):
            others = ", ".join(self._other_drivers()) or "another node"
            self._trip(f"{others} began to publish {self._samples_topic()} too")

    def _samples_topic(self) -> str:
        return self.resolve_topic_name("samples")

    def _examine(self) -> Health:
        if self._interlock.tripped:
            return Health(ERROR, f"{FAULT}: {self._interlock.reason}")
        values: dict[str, object] = {}
        if self._publisher is not None:
            values["subscribers"] = self._publisher.subscribers
            values["samples published"] = self._publisher.published
        if self._thread is None:
            return Health(OK, "not acquiring, the coil is at zero", values)
        device, publisher, _ = self._configured()
        rate, due = self._rate(publisher.published), 1.0 / device.sample_period
        values["achieved rate [samples/s]"] = f"{rate:.0f}"
        others = self._other_drivers()
        self._hear_foreign_samples(bool(others))
        lateness = device.worst_lateness
        values["worst lateness in the last second [ms]"] = f"{1e3 * lateness:.3f}"
        values["command [V]"] = f"{device.commanded_voltage:.4f}"
        values |= self._real_time
        values["stage poses malformed"] = self._malformed_poses
        shed = self._told_of_shedding(publisher, values)
        if self._simulated is not None and (recent := self._simulated.recent_lateness).size:
            median, high = np.percentile(recent, (50, 99))
            values["median lateness in the last second [ms]"] = f"{1e3 * median:.3f}"
            values["99th percentile of lateness in the last second [ms]"] = f"{1e3 * high:.3f}"
        # The first second of an activation is not a whole one.
        whole = time.monotonic() - self._began > 2.0
        trouble = slowness(lateness, rate if whole else due, due) or shed
        if others and not trouble:
            trouble = f"{', '.join(others)} could publish {self._samples_topic()} too"
        return Health(WARN if trouble else OK, trouble or "acquiring", values)

    def _told_of_shedding(self, publisher: SamplePublisher, values: dict[str, object]) -> str:
        """Add how single samples go to ``values``; say, here and in the log, if they do not."""
        values["samples not published singly"] = publisher.shed
        values["part of the time that publishing takes"] = f"{publisher.shedding.share:.2f}"
        told = (
            "measured_cp and measured_cf are not published: they would take "
            f"{publisher.shedding.share:.0%} of the time that acquisition has; fewer subscribers "
            "of them, or a faster machine, and they come back"
        )
        if publisher.shedding.active and not self._shed_told:
            self.get_logger().warning(told)
        elif self._shed_told and not publisher.shedding.active:
            self.get_logger().info("measured_cp and measured_cf are published again")
        self._shed_told = publisher.shedding.active
        return told if self._shed_told else ""


def _samples_to_read(device: GuardedDevice, publisher: SamplePublisher) -> int:
    """Return 1 while someone wants each sample at once; else up to the end of a block.

    Waking up costs far more than reading, so it is done only as often as it is of use; and so often
    that limits are checked in time.
    """
    if publisher.goes_singly:
        return device.samples_per_read
    return min(publisher.missing, LONGEST_READ)


def slowness(lateness: float, rate: float, due: float) -> str:
    """Say which part is too slow; empty if all is in time.

    ``lateness`` [s] is the worst of a second, ``rate`` and ``due`` [samples/s] those that came and
    those expected.
    """
    if lateness > LATE:
        return f"a sample was fetched {1e3 * lateness:.0f} ms late"
    if rate < SLOW_DEVICE_SHARE * due:
        return f"{rate:.0f} samples a second come, not {due:g}"
    return ""


def main() -> int:
    """Run the driver node."""
    # Acquisition shares the interpreter with the node's services: let it have its turn in time.
    sys.setswitchinterval(0.0005)
    return run(Driver)


if __name__ == "__main__":
    raise SystemExit(main())
