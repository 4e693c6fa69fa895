"""``compare``, ``diagnose`` and ``improve`` where a force drives and the position answers."""

from __future__ import annotations

import json
import re
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import yaml
from scipy.integrate import solve_ivp

#: The kernels of every effect are compiled where no earlier run has done so.
pytestmark = pytest.mark.timeout(900)

RATE, MASS, K, BETA, CUBIC = 2000.0, 0.08, 600.0, 6.0, 2e7
RIG = ("--rig", "force_driven", "--starts", "moving", "--force-polarity", "compression")
NAMED = ("data.csv", "--position", "x_um", "--force", "F_mN", *RIG)
SCHEMA = Path(__file__).parents[2] / "docs" / "diagnosis.schema.json"


@pytest.fixture(autouse=True)
def effects_that_are_tried(request):
    """A few, but where the test is of the whole library."""
    if request.node.get_closest_marker("whole_library") is None:
        request.getfixturevalue("few")


def push(time):
    return 1.0 + 0.5 * np.sin(31.0 * time) + 0.4 * np.sin(90.0 * time) + 0.3 * np.sin(170.0 * time)


@pytest.fixture(scope="module")
def table():
    """A tip that stiffens, begun at rest where it does not belong: it swings in."""

    def rates(time, state):
        x, v = state
        return [v, (push(time) - K * x - BETA * v - CUBIC * x**3) / MASS]

    times = np.arange(3000) / RATE
    solved = solve_ivp(rates, (0, times[-1]), [1e-3, 0], "DOP853", times, rtol=1e-9, atol=1e-12)
    position = solved.y[0] + 3e-7 * np.random.default_rng(0).standard_normal(times.size)
    return np.stack([times, 1e6 * position, 1e3 * push(times)], axis=1)


@pytest.fixture
def recorded(tmp_path, table):
    np.savetxt(
        tmp_path / "data.csv", table, delimiter=",", header="t,x_um,F_mN", comments="", fmt="%.9g"
    )


@pytest.mark.drawn
def test_compare_speaks_of_the_position(run, recorded, tmp_path):
    outcome = run("compare", *NAMED)
    assert outcome.status == 0, outcome.err
    assert "% of the position's rms about its mean" in outcome.out
    assert "m rms: the error that noise alone leaves" in outcome.out
    assert "mN" not in outcome.out
    assert (tmp_path / "compare.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.whole_library
def test_diagnose_names_what_is_missing_and_says_what_its_errors_are(run, recorded, tmp_path):
    outcome = run("diagnose", *NAMED, "--json", "out.json")
    assert outcome.status == 0, outcome.err
    assert "held out" in outcome.out  # its unit is below where names are long
    assert "[um]" in outcome.out
    assert "cubic_stiffening (" in outcome.out
    assert "mN" not in outcome.out
    told = json.loads((tmp_path / "out.json").read_text())
    assert told["ranking"][0]["effect"] == "cubic_stiffening"
    assert told["families"]["stiffening"] > 0.95
    jsonschema.validate(told, json.loads(SCHEMA.read_text(encoding="utf-8")))
    assert told["output"] == {"quantity": "position", "unit": "m"}
    assert told["ranking"][0]["effect"] == "cubic_stiffening"
    assert told["rmse"]["training"]["final"] == pytest.approx(3e-7, rel=0.1)
    assert told["noise_floor"] == pytest.approx(3e-7, rel=0.1)


def test_improve_leaves_a_model_that_compare_takes_and_whose_rig_it_knows(run, recorded, tmp_path):
    outcome = run("improve", *NAMED, "--add", "cubic_stiffening", "--output", "better")
    assert outcome.status == 0, outcome.err
    assert "error [um]" in outcome.out
    assert "mN" not in outcome.out
    model = yaml.safe_load((tmp_path / "better" / "model.yaml").read_text())
    assert model["rig"] == "force_driven"
    assert model["constants"]["tip_mass"]["value"] == pytest.approx(MASS, rel=0.01)
    assert model["parameters"]["cubic_stiffness"]["value"] == pytest.approx(CUBIC, rel=0.01)
    page = (tmp_path / "better" / "report.html").read_text(encoding="utf-8")
    words = page[page.rindex("</script>") :] + page[page.index("<h1>") : page.index("<h2>")]
    assert "mN" not in words
    assert "measured minus predicted position. The noise" in page
    assert "<br>[um]" in page
    assert '"name":"position","unit":"mm"' in page
    again = run("compare", *NAMED, "--model", "better/model.yaml")
    assert again.status == 0, again.err
    assert "Kelvin-Voigt + cubic_stiffening" in again.out
    assert re.search(r"error over noise +1\.\d+ times the noise", again.out)
    named = [word for word in NAMED if word not in ("--rig", "force_driven")]
    outcome = run("compare", *named, "--model", "better/model.yaml")
    assert outcome.status == 0, outcome.err
    assert "m rms: the error that noise alone leaves" in outcome.out


@pytest.mark.battery
def test_a_model_found_beside_noise_of_the_force_is_compared_beside_it(run, tmp_path, table):
    noise = 5.0 * np.random.default_rng(1).standard_normal(len(table))
    noisy = table + np.outer(noise, [0.0, 0.0, 1.0])
    named = {"header": "t,x_um,F_mN", "comments": "", "delimiter": ",", "fmt": "%.9g"}
    np.savetxt(tmp_path / "data.csv", noisy, **named)
    made = run("improve", *NAMED, "--add", "cubic_stiffening", "--output", "better")
    assert made.status == 0, made.err
    outcome = run("compare", *NAMED, "--model", "better/model.yaml")
    assert outcome.status == 0, outcome.err
    (ratio,) = re.findall(
        r"error over noise .* ([0-9.]+) times where the motion that noise of the force", outcome.out
    )
    assert float(ratio) == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--constant", "tip_mass=0"), "tip_mass of force_driven is more than 0 [kg]"),
        (("--constant", "load_cell_stiffness=9700"), "no constant of force_driven"),
    ],
)
def test_a_constant_that_makes_no_sense_is_told(run, recorded, options, told):
    outcome = run("diagnose", *NAMED, *options)
    assert outcome.status != 0
    assert told in " ".join(outcome.err.split())


def test_an_effect_on_what_the_rig_has_not_is_told(run, recorded):
    outcome = run("improve", *NAMED, "--add", "load_cell_stiffness_error")
    assert outcome.status != 0
    assert "acts on the load cell's spring, and force_driven has none" in " ".join(
        outcome.err.split()
    )
