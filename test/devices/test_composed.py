"""The simulated probe on a model file: as without it, as SciPy has it, as the fit's simulation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.integrate import solve_ivp

from tissue_probe.devices.device import DeviceError
from tissue_probe.devices.simulated import SimulatedProbe
from tissue_probe.devices.simulated_settings import SimulatedProbeSettings
from tissue_probe.excitation import Multisine, Sine
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.library import load_effects
from tissue_probe.physics.model_file import save
from tissue_probe.physics.response import course, respond
from tissue_probe.physics.tissues import TISSUES
from tissue_probe.settings import SettingsError

EXAMPLE = Path(__file__).parents[2] / "docs" / "my_effect.py"
PERIOD = 5e-4
SINES = Multisine(amplitude=1.0, start=5.0, stop=30.0, spacing=5.0)


def written(path, composition=None, **changes) -> str:
    """A model file of default values, some of them changed."""
    composition = composition or Composition()
    entries = composition.entries(map(str, composition.model.values))
    save(path, composition, {entry.name: entry.default for entry in entries} | changes, {})
    return str(path)


def run(device, excitation, *stages):
    """Position and force with the stage at each depth z [m] for so many samples."""
    device.place(0.0, 0.0, stages[0][0])
    device.start(excitation)
    taken = []
    for z, samples in stages:
        device.place(0.0, 0.0, z)
        taken.append(device.read(samples))
    return (np.concatenate([getattr(t, name) for t in taken]) for name in ("position", "force"))


def test_kelvin_voigt_tissue_from_a_file_is_that_of_the_probe_itself(probe, tmp_path):
    """In contact, lifted off the tissue, and back."""
    stages = ((-0.001, 200), (0.002, 200), (-0.0005, 200))
    position, force = run(probe(exact=True), SINES, *stages)
    path = written(tmp_path / "model.yaml")
    same_position, same_force = run(probe(exact=True, model=path), SINES, *stages)
    assert np.abs(force).max() > 0.3
    np.testing.assert_allclose(same_position, position, atol=1e-13)
    np.testing.assert_allclose(same_force, force, atol=1e-9)


def test_stiffening_tissue_is_as_scipy_has_it(probe, tmp_path):
    path = written(
        tmp_path / "model.yaml", Composition(effects=(EFFECTS["cubic_stiffening"],)),
        cubic_stiffness=3e8, stiffness=300.0,
    )  # fmt: skip
    device = probe(exact=True, model=path)
    samples, depth = 200, 0.001
    excitation = Sine(amplitude=2.0, frequency=20.0)
    position, force = run(device, excitation, (-depth, samples))
    s = device._settings

    def slope(t, y, voltage):
        i, u, v, x, w = y
        cell = 9700.0 * (u - x) + 0.8 * (v - w)
        h = x + depth
        return [
            (voltage - s.coil_resistance * i - s.force_constant * v) / s.coil_inductance,
            v,
            (s.force_constant * i - s.bearing_damping * v - s.suspension_stiffness * u - cell)
            / s.coil_mass,
            w,
            (cell - 300.0 * h - 5.0 * w - 3e8 * h**3) / 0.04,
        ]

    y, expected = np.zeros(5), []
    for voltage in excitation(np.arange(samples) * PERIOD):
        expected.append((y[1], 9700.0 * (y[1] - y[3])))
        solution = solve_ivp(
            slope, (0, PERIOD), y, "DOP853", args=(voltage,), rtol=1e-10, atol=1e-15
        )
        y = solution.y[:, -1]
    expected = np.array(expected).T
    assert np.abs(position - expected[0]).max() < 2e-9
    assert np.abs(force - expected[1]).max() < 1e-5


SIMULATED = [
    "standard_linear_solid", "hertz_contact", "contact_loss", "coulomb_friction", "backlash",
    "structural_mode", "load_cell_stiffness_error", "tissue_motion", "force_lag", "mains_hum",
    "encoder_interpolation", "stiffness_ramp", "coulomb_friction 1", "stribeck_friction 1",
    "channel_delay", "maxwell",
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", SIMULATED)
def test_what_the_probe_measures_is_what_the_model_predicts(name, probe, tmp_path):
    """Two integrators on one model: with the coil's own motion, and with the motion given."""
    name, _, form = name.partition(" ")
    if name in TISSUES:
        composition = Composition(tissue=name)
    else:
        composition = Composition(effects=(EFFECTS[name].every_form[int(form or 0)],))
    path = written(tmp_path / "model.yaml", composition)
    position, force = run(probe(exact=True, model=path), SINES, (0.0, 600))
    kernel = composition.kernel
    values = np.array([entry.default for entry in composition.values])
    start = kernel.begin(values, 0.0, 0.0)
    predicted = respond(kernel, values, start, course(kernel, position, PERIOD, values)).output
    assert np.ptp(force) > 0.5
    # A spline through the coil's samples knows nothing of what its force does between them.
    assert np.sqrt(np.mean((predicted - force) ** 2)) < 2e-3 * np.sqrt(np.mean(force**2))


