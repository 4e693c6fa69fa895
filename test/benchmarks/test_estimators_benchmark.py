"""The tables on the estimators measure what they say; no time is asserted."""

import json
import math
from io import StringIO

import pytest
from rich.console import Console

from benchmarks import estimators, estimators_speed, machine, report
from tissue_probe.estimation import ESTIMATORS

pytestmark = pytest.mark.slow

FROM_ZERO = "from zero: within 5 % after, k, beta [ms]"
BIAS = "bias at 30 Hz, k, beta [%]"
OFFSET = "force offset 100 mN: bias (sd) [%]"


@pytest.fixture(scope="module")
def rows():
    return estimators.measure(
        range(3), rows={title: estimators.ROWS[title] for title in (FROM_ZERO, BIAS, OFFSET)}
    )


@pytest.fixture(scope="module")
def speed():
    return estimators_speed.measure()


def stiffness(cell: str) -> float:
    """The number that stands first in a cell: of k, the median."""
    return float(cell.replace("/", " ").replace(",", " ").split()[0])


def test_every_estimator_is_a_contestant_and_the_papers_stand_beside_them(rows):
    titles = [who.title for who in estimators.CONTESTANTS]
    assert set(titles) == {*ESTIMATORS, "paper EKF", "paper AFEKF"}
    for found in rows.values():
        assert list(found) == ["to reach", *titles]


def test_the_faults_that_are_known_of_the_papers_method_show(rows):
    # Forward Euler biases k at 30 Hz by 13 %; a constant force ruins a filter that has no
    # state for it.
    assert 5.0 < abs(stiffness(rows[BIAS]["paper EKF"])) < 20.0
    assert abs(stiffness(rows[BIAS]["robust_ekf"])) < 0.1
    assert abs(stiffness(rows[OFFSET]["paper EKF"])) > 1.0
    assert abs(stiffness(rows[OFFSET]["robust_ekf"])) < 0.05
    assert stiffness(rows[FROM_ZERO]["robust_ekf"]) < stiffness(rows[FROM_ZERO]["paper EKF"])


def test_what_never_settles_is_told_as_infinite():
    result = estimators.runs(estimators.CONTESTANTS[0], estimators.Experiment(duration=0.05), [3])
    assert math.isinf(result[0].settled(0.0, 0.05)[0])


def test_every_goal_is_that_of_something_measured(speed):
    assert set(estimators_speed.GOALS) <= set(speed)
    assert all(0.0 < value < math.inf for value in speed.values())


def test_the_tables_show_every_number_and_the_file_holds_them(rows, speed, tmp_path):
    results = {"machine": machine.describe(), "estimators": rows, "speed": speed}
    assert json.loads(report.keep(results, tmp_path).read_text()) == results
    console = Console(width=80, file=StringIO())
    report.show(results, console)
    shown = console.file.getvalue()
    assert "…" not in shown
    for who in estimators.CONTESTANTS:
        assert who.title in shown
    assert all(f"{value:.3g}" in shown for value in speed.values())
    assert "within 5 %" in shown
    assert "[ms]" in shown
