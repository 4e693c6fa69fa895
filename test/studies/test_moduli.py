"""Storage and loss stand at the frequency that drives, and nowhere where several do."""

from __future__ import annotations

import numpy as np
import pytest
from laboratory import QUESTION

import tissue_probe as tp
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.fitted_model import FittedModel
from tissue_probe.studies.moduli import driving_frequency


@pytest.mark.parametrize("frequency", [2.0, 7.3, 10.0, 61.7])
def test_the_frequency_of_a_sine_is_found_between_the_bins(frequency):
    t = 5e-4 * np.arange(4000)
    assert driving_frequency(3.0 + np.sin(2 * np.pi * frequency * t + 0.4), 5e-4) == pytest.approx(
        frequency, rel=2e-3
    )


@pytest.mark.parametrize(
    "motion",
    [
        lambda t: sum(np.sin(2 * np.pi * f * t) for f in (3.0, 11.0, 27.0)),
        lambda t: np.sin(2 * np.pi * (5.0 + 20.0 * t) * t),
        lambda t: t,
        np.zeros_like,
    ],
)
def test_a_motion_of_several_frequencies_or_none_has_no_single_one(motion):
    assert driving_frequency(motion(5e-4 * np.arange(4000)), 5e-4) is None


def test_a_row_has_storage_and_loss(laboratory):
    row = tp.row(laboratory / "a_1.csv", "compare", **QUESTION)
    assert row["frequency"] == pytest.approx(5.0, rel=0.01)
    assert row["storage"] == row["stiffness"]
    assert row["loss"] == pytest.approx(2 * np.pi * 5.0 * 3.0, rel=0.05)


def test_other_tissue_has_no_storage_and_loss_of_a_spring_and_a_damper(laboratory):
    row = tp.row(laboratory / "a_1.csv", "compare", **QUESTION, tissue="maxwell")
    assert row["status"] == "done"
    assert not {"frequency", "storage", "loss"} & set(row)


def test_a_filter_whose_model_has_curved_tissue_tells_none(laboratory, tmp_path):
    composition = Composition(effects=(EFFECTS["cubic_stiffening"],))
    values = {each.name: each.default for each in composition.values}
    FittedModel(composition, values, {}).save(tmp_path / "model.yaml")
    asked = {"estimator": "robust_ekf", "model": str(tmp_path / "model.yaml")}
    row = tp.row(laboratory / "a_1.csv", "estimate", force_polarity="compression", **asked)
    assert row["status"] == "done", row["sentence"]
    assert not {"frequency", "storage", "loss"} & set(row)


@pytest.mark.parametrize(
    ("effect", "same"),
    [
        ("force_bias", True),
        ("added_mass", True),
        ("springpot", False),
        ("cubic_stiffening", False),
        ("contact_loss", False),
        ("stiffness_ramp", False),
    ],
)
def test_an_effect_of_the_instrument_leaves_the_tissue_as_it_is(effect, same):
    assert Composition(effects=(EFFECTS[effect],)).is_kelvin_voigt is same
