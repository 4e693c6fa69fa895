"""Recordings that tell together which effect is missing, where the first one alone does not."""

import numpy as np
import pytest

import tissue_probe as tp

GIVEN = {
    "rig": "rigid_probe",
    "constants": {"tip_mass": (0.0, 0.0), "contact_position": (0.0, 0.0)},
}


def triangles(lasts, seed, stiffness=800.0, friction=0.1):
    """Return cycles of straight lines, one speed in all of them, in tissue with dry friction."""
    period = lasts / 80.0
    time = np.arange(400) * period
    phase = np.mod(time / lasts + 0.003, 1.0)
    position = 2e-3 * (1.0 - np.abs(2.0 * phase - 1.0))
    speed = np.where(phase < 0.5, 1.0, -1.0) * 4e-3 / lasts
    force = stiffness * position + 20.0 * speed + friction * np.sign(speed)
    noise = 5e-3 * np.random.default_rng(seed).standard_normal(time.size)
    return tp.read({"t": time, "u": position, "F": force + noise}, force_polarity="compression")


@pytest.fixture(scope="module")
def at_two_speeds():
    return tp.diagnose(triangles(1.0, 0), validate=triangles(5.0, 1), **GIVEN)


def test_dry_friction_at_one_speed_in_each_recording_is_told_by_both(at_two_speeds):
    assert (at_two_speeds.verdict, at_two_speeds.effects) == ("missing", ("coulomb_friction",))
    named = at_two_speeds.found.ladder.final.named()
    assert named["coulomb_force"] == pytest.approx(0.1, rel=0.05)
    assert named["damping"] == pytest.approx(20.0, rel=0.2)


def test_that_none_is_left_to_try_the_result_on_is_told(at_two_speeds, tmp_path):
    assert any("all were fitted together" in note for note in at_two_speeds.notes)
    assert len(at_two_speeds.fitted.parts) == 2
    assert not at_two_speeds.validated.parts
    at_two_speeds.save(tmp_path)
    assert "all were fitted together" in (tmp_path / "report.html").read_text(encoding="utf-8")


@pytest.mark.battery
def test_a_specimen_of_another_stiffness_is_no_effect():
    other = triangles(1.0, 1, stiffness=880.0, friction=0.0)
    result = tp.diagnose(triangles(1.0, 0, friction=0.0), validate=other, **GIVEN)
    assert result.verdict == "unexplained"
    assert "explains this recording, and not the second one" in result.text
    assert "no effect of the library explains both" in result.text
    assert result.validated.parts


def test_effects_that_are_asked_for_are_tried_on_the_second_recording_only():
    other = triangles(5.0, 1)
    result = tp.diagnose(triangles(1.0, 0), validate=other, add=["channel_delay"], **GIVEN)
    assert result.effects == ("channel_delay",)
    assert result.validated.parts
