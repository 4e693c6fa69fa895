"""What a diagnosis beside the nodes costs the samples and the estimates that come meanwhile.

The suite runs with a monitor on a simulated probe whose tissue has an effect. The monitor diagnoses
once by itself; then each verdict is followed by another request. All is measured from the recording
of one run. How late estimates are without a diagnosis is what `live` measures.

Contents: that run, and its table.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from math import inf
from pathlib import Path

from rich.table import Table
from std_srvs.srv import Trigger

from benchmarks import recorded, suite
from tissue_probe.nodes.asking import ask
from tissue_probe.nodes.qos import LATCHED
from tissue_probe.nodes.session import NodeProcess, Session
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.model_file import save
from tissue_probe.recording.bags.reader import read_estimates
from tissue_probe_msgs.msg import ModelVerdict

ESTIMATORS = ("robust_ekf", "ekf")
DIAGNOSE, VERDICT = "/probe/monitor/diagnose", "/probe/model_verdict"
HIDDEN, STRENGTH = "cubic_stiffening", {"cubic_stiffness": 1e8}
MONITOR = "/probe/monitor"
#: Time in which diagnoses follow one another [s].
BUSY = 60.0
#: Longest wait for the first of them to begin, and for an answer [s].
LONG = 60.0


@dataclass(frozen=True)
class Latency:
    """How late the estimates of one estimator are while diagnoses run.

    Attributes
    ----------
    estimator : str
        Its name.
    estimates : int
        How many there are.
    p50_ms, p99_ms, max_ms : float
        From a block's last sample to its published estimate.
    """

    estimator: str
    estimates: int
    p50_ms: float
    p99_ms: float
    max_ms: float


@dataclass(frozen=True)
class Result:
    """What one run showed.

    Attributes
    ----------
    latencies : tuple of Latency
        Of each estimator.
    counts : list of dict
        Of each node what was published, received and lost.
    verdicts : int
        How many diagnoses have ended.
    """

    latencies: tuple[Latency, ...]
    counts: list[dict[str, object]]
    verdicts: int


def measure(folder: Path) -> Result:
    """Run the suite once; return the latencies beside diagnoses, and the losses.

    Parameters
    ----------
    folder : path
        Gets the recording and the hidden model.

    Raises
    ------
    SessionError
        If the suite cannot be started or breaks down.
    """
    bag = (folder / "diagnose_beside.mcap").absolute()
    bag.unlink(missing_ok=True)
    model = bag.with_suffix(".model.yaml")
    composition = Composition(effects=(EFFECTS[HIDDEN],))
    values = {e.name: e.default for e in composition.entries(map(str, composition.model.values))}
    save(model, composition, values | STRENGTH, {})
    with suite.acquiring(bag, _processes(bag, model)) as session:
        verdicts: list[ModelVerdict] = []
        session.node.create_subscription(ModelVerdict, VERDICT, verdicts.append, LATCHED)
        session.wait_until(
            lambda: "under way" in session.health.get(MONITOR, {}).get("diagnosis", ""),
            "the monitor's own diagnosis",
            LONG,
        )
        begin = session.node.get_clock().now().nanoseconds
        _diagnose_repeatedly(session, verdicts)
        end = session.node.get_clock().now().nanoseconds
    late = tuple(_latency(bag, name, begin, end) for name in ESTIMATORS)
    return Result(late, recorded.counts(bag, ESTIMATORS), len(verdicts))


def _processes(bag: Path, model: Path) -> list[NodeProcess]:
    names = list(ESTIMATORS)
    return [
        NodeProcess("driver", "driver", parameters={"simulated.model": str(model)}),
        NodeProcess("stage", "stage", "/stage"),
        NodeProcess("estimators", "estimators", parameters={"estimators": names}),
        NodeProcess("monitor", "monitor"),
        NodeProcess("mapper", "mapper", parameters={"estimators": names}),
        NodeProcess("recorder", "recorder", parameters={"output": str(bag)}),
    ]


def _diagnose_repeatedly(session: Session, verdicts: Sequence[ModelVerdict]) -> None:
    def wait(condition: Callable[[], bool]) -> None:
        session.wait_until(condition, f"the answer of {DIAGNOSE}", LONG)

    end = time.monotonic() + BUSY
    while time.monotonic() < end:
        known = len(verdicts)
        session.wait_until(
            lambda known=known: len(verdicts) > known or time.monotonic() >= end, "a verdict", inf
        )
        if len(verdicts) > known:
            ask(session.node, Trigger, DIAGNOSE, Trigger.Request(), wait)


def _latency(bag: Path, name: str, begin: int, end: int) -> Latency:
    stamp = read_estimates(bag)[name].stamp
    delays = recorded.delays(bag, f"/probe/{name}/estimate")[(stamp >= begin) & (stamp < end)]
    return Latency(name, delays.size, **recorded.percentiles_ms(delays))


def kept(result: Result) -> dict[str, object]:
    """Return it as JSON holds it."""
    return asdict(result)


def table(result: Result) -> Table:
    """Return losses and latencies."""
    shown = Table(
        *("estimator", "estimates", "p50 [ms]", "p99 [ms]", "max [ms]"),
        title="Estimates beside diagnoses",
    )
    for each in result.latencies:
        times = (f"{ms:.2f}" for ms in (each.p50_ms, each.p99_ms, each.max_ms))
        shown.add_row(each.estimator, str(each.estimates), *times)
    lost = (f"{row['node']} {row['lost']} of {row['published']} {row['what']}"
            for row in result.counts)  # fmt: skip
    shown.caption = f"{result.verdicts} diagnoses ended in {BUSY:g} s; lost: {', '.join(lost)}"
    return shown