def test_the_phantom_tells_how_much_stiffer_a_place_is(tmp_path):
    nodule = {"x": 0.01, "y": 0.0, "depth": 0.0, "radius": 0.002, "stiffness_ratio": 3.0}
    phantom = tmp_path / "phantom.yaml"
    phantom.write_text(
        yaml.safe_dump(
            {"background_stiffness": 100.0, "background_damping": 1.0, "nodules": [nodule]}
        )
    )
    path = written(tmp_path / "model.yaml", stiffness=450.0, damping=5.0)
    settings = {"phantom": str(phantom), "force_noise": 0.0, "encoder_resolution": 0.0}
    device = SimulatedProbe(SimulatedProbeSettings(model=path, **settings))
    forces = []
    for x in (-0.02, 0.01):
        device.place(x, 0.0, -0.001)
        device.start(Sine(amplitude=0.0))
        forces.append(device.read(2000).force[-1])
    # At rest the suspension carries the tissue: F = s k d / (s + k + s k / k0).
    for force, k in zip(forces, (450.0, 1350.0), strict=True):
        assert force == pytest.approx(0.001 / (1 / k + 1 / 800.0 + 1 / 9700.0), rel=1e-3)


def test_the_encoders_steps_are_the_models(probe, tmp_path):
    composition = Composition(effects=(EFFECTS["encoder_quantization"],))
    path = written(tmp_path / "model.yaml", composition, encoder_step=2e-5)
    position, _ = run(probe(exact=True, model=path), SINES, (0.0, 200))
    steps = position / 2e-5
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    assert np.ptp(steps) > 10


def test_a_recording_tells_the_model(probe, tmp_path):
    path = written(tmp_path / "model.yaml")
    told = yaml.safe_load(probe(model=path).description)
    assert told["model"]["parameters"]["stiffness"]["value"] == 450.0
    assert told["phantom"]["background_stiffness"] == 450.0


def test_an_effect_of_ones_own_is_simulated_where_its_file_is_named(probe, tmp_path):
    composition = Composition(effects=load_effects(EXAMPLE))
    values = {entry.name: entry.default for entry in composition.values}
    save(tmp_path / "model.yaml", composition, values, {}, effect_files=[EXAMPLE])
    path = str(tmp_path / "model.yaml")
    with pytest.raises(SettingsError, match=r"quadratic_drag.*name it by `effects`"):
        probe(model=path)
    _, force = run(probe(exact=True, model=path, effects=[str(EXAMPLE)]), SINES, (0.0, 200))
    assert np.ptp(force) > 0.1


def test_what_cannot_be_simulated_is_refused_in_one_sentence(probe, tmp_path):
    for rig in ("rigid_probe", "force_driven"):
        other = written(tmp_path / "other.yaml", Composition(rig))
        with pytest.raises(DeviceError, match=f"the rig is {rig}"):
            probe(model=other)
    fast = written(tmp_path / "fast.yaml", load_cell_stiffness=1e7, tip_mass=1e-4)
    with pytest.raises(DeviceError, match="too short to simulate at real time"):
        probe(model=fast)
    (tmp_path / "none.yaml").write_text("version: 3\n")
    with pytest.raises(SettingsError, match="version is 3"):
        probe(model=str(tmp_path / "none.yaml"))
