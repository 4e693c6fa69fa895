"""The ruler is right by itself: closed forms of its simulators, and records that run through."""

import ast
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import benchmarks
from benchmarks.protocols.catalogue import PROTOCOLS
from benchmarks.protocols.course import Held, Smooth
from benchmarks.protocols.course import Path as Straights
from benchmarks.protocols.deal import deal
from benchmarks.protocols.hidden import HIDDEN
from benchmarks.protocols.motion import COMPLIANT, DRIVEN, RIGID, Rig, simulate
from benchmarks.protocols.specimen import Specimen
from benchmarks.protocols.strength import LEAST, MOST
from benchmarks.ruler.marks import measure
from benchmarks.ruler.tables import tables

FOLDER = Path(benchmarks.__file__).parent
#: Who asks the public interface, and modules that share nothing with it.
ASKING = ("marks.py", "groups.py")
OWN = tuple(
    f"benchmarks.{name}" for name in ("ruler", "protocols", "third_party", "instrument", "start")
)
RAMP, RATE = 0.1, 2.0


def test_the_ruler_imports_of_tissue_probe_only_its_public_interface():
    for folder in ("ruler", "protocols", "third_party", "instrument"):
        for path in (FOLDER / folder).glob("**/*.py"):
            for name, module in imported(path):
                allowed = module == "tissue_probe" and path.name in ASKING
                own = module.startswith(OWN)
                known = not module.startswith(("tissue_probe", "benchmarks"))
                assert allowed or own or known, f"{path}: {name}"


