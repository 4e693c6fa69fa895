"""What it costs the estimates that a filter takes another model while it runs, and what it brings.

The suite runs on a simulated probe whose tissue stiffens with the indentation, by an effect that no
process has compiled before. The filters begin with tissue without it, and take the model that has
it. All is measured from the recording of one run: before the model is asked for, while it is read
and compiled, and after it is taken.

Contents: that run, and its table.
"""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rich.table import Table

from benchmarks import recorded, suite
from benchmarks.live import SETTLING
from tissue_probe.nodes.session import NodeProcess, Session
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.library import load_effects
from tissue_probe.physics.model_file import save
from tissue_probe.recording.bags.reader import read_estimates
from tissue_probe.signals import NANOSECONDS, FloatArray, TissueEstimates

ESTIMATORS = ("robust_ekf", "ekf")
#: Time before the model is asked for, and after it is taken [s].
SPAN = 10.0
#: Longest wait for a kernel on a busy machine [s].
LONG = 400.0
#: White noise of the simulated force [N], as the filters know it.
NOISE = 0.005
#: An effect that no process has compiled: the time of day is in its equations.
EFFECT = """
import sympy as sp
from tissue_probe.physics.effects.effect import INDENTATION, Effect, Parameter

CURVE = sp.Symbol("hidden_curve", real=True)
EFFECT = Effect(
    name="hidden_stiffening",
    family="elastic",
    physics="The tissue stiffens with the third power of the indentation",
    parameters=(Parameter(CURVE, "N/m^3", default=1e8, lower=-1e12, upper=1e12),),
    force=CURVE * INDENTATION**3 * sp.Float("{never}"),
)
"""


@dataclass(frozen=True)
class Phase:
    """One estimator in one part of the run.

    Attributes
    ----------
    estimator : str
        Its name.
    when : str
        ``before``, ``compiling`` or ``after``.
    seconds : float
        Length of the part [s].
    estimates, missing : int
        How many there are, and how many blocks have none.
    p50_ms, p99_ms, max_ms : float
        From a block's last sample to its published estimate.
    innovations : float
        Rms of the innovations over the noise of the force; of the part's second half, which a
        filter has had time for.
    """

    estimator: str
    when: str
    seconds: float
    estimates: int
    missing: int
    p50_ms: float
    p99_ms: float
    max_ms: float
    innovations: float


def measure(folder: Path) -> list[Phase]:
    """Run the suite once; return each estimator before, while and after the model is compiled.

    Parameters
    ----------
    folder : path
        Gets the recording, the model and its effect.

    Raises
    ------
    SessionError
        If the suite cannot be started or breaks down.
    """
    bag = (folder / "take_model.mcap").absolute()
    bag.unlink(missing_ok=True)
    effect = bag.with_suffix(".py")
    effect.write_text(EFFECT.format(never=f"1.{time.time_ns()}"))
    composition = Composition(effects=load_effects(effect))
    values = {e.name: e.default for e in composition.entries(map(str, composition.model.values))}
    model = bag.with_suffix(".model.yaml")
    save(model, composition, values, {}, effect_files=[effect])
    with suite.acquiring(bag, _processes(bag, model, effect)) as session:
        suite.spend(session, SETTLING + SPAN)
        asked = session.node.get_clock().now().nanoseconds
        for name in ESTIMATORS:
            _set_model(session, f"/probe/{name}", model, effect)
        _wait_until_taken(session)
        suite.spend(session, SPAN)
    return [
        phase
        for name in ESTIMATORS
        for phase in _phases(bag, name, asked, read_estimates(bag)[name])
    ]


def _processes(bag: Path, model: Path, effect: Path) -> list[NodeProcess]:
    hidden = {"simulated.model": str(model), "simulated.effects": [str(effect)]}
    names = list(ESTIMATORS)
    return [
        NodeProcess("driver", "driver", parameters=hidden),
        NodeProcess("stage", "stage", "/stage"),
        NodeProcess("estimators", "estimators", parameters={"estimators": names}),
        NodeProcess("mapper", "mapper", parameters={"estimators": names}),
        NodeProcess("recorder", "recorder", parameters={"output": str(bag)}),
    ]


def _set_model(session: Session, node: str, model: Path, effect: Path) -> None:
    client = AsyncParameterClient(session.node, node)
    session.wait_until(client.services_are_ready, node)
    changed = [Parameter("model", value=str(model)), Parameter("effects", value=[str(effect)])]
    answer = client.set_parameters_atomically(changed)
    session.wait_until(answer.done, f"the answer of {node}", LONG)
    result = answer.result().result
    if not result.successful:
        raise RuntimeError(result.reason)


def _wait_until_taken(session: Session) -> None:
    def taken() -> bool:
        told = [session.health[f"/probe/{name}"]["model"] for name in ESTIMATORS]
        return all("hidden" in model for model in told)

    session.wait_until(taken, "the model to be compiled", LONG)


def _phases(bag: Path, name: str, asked: int, found: TissueEstimates) -> list[Phase]:
    delays = recorded.delays(bag, f"/probe/{name}/estimate")
    stamp = found.stamp
    by_old = np.array(["hidden" not in model for model in found.model])
    begin = stamp[0] + round(SETTLING * NANOSECONDS)
    parts = {
        "before": (stamp >= begin) & (stamp < asked),
        "compiling": (stamp >= asked) & by_old,
        "after": ~by_old,
    }
    return [_phase(name, when, found[part], delays[part]) for when, part in parts.items()]


def _phase(name: str, when: str, found: TissueEstimates, delays: FloatArray) -> Phase:
    steps = np.diff(found.sequence)
    late = found.innovation[len(found) // 2 :]
    return Phase(
        name,
        when,
        float(found.stamp[-1] - found.stamp[0]) / NANOSECONDS,
        len(found),
        int(np.sum(steps // steps.min() - 1)),
        **recorded.percentiles_ms(delays),
        innovations=float(np.sqrt(np.mean(late**2))) / NOISE,
    )


def kept(phases: list[Phase]) -> list[dict[str, object]]:
    """Return them as JSON holds them."""
    return [asdict(phase) for phase in phases]


def table(phases: list[Phase]) -> Table:
    """Return losses, latencies and innovations."""
    shown = Table(
        *("estimator", "when", "s", "estimates", "blocks without", "p50 [ms]", "p99 [ms]"),
        *("max [ms]", "innovations / noise"),
        title="Another model while it runs",
    )
    for phase in phases:
        shown.add_row(
            phase.estimator,
            phase.when,
            f"{phase.seconds:.1f}",
            str(phase.estimates),
            str(phase.missing),
            *(f"{ms:.2f}" for ms in (phase.p50_ms, phase.p99_ms, phase.max_ms)),
            f"{phase.innovations:.2f}",
        )
    return shown
