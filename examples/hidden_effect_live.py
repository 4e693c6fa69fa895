"""A hidden effect, found while the suite runs: ``make hidden-effect-live``.

    python examples/hidden_effect_live.py [EFFECT] [--folder FOLDER]

A simulated probe has an effect that the models of the estimators miss. The monitor says so; the
action ``Identify`` records, chooses excitations and says which effect it is; the estimator then
takes the new model while it runs. Printed and drawn are its innovations before and after, over the
noise of the force: about 1 where a model is right.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.action import ActionClient
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile

from tissue_probe.errors import TissueProbeError
from tissue_probe.nodes.asking import ask, to_action
from tissue_probe.nodes.conversions import from_time
from tissue_probe.nodes.qos import LATCHED, SAMPLE_BLOCKS
from tissue_probe.nodes.session import NodeProcess, Session, SessionError
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.library import effects
from tissue_probe.physics.model_file import save
from tissue_probe.signals import NANOSECONDS, FloatArray
from tissue_probe_msgs.action import Identify
from tissue_probe_msgs.msg import ModelVerdict, TissueEstimate

matplotlib.use("Agg")
import matplotlib.pyplot as plt

#: Tissue without the effect [N/m], [N s/m]; how deep the probe stands in it [m].
STIFFNESS, DAMPING, DEPTH = 400.0, 2.0, 1e-3
#: Noise of the simulated load cell [N], which the suite does not know better than by its default.
NOISE = 0.005
#: Budget of the identification, and longest wait for the monitor's verdict [s].
BUDGET, PATIENCE = 300.0, 300.0
#: Estimates that are compared [s], after the filters have settled for as long.
COMPARED = 3.0
ESTIMATOR = "robust_ekf"


@dataclass(frozen=True)
class Innovations:
    """Innovations over the noise of the force, by one model.

    Attributes
    ----------
    time : array, shape (n,)
        Since the first [s].
    over_noise : array, shape (n,)
    """

    time: FloatArray
    over_noise: FloatArray

    @property
    def rms(self) -> float:
        """About 1 where the model is right."""
        return float(np.sqrt(np.mean(self.over_noise**2)))


def main() -> None:
    """Read the command line, run, print and draw."""
    parser = argparse.ArgumentParser(description="Find a hidden effect while the suite runs.")
    parser.add_argument("effect", nargs="?", default="cubic_stiffening")
    parser.add_argument("--folder", type=Path, default=Path("hidden-effect-live"))
    asked = parser.parse_args()
    try:
        run(asked.effect, asked.folder)
    except (SessionError, TissueProbeError) as error:
        raise SystemExit(f"hidden_effect_live: {error}") from None


def run(effect: str, folder: Path, records: int = 3, monitored: bool = True) -> Identify.Result:
    """Hide an effect and find it; leave recordings, model and picture in a folder.

    Parameters
    ----------
    effect : str
        Its name.
    folder : path
        Made if it is not there.
    records : int
        Budget of the identification.
    monitored : bool
        Whether the monitor's verdict is waited for.
    """
    folder.mkdir(parents=True, exist_ok=True)
    hidden = hide(effect, folder / "hidden.yaml")
    nodes = [
        NodeProcess("driver", "driver", parameters={"simulated.model": str(hidden)}),
        NodeProcess("stage", "stage", "/stage", {"x": 0.0, "y": 0.0, "z": -DEPTH}),
        NodeProcess("estimator", ESTIMATOR, parameters={"estimator": ESTIMATOR}),
        NodeProcess("identify", "identify", parameters={"output": str(folder)}),
    ]
    if monitored:
        nodes.append(NodeProcess("monitor", "monitor"))
    with Session(nodes) as session:
        session.activate({"/probe/driver": len(nodes) - 2})
        if monitored:
            await_verdict(session)
        result = identify(session, records)
        print(f"\n{result.message}\n{result.text}", flush=True)
        if result.model:
            model = Path(result.recordings[0]).parent / "model.yaml"
            before, after = change_model(session, model)
            print(
                f"\nInnovations over the noise, rms: {before.rms:.2f} before, {after.rms:.2f} with "
                "the new model."
            )
            draw(before, after, effect, folder / "innovations.png")
        session.deactivate()
    print(f"In {folder}: {', '.join(sorted(each.name for each in folder.iterdir()))}")
    return result


def hide(effect: str, path: Path) -> Path:
    """Write the model of the simulated probe, with an effect of typical strength."""
    known = effects(())
    if effect not in known:
        raise SessionError(f"there is no effect {effect}; there are {', '.join(known)}")
    composition = Composition(effects=(known[effect],))
    values = {entry.name: entry.default for entry in composition.values}
    save(path, composition, {**values, "stiffness": STIFFNESS, "damping": DAMPING}, {})
    return path


def await_verdict(session: Session) -> None:
    """Print what the monitor says of the current model."""
    print("The monitor tests the current model ...", flush=True)
    verdicts: list[ModelVerdict] = []
    session.node.create_subscription(ModelVerdict, "model_verdict", verdicts.append, LATCHED)
    session.wait_until(lambda: bool(verdicts), "the monitor's verdict", PATIENCE)
    told = verdicts[0]
    print(
        f"The monitor: {told.verdict} {', '.join(told.effects[:3])}; the current model leaves "
        f"{told.error_current:.1f} times the noise",
        flush=True,
    )


def identify(session: Session, records: int) -> Identify.Result:
    """Call the action, and print its feedback."""
    step = ""

    def on_feedback(message: Identify.Impl.FeedbackMessage) -> None:
        nonlocal step
        told = message.feedback
        if (now := told.doing.partition(",")[0]) != step:
            step = now
            known = f"; so far {told.verdict} {told.probability:.3f}" if told.verdict else ""
            print(f"Identify, record {told.record} ({told.excitation}): {now}{known}", flush=True)

    client = ActionClient(session.node, Identify, "identify")
    asked = to_action(client, Identify.Goal(seconds=BUDGET, records=records), on_feedback)
    session.wait_until(asked.is_answered, "the node identify")
    answer = asked.answer().get_result_async()
    session.wait_until(answer.done, "the identification", 2.0 * BUDGET)
    return answer.result().result


def change_model(session: Session, model: Path) -> tuple[Innovations, Innovations]:
    """Let the estimator take a model while it runs; return the innovations before and after."""
    heard: list[TissueEstimate] = []
    qos = QoSProfile(depth=SAMPLE_BLOCKS.depth, reliability=SAMPLE_BLOCKS.reliability)
    session.node.create_subscription(TissueEstimate, f"{ESTIMATOR}/estimate", heard.append, qos)
    session.wait_until(lambda: _span(heard) > COMPARED, "estimates", PATIENCE)
    old = heard[0].model
    print(f"The estimator takes the new model, in the place of {old} ...", flush=True)
    request = SetParametersAtomically.Request(
        parameters=[Parameter("model", value=str(model.absolute())).to_parameter_msg()]
    )
    name = f"/probe/{ESTIMATOR}/set_parameters_atomically"
    answer = ask(
        session.node, SetParametersAtomically, name, request,
        lambda condition: session.wait_until(condition, name, PATIENCE),
    )  # fmt: skip
    if not answer.result.successful:
        raise SessionError(answer.result.reason)
    session.wait_until(
        lambda: _span([each for each in heard if each.model != old]) > 2.0 * COMPARED,
        "estimates by the new model",
        PATIENCE,
    )
    before, after = (
        [each for each in heard if (each.model == old) == is_old] for is_old in (True, False)
    )
    return _cut(before), _cut(after)


def _span(estimates: list[TissueEstimate]) -> float:
    if not estimates:
        return 0.0
    first, last = (from_time(estimates[end].header.stamp) for end in (0, -1))
    return (last - first) / NANOSECONDS


def _cut(estimates: list[TissueEstimate]) -> Innovations:
    """Return the innovations of the last estimates."""
    last = from_time(estimates[-1].header.stamp)
    first = last - round(COMPARED * NANOSECONDS)
    within = [each for each in estimates if from_time(each.header.stamp) >= first]
    time = [(from_time(each.header.stamp) - first) / NANOSECONDS for each in within]
    return Innovations(np.array(time), np.array([each.innovation for each in within]) / NOISE)


def draw(before: Innovations, after: Innovations, effect: str, path: Path) -> None:
    """Draw the innovations of both models over time."""
    figure, axes = plt.subplots(2, sharex=True, sharey=True, figsize=(8, 5), layout="constrained")
    for axis, found, name in zip(axes, (before, after), ("before", "new model"), strict=True):
        axis.plot(found.time, found.over_noise, linewidth=0.8)
        axis.set_title(f"{name}: rms {found.rms:.2f}", loc="left")
        axis.set_ylabel("innovation over noise")
    axes[-1].set_xlabel("time [s]")
    figure.suptitle(f"Hidden: {effect}")
    figure.savefig(path, dpi=120)
    plt.close(figure)


if __name__ == "__main__":
    main()