def imported(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from ((alias.name, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module, node.module


def test_a_branch_relaxes_after_a_ramp_as_the_exponential_does():
    specimen = Specimen(100.0, 3.0, branch_stiffness=(300.0,), branch_rate=(RATE,))
    course = Straights([0.5, 0.5 + RAMP], [0.0, 1e-3], 0.02)
    times = np.linspace(1.0, 6.0, 200)
    found = simulate(Rig(RIGID), specimen, course, times, 0.0).force
    # Corners that are averaged over a symmetric kernel B: the exponential is multiplied by the
    # kernel's transform at i r, four moving averages of a width w, (sinh(r w / 2) / (r w / 2))^4.
    half = RATE * 0.02 / 4.0 / 2.0
    kernel = (np.sinh(half) / half) ** 4
    branch = 300.0 * 1e-3 / RAMP / RATE * np.expm1(RATE * RAMP) * kernel
    expected = 100.0 * 1e-3 + branch * np.exp(-RATE * (times - 0.5))
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_a_tip_creeps_under_a_held_force_as_the_matrix_exponential_says():
    specimen = Specimen(400.0, 8.0, 0.2, branch_stiffness=(300.0,), branch_rate=(0.4,))
    times = np.linspace(0.0, 5.0, 101)
    course = Held(np.array([-1.0, 0.0]), np.array([0.0, 0.5]))
    found = simulate(Rig(DRIVEN), specimen, course, times, -0.5).position
    motion = np.array([[0.0, 1.0, 0.0], [-2000.0, -40.0, -5.0], [0.0, 300.0, -0.4]])
    rest = np.array([0.5 / 400.0, 0.0, 0.0])
    expected = [(rest - expm(motion * time) @ rest)[0] for time in times]
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-6 * rest[0])


def test_a_load_cell_that_yields_answers_to_a_sine_as_its_transfer_function_does():
    frequency, cell, grip = 7.0, 9700.0, 0.8
    specimen = Specimen(600.0, 4.0, 0.04, branch_stiffness=(200.0,), branch_rate=(30.0,))
    course = Smooth(
        lambda t: 1e-3 * np.clip(t / 0.5, 0, 1) ** 4 * np.sin(2 * np.pi * frequency * t),
        0.0, 2.5, 4.0 * frequency,
    )  # fmt: skip
    times = np.linspace(2.0, 2.4, 300)
    found = simulate(Rig(COMPLIANT, cell, grip), specimen, course, times, 0.0).force
    s = 2j * np.pi * frequency
    tissue = 600.0 + 4.0 * s + 200.0 * s / (s + 30.0)
    tip = (cell + grip * s) / (0.04 * s**2 + grip * s + cell + tissue)
    expected = (cell * (1.0 - tip) * 1e-3 * np.exp(s * times)).imag
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.ptp(expected))


def test_dry_friction_holds_a_driven_tip_until_the_force_exceeds_it():
    specimen = Specimen(500.0, 5.0, 0.1, friction=0.3)
    course = Straights([0.0, 1.0, 2.0], [0.0, 1.0, 0.9], 1e-3)
    times = np.linspace(0.0, 2.0, 2001)
    found = simulate(Rig(DRIVEN), specimen, course, times, -0.1).position
    assert np.abs(found[times < 0.299]).max() == 0.0
    assert found[np.searchsorted(times, 0.35)] > 0.0
    # The force falls by less than twice the friction: the tip stays where it came to rest.
    assert np.ptp(found[times > 1.5]) < 1e-12
    assert abs(500.0 * found[-1] - 0.9) <= 0.3


def test_a_tip_from_the_air_feels_nothing_before_it_touches_and_no_pull_after():
    specimen = Specimen(500.0, 5.0, touch=1e-3, one_sided=True)
    course = Straights([0.0, 1.0, 2.0], [0.0, 3e-3, 0.0], 1e-2)
    times = np.linspace(0.0, 2.0, 2001)
    force = simulate(Rig(RIGID), specimen, course, times, 0.0).force
    assert np.all(force[course(times) <= 1e-3] == 0.0)
    assert np.all(force >= 0.0)
    assert force.max() == pytest.approx(500.0 * 2e-3, rel=0.02)


@pytest.mark.parametrize("protocol", ["relaxation", "palpation", "steps_held"])
def test_the_same_seed_deals_the_same_record_and_another_one_another(protocol):
    same, again, other = (deal(protocol, seed, False).first for seed in (5, 5, 6))
    np.testing.assert_array_equal(same.force, again.force)
    assert same.force.size != other.force.size or np.any(same.force != other.force)


@pytest.mark.parametrize("protocol", ["relaxation_at_once", "depth_series", "approach"])
def test_what_is_hidden_leaves_more_than_the_noise(protocol):
    truth = deal(protocol, 3, True).truth
    assert truth.hidden in PROTOCOLS[protocol].hides
    assert truth.ratio >= LEAST
    assert truth.ratio <= MOST or not HIDDEN[truth.hidden].measured


def test_true_values_leave_the_noise_that_a_record_tells():
    dealt = deal("sine", 500_001, False)
    record, values = dealt.first, dealt.truth.values
    assert set(values) == {"stiffness", "damping", "tip_mass", "contact_position"}
    # Without an encoder's noise the force is what the values make of the position.
    columns = [record.position, *derivatives(record)]
    left = record.force - np.stack(columns, -1) @ [
        values["stiffness"], values["damping"], values["tip_mass"],
    ]  # fmt: skip
    assert np.std(left[20:-20]) == pytest.approx(record.noise, rel=0.25)


def derivatives(record):
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(record.time, record.position)
    return spline(record.time, 1), spline(record.time, 2)


@pytest.mark.slow
def test_records_run_through_and_their_marks_are_told():
    dealt = [deal("noise", 500_001, False), deal("noise", 500_001, True)]
    said = []
    outcomes = measure(dealt, said.append)
    assert [outcome.hidden for outcome in outcomes] == ["", dealt[1].truth.hidden]
    assert len(said) == 2
    for outcome in outcomes:
        assert not outcome.refused
        assert outcome.error == pytest.approx(1.0, abs=0.5) or not outcome.right
    assert outcomes[0].intervals >= 2
    assert outcomes[1].intervals == 0
    first, by_hidden, sure = tables("Records", outcomes)
    assert first.row_count == by_hidden.row_count == 2
    assert "Brier's score" in sure.columns[0].cells
