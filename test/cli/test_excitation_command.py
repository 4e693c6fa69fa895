"""What can be known before a run, as the command tells it."""

from __future__ import annotations

import re

import pytest

from tissue_probe.cli.excitation import compute_bound, time_to_know
from tissue_probe.excitation import EXCITATIONS, Sine


@pytest.mark.parametrize(
    ("time", "stiffness", "damping"),
    [(0.015, 2.5, 0.0176), (0.02, 1.6, 0.015), (0.05, 0.75, 0.0097), (0.2, 0.375, 0.0056)],
)
def test_the_bound_is_that_of_an_independent_computation(time, stiffness, damping):
    limit = compute_bound(Sine(amplitude=1e-3), 450.0, 5.0, time, 0.005, force_offset=False)
    assert limit.stiffness[-1] == pytest.approx(stiffness, rel=0.025)
    assert limit.damping[-1] == pytest.approx(damping, rel=0.025)


def test_five_per_cent_can_be_known_after_eleven_milliseconds():
    limit = compute_bound(Sine(amplitude=1e-3), 450.0, 5.0, 0.1, 0.005, force_offset=False)
    assert time_to_know(limit.stiffness, 450.0) == pytest.approx(0.011, abs=0.0011)


def test_an_unknown_zero_of_the_load_cell_delays_what_can_be_known(run):
    def known(*arguments):
        said = run("excitation", *arguments).out
        return float(re.search(r"k can be known to 5 % .* after (\S+) ms", said)[1])

    assert known("--no-force-offset") < known()


@pytest.mark.drawn
def test_it_prints_the_times_up_to_the_duration_and_draws(run, tmp_path):
    said = run("excitation", "--duration", 0.1, "--output", "plan.svg").out
    rows = re.findall(r"^│\s+(\d+) │", said, re.M)
    assert rows == ["10", "20", "50", "100"]
    assert "plan.svg" in said
    assert "<svg" in (tmp_path / "plan.svg").read_text(encoding="utf-8")


@pytest.mark.parametrize("kind", EXCITATIONS)
@pytest.mark.drawn
def test_every_kind_of_excitation_can_be_judged(run, tmp_path, kind):
    outcome = run("excitation", "--kind", kind, "--duration", 0.05)
    assert outcome.status == 0
    assert (tmp_path / "excitation.png").stat().st_size > 10_000


def test_the_options_of_a_kind_change_what_can_be_known(run):
    slow = run("excitation", "--kind", "chirp", "--stop", 5, "--sweep-duration", 1).out
    fast = run("excitation", "--kind", "chirp", "--stop", 30, "--sweep-duration", 1).out
    assert slow != fast


def test_a_coil_at_rest_tells_nothing(run):
    said = run("excitation", "--amplitude", 0).out
    assert said.count("not within this time") == 2
    assert "nan" not in said


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (["--kind", "square"], "give one of sine, stepped_sweep, chirp, multisine"),
        (["--frequency", -1], "excitation.frequency is -1.0: give a number from 0.01"),
        (["--kind", "chirp", "--frequency", 3], "there is no excitation.frequency"),
        (["--kind", "chirp", "--start", 9, "--stop", 3], "stop is 3 Hz"),
        (["--output", "plan.docx"], "docx"),
        (["--output", "nowhere/plan.png"], "nowhere"),
    ],
)
def test_a_mistake_is_told_in_one_sentence(fails, arguments, what):
    assert what in fails("excitation", *arguments)


@pytest.mark.parametrize("option", ["--stiffness", "--damping", "--duration", "--force-noise"])
def test_what_cannot_be_negative_is_refused(run, option):
    outcome = run("excitation", option, -1)
    assert outcome.status == 2
    assert option in outcome.err


def test_the_help_shows_units(run):
    said = run("excitation", "--help").out
    for unit in ("[m]", "[Hz]", "[s]", "[N]", "[N/m]", "[N s/m]"):
        assert unit in said
