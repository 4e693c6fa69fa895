"""``compare``, ``diagnose`` and ``improve`` on recordings of the challenge."""

from __future__ import annotations

import html
import io
import json
import re
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

import tissue_probe as tp
from tissue_probe.analysis import kept_files
from tissue_probe.analysis.comparing import ComparisonResult
from tissue_probe.challenge.folder import write_recordings
from tissue_probe.challenge.simulator import make_challenge
from tissue_probe.diagnosis.answer import Answer
from tissue_probe.diagnosis.fitting import search
from tissue_probe.physics import library
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.model_file import save

#: The kernels of every effect are compiled where no earlier run has done so.
pytestmark = pytest.mark.timeout(900)

HIDDEN = "cubic_stiffening"
MINE = Path(__file__).parents[2] / "docs" / "my_effect.py"
PROBE = ("--rig", "compliant_probe")
RESTED = ("--starts", "at-rest", *PROBE)


@pytest.fixture(scope="module")
def made():
    return make_challenge(11, (HIDDEN,), "sine10", "tolerant", 2e-3)


@pytest.fixture
def recorded(tmp_path, made):
    """Write both recordings as tables, and the first as a bag; return its table."""
    write_recordings(tmp_path, "data", made, "csv")
    write_recordings(tmp_path, "bag", made, "mcap")
    return tmp_path / "data.csv"


@pytest.fixture(autouse=True)
def effects_that_are_tried(request):
    """A few, but where the test is of the whole library."""
    if request.node.get_closest_marker("whole_library") is None:
        request.getfixturevalue("few")


@pytest.fixture(scope="module")
def kept_folder(made, tmp_path_factory):
    """What ``improve --add`` leaves of the first recording; only to be read."""
    folder = tmp_path_factory.mktemp("improved")
    write_recordings(folder, "data", made, "csv")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(library, "effects", lambda files=(): {HIDDEN: EFFECTS[HIDDEN]})
        tp.improve(
            folder / "data.csv", add=[HIDDEN], rig="compliant_probe", starts="at-rest",
            output=folder / "improved",
        )  # fmt: skip
    return folder / "improved"


@pytest.fixture
def improved(kept_folder, tmp_path):
    """The same beside a test's recordings, as ``improved``."""
    shutil.copytree(kept_folder, tmp_path / "improved")


def said(text):
    """Return what was printed without its line breaks."""
    return " ".join(text.split())


@pytest.mark.whole_library
def test_the_table_with_forces_in_tension_and_the_bag_get_the_same_answer(run, recorded, tmp_path):
    table = np.loadtxt(recorded, delimiter=",", skiprows=1) * [1.0, 1.0, -1.0]
    np.savetxt("data.csv", table, delimiter=",", header="t,u,F", comments="", fmt="%.17g")
    named = ("--position", "u", "--force", "F", "--force-polarity", "tension")
    outcome = run("diagnose", "data.csv", *named, *RESTED, "--json", "out.json")
    assert outcome.status == 0, outcome.err
    again = run("diagnose", "bag.mcap", *RESTED, "--json", "bag.json")
    assert again.status == 0, again.err
    texts = ((tmp_path / name).read_text() for name in ("out.json", "bag.json"))
    told, other = map(Answer.model_validate_json, texts)
    assert told.effects == other.effects == [HIDDEN]
    # A form that bends alike remains possible.
    assert told.verdict == other.verdict
    assert told.verdict in ("missing", "ambiguous")
    assert told.families["stiffening"] > 0.95
    assert told.ranking[0].effect == HIDDEN
    assert [each.effect for each in told.ranking[:3]] == [each.effect for each in other.ranking[:3]]
    assert told.rmse.training.final == pytest.approx(other.rmse.training.final, rel=1e-3)
    assert told.noise_floor == pytest.approx(5e-3, rel=0.1)
    assert "held out [mN]" in outcome.out
    assert f"{HIDDEN} ({'probability ' * (told.verdict == 'missing')}0.9" in said(outcome.out)
    assert max(map(len, outcome.out.splitlines()[:12])) <= 80


@pytest.mark.drawn
def test_improve_leaves_model_pictures_and_report_and_the_held_out_error_falls(
    run, recorded, tmp_path
):
    outcome = run(
        "improve", "data.csv", *RESTED, "--add", HIDDEN, "--validate", "data_second.csv",
        "--json", "out.json", "--output", "better",
    )  # fmt: skip
    assert outcome.status == 0, outcome.err
    files = {path.name: path for path in (tmp_path / "better").iterdir()}
    pictures = {"story.png", "ladder.png", "compare.png"}
    assert set(files) == {"model.yaml", "report.html", *pictures}
    model = yaml.safe_load(files["model.yaml"].read_text())
    assert [each["name"] for each in model["effects"]] == [HIDDEN]
    way = tp.read(tmp_path / "data.csv", force_polarity="compression").parts[0].recording.position
    assert (model["data"]["lowest"], model["data"]["highest"]) == (way.min(), way.max())
    assert 0.0 < model["data"]["fastest"] < 1.0
    for name in pictures:
        assert files[name].read_bytes().startswith(b"\x89PNG")
    page = files["report.html"].read_text(encoding="utf-8")
    assert HIDDEN in page
    assert "<math" in page
    assert re.search(r"<msub><mi>k</mi>(?:<mrow>)?<mn>3", page)
    assert "<td>cubic stiffness</td>" in page
    assert not re.search(r'<(?:script|link|img)[^>]*(?:src|href)="http', page)
    told = json.loads((tmp_path / "out.json").read_text())
    assert told["effects"] == [HIDDEN]
    assert told["rmse"]["heldout"]["final"] < 0.3 * told["rmse"]["heldout"]["base"]
    assert "held out [mN]" in outcome.out
    assert "+- 95 % intervals" in outcome.out
    assert "did not settle" not in outcome.out
    assert "carry over" not in outcome.out
    (cells,) = re.findall(r"│ stiffness +│(.*)│ N/m", outcome.out)
    assert len(re.findall(r"\d+(?:\.\d+)? \+-", cells)) == 2  # of the base, and with the effect
    again = run("compare", "data.csv", *RESTED, "--model", "better/model.yaml")
    assert again.status == 0, again.err
    ratio = float(re.search(r"error over noise +([\d.]+) times", again.out)[1])
    assert ratio < 1.1
    head, first, *_ = again.out.splitlines()
    assert head.startswith("Asked: rig compliant_probe, tissue kelvin_voigt, ")
    assert head.endswith(", model better/model.yaml.")
    assert first == f"Kelvin-Voigt + {HIDDEN}, values held, as in better/model.yaml:"
    assert "held-out" not in again.out


def test_the_equations_say_when_contact_comes_and_goes():
    contact = Composition().plus(EFFECTS["contact_loss"].plain)
    rates = len(contact.model.states)
    *_, force, leaves, touches = equations = kept_files.equations(contact)
    assert len(equations) == rates + 3
    assert force.startswith("F = ")
    assert leaves == r"\text{touching}: \; 1 \to 0 \text{ as soon as } x < 0"
    assert touches == r"\text{touching}: \; 0 \to 1 \text{ as soon as } - x < 0"


def test_the_live_filter_predicts_the_same_recording_better_on_the_improved_model(
    run, recorded, improved
):
    innovations = []
    for model in ((), ("--model", "improved/model.yaml")):
        asked = ("--estimator", "ekf", "--output", "estimates.csv")
        outcome = run("estimate", "data.csv", *asked, *model)
        assert outcome.status == 0, outcome.err
        table = np.genfromtxt("estimates.csv", delimiter=",", names=True)
        late = table["innovation"][table.size // 2 :]
        innovations.append(np.sqrt(np.mean(late**2)))
        Path("estimates.csv").unlink()
    plain, improved = innovations
    assert improved < 0.3 * plain
    assert improved < 1.15 * 5e-3  # the noise


@pytest.mark.drawn
def test_compare_prints_the_error_beside_the_noise_and_where_it_is(run, recorded, tmp_path):
    outcome = run("compare", "data.csv", *RESTED, "--output", "where.svg")
    assert outcome.status == 0, outcome.err
    for words in ("mN rms", "% of the force's rms", "noise floor", "error over noise", "Here: "):
        assert words in outcome.out
    assert float(re.search(r"error over noise +([\d.]+)", outcome.out)[1]) > 2.0
    assert re.search(r"stiffness +\d+(\.\d+)? \+- [\d.]+ N/m", outcome.out)
    assert (tmp_path / "where.svg").read_text().lstrip().startswith("<?xml")


@pytest.fixture(scope="module")
def relaxing():
    return make_challenge(12, ("standard_linear_solid",), "msine60", "tolerant", 2e-3)


@pytest.mark.parametrize(
    ("tissue", "own"),
    [
        ("maxwell", {"stiffness", "damping"}),
        ("standard_linear_solid", {"stiffness", "relaxing_stiffness", "relaxation_rate"}),
        ("generalized_maxwell", {"stiffness", "relaxing_stiffness_1", "relaxing_stiffness_2"}),
    ],
)
def test_every_tissue_of_the_papers_table_is_compared(run, tmp_path, relaxing, tissue, own):
    write_recordings(tmp_path, "data", relaxing, "csv")
    asked = ("data.csv", *RESTED, "--tissue", tissue)
    outcome = run("compare", *asked)
    assert outcome.status == 0, outcome.err
    names = re.findall(r"^  (\w+) +\S+ \+- ", outcome.out, re.M)
    assert own <= set(names)
    assert len(names) == len(set(names))


def test_the_model_with_a_tissue_of_its_own_is_kept(run, tmp_path, relaxing):
    tissue = "standard_linear_solid"
    write_recordings(tmp_path, "data", relaxing, "csv")
    outcome = run("improve", "data.csv", *RESTED, "--tissue", tissue, "--add", "mains_hum")
    assert outcome.status == 0, outcome.err
    model = yaml.safe_load((tmp_path / "improved" / "model.yaml").read_text())
    assert model["tissue"] == tissue
    assert [each["name"] for each in model["effects"]] == ["mains_hum"]
    again = run("compare", "data.csv", *RESTED, "--model", "improved/model.yaml")
    assert again.status == 0, again.err


def test_the_branch_of_a_standard_linear_solid_is_what_it_is_as_an_effect(run, tmp_path, relaxing):
    write_recordings(tmp_path, "data", relaxing, "csv")
    tissue = run("compare", "data.csv", *RESTED, "--tissue", "standard_linear_solid")
    effect = run("improve", "data.csv", *RESTED, "--add", "standard_linear_solid")
    found = [
        float(re.findall(r"relaxing_stiffness[^\d\n]*([\d.]+)", outcome.out)[-1])
        for outcome in (tissue, effect)
    ]
    assert found[0] == pytest.approx(found[1], rel=1e-3)
    (hidden,) = relaxing.answer.parameters["standard_linear_solid"]["branch_stiffness"]
    assert found[0] == pytest.approx(hidden, rel=0.05)


def test_a_tissue_with_its_own_relaxation_is_not_diagnosed_with_another(run, tmp_path, relaxing):
    write_recordings(tmp_path, "data", relaxing, "csv")
    outcome = run(
        "diagnose", "data.csv", *RESTED, "--tissue", "standard_linear_solid", "--json", "out.json"
    )
    assert outcome.status == 0, outcome.err
    told = json.loads((tmp_path / "out.json").read_text())
    assert told["verdict"] == "adequate"
    assert "relaxation" not in {each["family"] for each in told["ranking"]}


def test_compare_leaves_out_the_samples_that_diagnose_leaves_out(run, recorded, tmp_path):
    rows = np.loadtxt(recorded, delimiter=",", skiprows=1)
    rows[100::200, 2] += 3.0
    np.savetxt("data.csv", rows, delimiter=",", header="t,u,F", comments="", fmt="%.17g")
    outcome = run("compare", "data.csv", *RESTED)
    whole = run("diagnose", "data.csv", *RESTED, "--json", "out.json")
    assert outcome.status == whole.status == 0
    assert "note: data.csv" in outcome.out
    error = float(re.search(r"error +([\d.]+) mN rms", outcome.out)[1])
    told = json.loads((tmp_path / "out.json").read_text())
    assert error == pytest.approx(1e3 * told["rmse"]["training"]["base"], rel=1e-3)


def test_what_was_asked_for_is_not_said_of_the_library(run, recorded):
    outcome = run("improve", "data.csv", *RESTED, "--add", "force_lag")
    assert outcome.status == 0, outcome.err
    words = said(outcome.out)
    assert "with force_lag more is left than noise; other effects were not tried" in words
    assert "no effect of the library" not in words


def test_the_error_over_the_noise_is_the_quotient_of_what_is_printed(run, recorded):
    told = run("compare", "data.csv", *RESTED).out
    error, noise = (
        float(re.search(rf"{name} +([\d.]+) mN", told)[1]) for name in ("error", "noise floor")
    )
    said = re.search(r"  error over noise +([\d.]+) times the noise, [\d.]+ times where (.*)", told)
    assert float(said[1]) == pytest.approx(error / noise, rel=0.01)
    assert said[2].startswith("known 1/f noise")


def test_a_value_at_the_limit_of_its_tolerance_is_marked_and_explained(run, recorded):
    heavy = ("--constant", "tip_mass=0.06+-0.0001")
    told = run("compare", "data.csv", *RESTED, *heavy).out
    assert re.search(r"tip_mass +0\.0596 \+- \S+ kg, at its limit", told)
    assert not re.search(r"stiffness .*, at its limit", told.replace("load_cell_stiffness", ""))
    assert "of the rig's constants 4 standard deviations of the tolerance off" in told


def test_of_several_stretches_the_worst_is_shown_and_named_with_its_error(
    run, recorded, tmp_path, monkeypatch
):
    table = np.loadtxt(recorded, delimiter=",", skiprows=1)
    np.savetxt(
        "gap.csv", np.delete(table, slice(1000, 1200), axis=0), delimiter=",", header="t,u,F",
        comments="",
    )  # fmt: skip
    named = ("--force-polarity", "compression", *RESTED)
    told = said(run("compare", "gap.csv", *named).out)
    assert "gap.csv, part 2 (stretch 2 of 2, most of the squared error over noise)" in told
    assert re.search(r"the error in it is [\d.]+ mN rms", told)
    monkeypatch.setattr(kept_files, "REPORT_SAMPLES", 1000)
    outcome = run("improve", "gap.csv", *named, "--add", HIDDEN, "--output", "better")
    assert outcome.status == 0, outcome.err
    page = (tmp_path / "better" / "report.html").read_text(encoding="utf-8")
    assert "Measured and predicted: gap.csv, part 2 (stretch 2 of 2" in page
    assert "(drawn: the first 0.5 of 1.4 s)" in page


def test_what_was_done_to_read_a_file_is_told_in_the_report_and_the_answer_too(
    run, recorded, tmp_path
):
    for name in ("data.csv", "data_second.csv"):
        rows = np.loadtxt(name, delimiter=",", skiprows=1)
        rows[500:502, 2] = np.nan  # filled in
        rows[1000:1100, 2] = np.nan  # cut out
        np.savetxt(name, rows, delimiter=",", header="t,u,F", comments="", fmt="%.17g")
    named = ("--force-polarity", "compression", *RESTED, "--json", "out.json")
    outcome = run("improve", "data.csv", *named, "--add", HIDDEN, "--validate", "data_second.csv")
    assert outcome.status == 0, outcome.err
    notes = re.findall("^note: (.*)$", outcome.out, re.M)
    for words in ("filled in by a cubic spline", "cut out there"):
        assert sum(words in note for note in notes) == 2
    told = json.loads((tmp_path / "out.json").read_text())["findings"]
    page = html.unescape((tmp_path / "improved" / "report.html").read_text(encoding="utf-8"))
    for note in notes:
        assert note in told
        assert f"<li>{note}</li>" in page
    assert run("compare", "data.csv", *named).status == 0
    told = json.loads((tmp_path / "out.json").read_text())["findings"]
    assert set(told) < set(notes)


def test_what_is_wrong_with_samples_is_told_of_the_file_where_it_is(run, recorded):
    rows = np.loadtxt("data_second.csv", delimiter=",", skiprows=1)
    rows[700:760, 2] = rows[700, 2]
    np.savetxt("stuck.csv", rows, delimiter=",", header="t,u,F", comments="", fmt="%.17g")
    named = ("--force-polarity", "compression", *RESTED, "--json", "out.json")
    outcome = run("diagnose", "data.csv", "stuck.csv", *named)
    assert outcome.status == 0, outcome.err
    (told,) = json.loads(Path("out.json").read_text())["findings"]
    assert told.startswith("stuck.csv: ")
    assert f"note: {told}" in outcome.out.splitlines()


def test_a_model_that_fails_on_the_second_recording_is_told(run, recorded, tmp_path):
    other = make_challenge(12, (HIDDEN,), "sine10", "tolerant", 2e-3)
    write_recordings(tmp_path, "other", other, "csv")
    added = ("improve", "data.csv", *RESTED, "--add", HIDDEN, "--validate")
    told = run(*added, "other.csv").out
    assert "the model does not carry over" in told
    assert "the model does not carry over" in (tmp_path / "improved" / "report.html").read_text()


def test_a_verdict_by_a_fit_that_did_not_settle_says_so(run, recorded, tmp_path, monkeypatch):
    added = ("improve", "data.csv", *RESTED, "--add", HIDDEN)
    monkeypatch.setattr(search, "SEARCH_STEPS", 1)
    told = run(*added).out
    assert "(did not settle)" in told
    assert "But the fit of the last model did not settle" in told
    page = (tmp_path / "improved" / "report.html").read_text()
    assert "%. The fit did not settle." in page
    assert f"<b>{HIDDEN}</b> (gave up or did not settle)" in page
    assert "the numbers are a guess, no result" in page
    model = yaml.safe_load((tmp_path / "improved" / "model.yaml").read_text())
    assert model["data"]["converged"] is False
    told = run("compare", "data.csv", *RESTED, "--model", "improved/model.yaml").out
    assert "note: improved/model.yaml: the search for its values did not settle" in told


def test_searches_that_did_not_settle_are_marked_in_the_ranking(
    run, recorded, tmp_path, monkeypatch
):
    asked = ("diagnose", "data.csv", *RESTED, "--json", "out.json")
    monkeypatch.setattr(search, "SEARCH_STEPS", 3)
    told = run(*asked).out
    ranking = json.loads((tmp_path / "out.json").read_text())["ranking"]
    unsettled = {each["effect"] for each in ranking if not each["converged"]}
    assert unsettled
    # Those that nothing is said of are folded away.
    shown = set(re.findall(r"│ (?:\* )?(\w+) +│", told)) - {"none"}
    assert not shown & unsettled
    assert f"The search gave up for {len(unsettled)} effects" in told


def test_an_effect_of_ones_own_can_be_added(run, recorded, tmp_path):
    outcome = run("improve", "data.csv", *RESTED, "--effects", MINE, "--add", "quadratic_drag")
    assert outcome.status == 0, outcome.err
    assert "+ quadratic_drag" in said(outcome.out)
    assert "quadratic_drag" in (tmp_path / "improved" / "model.yaml").read_text()


TIME = np.arange(4000) * 5e-4
WAVE = 1e-3 * np.sin(2 * np.pi * 10.0 * TIME)
NOISE = 5e-3 * np.random.default_rng(0).standard_normal(TIME.size)
FORCE = 450.0 * WAVE + NOISE
PRESSED = 2e-3 + WAVE + 5e-4 * np.sin(2 * np.pi * 3.0 * TIME)


def table(position, force, time=TIME):
    rows = np.column_stack([time, position, force])
    lines = (",".join("" if np.isnan(v) else f"{v:.12g}" for v in row) for row in rows)
    return "t,u,F\n" + "\n".join(lines) + "\n"


BAD = {
    "too short": (
        table(WAVE[:60], FORCE[:60], TIME[:60]),
        "60 samples without a gap, which tell nothing",
    ),
    "no motion": (table(1e-3 + 0.0 * WAVE, FORCE), "position"),
    "no contact": (table(WAVE, FORCE - 450.0 * WAVE), "contact"),
    "constant force": (table(WAVE, 0.0 * FORCE), "force"),
    "wrong polarity": (table(PRESSED, NOISE - 450.0 * PRESSED), "--force-polarity"),
    "no numbers": (table(np.nan * WAVE, FORCE), "column u, the position, has no number"),
    "uneven times": (table(WAVE[::7], FORCE[::7], TIME[::7] ** 3), "irregularly"),
}


@pytest.mark.parametrize("what", BAD)
@pytest.mark.parametrize("command", ["compare", "diagnose", "improve"])
def test_worthless_measurements_get_one_sentence(fails, tmp_path, command, what):
    content, word = BAD[what]
    (tmp_path / "bad.csv").write_text(content)
    assert word in fails(command, "bad.csv", *RESTED)


def test_doubtful_measurements_are_compared_with_a_note(run, tmp_path):
    (tmp_path / "doubtful.csv").write_text(table(1e-4 * WAVE, FORCE))
    outcome = run("compare", "doubtful.csv", *PROBE)
    assert outcome.status == 0, outcome.err
    (note,) = [line for line in outcome.out.splitlines() if line.startswith("note: doubtful.csv: ")]
    assert "unit" in note


AIR = -0.04 * (20 * np.pi) ** 2 * WAVE + NOISE


def test_a_tip_that_touches_nothing_is_told_with_the_answer_for_programs(run, tmp_path):
    (tmp_path / "air.csv").write_text(table(WAVE, AIR))
    outcome = run("improve", "air.csv", *PROBE, "--add", HIDDEN, "--json", "out.json")
    assert outcome.status == 0, outcome.err
    note = [line for line in outcome.out.splitlines() if line.startswith("note: ")][-1]
    assert "No contact: the tip seems to touch nothing" in note
    told = json.loads((tmp_path / "out.json").read_text())
    assert told["findings"][-1] == note.removeprefix("note: ")


@pytest.mark.parametrize("command", ["compare", "diagnose", "improve"])
def test_of_others_measurements_the_rig_must_be_given(fails, recorded, command):
    told = fails(command, "data.csv")
    assert "nobody said which rig measured this: give --rig " in told
    assert all(f"{name} " in told for name in ("compliant_probe", "rigid_probe", "force_driven"))


def test_the_suites_own_recording_knows_its_rig(run, recorded):
    outcome = run("compare", "bag.mcap")
    assert outcome.status == 0, outcome.err
    assert "Asked: rig compliant_probe, tissue kelvin_voigt." in outcome.out


def test_a_force_that_no_model_follows_is_told(run, tmp_path):
    quick = 1e-3 * np.sin(2 * np.pi * (1.0 + 7.0 * TIME) * TIME)
    (tmp_path / "other.csv").write_text(table(quick, np.sin(2 * np.pi * 33.3 * TIME) + NOISE))
    outcome = run("compare", "other.csv", *PROBE)
    assert outcome.status == 0, outcome.err
    (followed,) = [line for line in outcome.out.splitlines() if line.startswith("note: ")]
    assert "cannot follow the force at all" in followed
    assert "--force-unit" in followed


def test_the_answer_is_out_before_the_picture_is_drawn(run, csv, monkeypatch):
    """A pipe would hold it back while the picture is drawn, which takes longer than the fit."""
    out = []

    class Pipe(io.StringIO):
        def flush(self):
            out.append(self.getvalue())

    def drawn(_):
        assert "noise floor" in out[-1]
        raise SystemExit(7)

    monkeypatch.setattr(ComparisonResult, "plot", drawn)
    path = csv()
    monkeypatch.setattr(sys, "stdout", Pipe())
    assert run("compare", path, *PROBE, "--force-polarity", "compression").status == 7


def test_a_force_in_kilonewtons_that_is_called_newtons_is_told_with_the_size_it_is_taken_for(
    run, tmp_path
):
    (tmp_path / "kilo.csv").write_text(table(WAVE, 1e-3 * FORCE))
    outcome = run("compare", "kilo.csv", *PROBE)
    assert outcome.status == 0, outcome.err
    size, units = [line for line in outcome.out.splitlines() if line.startswith("note: ")]
    assert "which hardly any tissue has" in units
    assert "in force 0.001 times larger" in size


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("none.csv",), "No such file"),
        (("data.csv", "--force-unit", "stone"), "stone"),
        (("data.csv", "--constant", "mass=0.04"), "mass is no constant of compliant_probe"),
        (("data.csv", "--constant", "tip_mass=heavy"), "give NAME=VALUE"),
        (("data.csv", "--constant", "flicker_noise=-1"), "give its rms in newtons, 0 or more"),
        (("data.csv", "--constant", "tip_mass=0.1+--5"), "its standard deviation is -5; give 0"),
        (("data.csv", "--lowpass", "0"), "give a frequency from "),
        (("data.csv", "--topic", "/x"), "which has no topics and one clock: leave out --topic"),
        (("data.csv", "--clock", "stamps"), "leave out --clock"),
        (("data.csv", "--position", "F", "--force", "F"), "--position and --force are both F"),
        (("data.csv", "--position", "F"), "column F cannot be both the position and the force"),
        (("data.csv", "--effects", "none.py"), "no such file of effects"),
        (("data.csv", "--position", "depth"), "depth"),
    ],
)
def test_options_that_cannot_be_met_get_one_sentence(fails, recorded, arguments, words):
    assert words in fails("diagnose", *arguments)


@pytest.mark.parametrize("command", ["diagnose", "improve"])
def test_no_model_is_tried_on_what_it_is_fitted_to(fails, recorded, command):
    told = fails(command, "data.csv", "--validate", recorded)
    assert "is the fitted recording; give another recording of the same specimen" in told


@pytest.mark.parametrize("command", ["compare", "diagnose", "improve"])
@pytest.mark.parametrize("again", ["data.csv", "folder/../data.csv", "copy.csv"])
def test_a_recording_that_is_given_twice_is_refused(fails, recorded, tmp_path, command, again):
    (tmp_path / "folder").mkdir()
    shutil.copy(recorded, tmp_path / "copy.csv")
    told = fails(command, "data.csv", again)
    assert f"{again} has the same samples as data.csv, which would count twice" in told


def test_a_table_given_for_a_model_is_told_and_not_quoted(fails, recorded):
    told = fails("compare", "data.csv", "--model", "data.csv")
    assert "data.csv is not a model.yaml: " in told
    assert "t,u,F" not in told


@pytest.mark.parametrize(
    ("command", "option", "words"),
    [
        ("compare", ("-o", "none/x.png"), "no folder none; make it"),
        ("compare", ("-o", "x.doc"), "ends in .png, .svg or .pdf"),
        ("compare", ("--json", "none/x.json"), "no folder none; make it"),
        ("diagnose", ("--json", "none/x.json"), "no folder none; make it"),
        ("improve", ("--json", "none/x.json"), "no folder none; make it"),
        ("compare", ("--json", "."), "it is a folder; give the name of a file"),
        ("diagnose", ("--json", "."), "it is a folder; give the name of a file"),
        ("improve", ("--json", "."), "it is a folder; give the name of a file"),
        ("estimate", ("-o", "none/x.csv"), "no folder none; make it"),
        ("export", ("-o", "."), "it is a folder; give the name of a file"),
        ("map", ("-o", "x.doc"), "ends in .png, .svg or .pdf"),
        ("map", ("--json", "."), "it is a folder; give the name of a file"),
        ("map", ("--csv", "."), "it is a folder; give the name of a file"),
        ("map", ("--ply", "none/x.ply"), "no folder none; make it"),
        ("map", ("--report", "none/x.html"), "no folder none; make it"),
    ],
)
def test_a_file_that_cannot_be_written_is_told_before_anything_is_read(
    fails, command, option, words
):
    assert words in fails(command, "not-there.csv", *option)


def test_the_answer_of_compare_holds_the_model_that_it_prints(run, recorded, tmp_path, improved):
    held = yaml.safe_load((tmp_path / "improved" / "model.yaml").read_text())
    second = ("compare", "data_second.csv", "--force-polarity", "compression", *RESTED)
    told = run(*second, "--model", "improved/model.yaml", "--json", "out.json")
    assert told.status == 0, told.err
    compared = json.loads((tmp_path / "out.json").read_text())["compared"]
    printed = float(re.search(r"error +([\d.]+) mN", told.out)[1])
    assert 1e3 * compared["rmse_training"] == pytest.approx(printed, rel=1e-3)
    stiffness = held["parameters"]["stiffness"]["value"]
    assert compared["parameters"]["stiffness"]["value"] == pytest.approx(stiffness)


def test_an_improved_model_is_fitted_again_to_the_second_recording(
    run, recorded, tmp_path, improved
):
    begun = ("--model", "improved/model.yaml", *RESTED)
    outcome = run("improve", "data_second.csv", *begun, "--json", "out.json", "-o", "again")
    assert outcome.status == 0, outcome.err
    assert "Adequate: nothing is missing" in said(outcome.out)
    told = Answer.model_validate_json((tmp_path / "out.json").read_text())
    assert told.verdict == "adequate"
    assert [step.effects for step in told.ladder] == [[HIDDEN]]
    assert told.effects == []
    assert HIDDEN not in {each.effect for each in told.ranking}
    first, second = (
        yaml.safe_load((tmp_path / folder / "model.yaml").read_text())
        for folder in ("improved", "again")
    )
    assert second["effects"] == first["effects"]
    old, new = (each["parameters"]["stiffness"] for each in (first, second))
    assert new["value"] != old["value"]
    assert new["value"] == pytest.approx(old["value"], rel=0.05)
    assert f"Kelvin-Voigt + {HIDDEN}" in (tmp_path / "again" / "report.html").read_text()
    again = run("diagnose", "data_second.csv", *begun, "--json", "out.json")
    assert again.status == 0, again.err
    assert json.loads((tmp_path / "out.json").read_text())["verdict"] == "adequate"


def test_what_a_model_misses_is_sought_beside_its_effects(run, recorded, tmp_path):
    assert run("improve", "data.csv", *RESTED, "--add", "coulomb_friction").status == 0
    begun = ("--model", "improved/model.yaml", "--json", "out.json", *RESTED)
    outcome = run("diagnose", "data.csv", *begun)
    assert outcome.status == 0, outcome.err
    told = json.loads((tmp_path / "out.json").read_text())
    assert told["effects"] == [HIDDEN]
    assert told["ladder"][-1]["effects"] == ["coulomb_friction", HIDDEN]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--rig", "rigid_probe"), "--rig rigid_probe contradicts --model improved/model.yaml"),
        (("--tissue", "maxwell"), "is of a kelvin_voigt; leave out one of them"),
        (("--add", HIDDEN), f"--add {HIDDEN}: the model has it already"),
    ],
)
def test_what_contradicts_a_model_gets_one_sentence(
    run, fails, recorded, tmp_path, arguments, words
):
    model = Composition(effects=(EFFECTS[HIDDEN],))
    values = {entry.name: entry.default for entry in model.values}
    (tmp_path / "improved").mkdir()
    save(tmp_path / "improved" / "model.yaml", model, values, {})
    assert words in fails("improve", "data.csv", "--model", "improved/model.yaml", *arguments)


def test_a_model_with_an_effect_of_ones_own_is_fitted_again(run, recorded, tmp_path):
    mine = ("--effects", MINE)
    assert run("improve", "data.csv", *RESTED, *mine, "--add", "quadratic_drag").status == 0
    begun = ("--model", "improved/model.yaml", *RESTED, "--add", HIDDEN, "-o", "again")
    outcome = run("improve", "data.csv", *begun)  # the model names the file, but not the user
    assert outcome.status == 1
    assert "improved/model.yaml needs the effect 'quadratic_drag'" in outcome.err
    assert outcome.err.endswith("my_effect.py': a model file runs no code by itself, so, if you "
                                "trust that file, name it by --effects\n")  # fmt: skip
    outcome = run("improve", "data.csv", *begun, *mine)
    assert outcome.status == 0, outcome.err
    model = yaml.safe_load((tmp_path / "again" / "model.yaml").read_text())
    assert [each["name"] for each in model["effects"]] == ["quadratic_drag", HIDDEN]
    assert model["effects"][0]["file"].endswith("my_effect.py")


def test_compare_knows_effects_of_ones_own(run, recorded, tmp_path, monkeypatch):
    (mine,) = library.load_effects(MINE)
    asked = []

    def mine_alone(files=()):
        asked.extend(files)
        return {mine.name: mine}

    assert run("improve", "data.csv", *RESTED, "--effects", MINE, "--add", mine.name).status == 0
    monkeypatch.setattr(library, "effects", mine_alone)
    written = ("--json", "out.json", *RESTED)
    outcome = run("compare", "data.csv", "--effects", MINE, *written)
    assert outcome.status == 0, outcome.err
    told = Answer.model_validate_json((tmp_path / "out.json").read_text())
    assert [each.effect for each in told.ranking] == [mine.name]
    model = ("--model", "improved/model.yaml", "--effects", MINE)
    outcome = run("compare", "data.csv", *model, *written)
    assert outcome.status == 0, outcome.err
    told = Answer.model_validate_json((tmp_path / "out.json").read_text())
    assert told.compared.effects == told.ladder[0].effects == [mine.name]
    assert asked == [MINE, MINE]


@pytest.fixture
def hiding(monkeypatch):
    """Let the library be what a steady sine cannot show."""
    names = ("force_lag", "added_mass")
    monkeypatch.setattr(library, "effects", lambda files=(): {n: EFFECTS[n] for n in names})


def pasted(out):
    """Return the command line that was printed, and the notes below it."""
    lines = out.splitlines()
    (begin,) = [n for n, line in enumerate(lines) if line.startswith("The next experiment's comm")]
    return lines[begin + 1], said(" ".join(lines[begin + 2 :]))


def test_the_next_experiment_can_be_pasted_with_the_volts_of_the_recording(
    run, bag, tmp_path, hiding
):
    bag()
    outcome = run("diagnose", "run.mcap", "--site", "3", "--json", "out.json")
    assert outcome.status == 0, outcome.err
    line, notes = pasted(outcome.out)
    assert line.startswith("ros2 run tissue_probe driver --ros-args -r __ns:=/probe -p excitation.")
    assert "-p excitation.amplitude:=0.8" in line
    assert "the coil went 1.18 mm for each volt" in notes
    told = json.loads((tmp_path / "out.json").read_text())["suggested_excitation"]
    assert told["command"] == line
    assert said(" ".join(f"- {note}" for note in told["command_notes"])) == notes


def test_the_report_has_the_next_experiments_command_line(run, csv, tmp_path, hiding):
    csv()
    named = ("--force-polarity", "compression", *PROBE)
    outcome = run("improve", "measured.csv", *named)
    assert outcome.status == 0, outcome.err
    line, notes = pasted(outcome.out)
    assert line.endswith("-p excitation.amplitude:=0.85")
    assert "set excitation.amplitude so that the coil moves by about 1 mm" in notes
    page = (tmp_path / "improved" / "report.html").read_text(encoding="utf-8")
    assert f"<pre>{line}</pre>" in page
    assert "set excitation.amplitude so that the coil moves by about 1 mm" in page


def test_an_unknown_effect_is_told_with_those_that_are_known(fails, recorded):
    told = fails("improve", "data.csv", "--add", "magic")
    assert "--add magic: no such effect" in told
    assert HIDDEN in told


@pytest.fixture
def humming(tmp_path):
    """Two recordings of one specimen under the mains' hum."""
    found = make_challenge(700001, ("mains_hum",), "chirp60", "exact")
    write_recordings(tmp_path, "data", found, "csv")


def test_a_phase_is_found_anew_where_a_model_is_tried_on_another_run(run, humming):
    assert run("improve", "data.csv", *RESTED, "--add", "mains_hum").status == 0
    told = run("compare", "data_second.csv", *RESTED, "--model", "improved/model.yaml")
    assert told.status == 0, told.err
    assert float(re.search(r"error over noise +([\d.]+)", told.out)[1]) < 1.05


def test_the_mains_hum_across_a_gap_and_through_two_files(run, tmp_path, humming):
    rows = (tmp_path / "data.csv").read_text().splitlines()
    (tmp_path / "data.csv").write_text("\n".join(rows[:3001] + rows[3022:]))
    known = "--known-rig"
    told = run("improve", "data.csv", "data_second.csv", *RESTED, known, "--add", "mains_hum")
    assert told.status == 0, told.err
    assert re.search(r"│ hum_sine of run 2 +│", told.out)
    assert "hum_sine of run 3" not in told.out  # the parts of a file have one clock
    model = yaml.safe_load((tmp_path / "improved" / "model.yaml").read_text())
    assert not [name for name in model["parameters"] if "of run" in name]
    assert "of&#x000A0;run" in (tmp_path / "improved" / "report.html").read_text()


def test_advice_names_options_in_print_in_json_and_in_the_report(run, tmp_path):
    (tmp_path / "stiff.csv").write_text(table(PRESSED, 1e3 * (NOISE + 450.0 * PRESSED)))
    stated = ("--rig", "rigid_probe", "--force-polarity", "compression")
    outcome = run("improve", "stiff.csv", *stated, "--add", "force_bias", "--json", "out.json",
                  "--output", "out")  # fmt: skip
    assert outcome.status == 0, outcome.err
    page = (tmp_path / "out" / "report.html").read_text()
    told = json.loads((tmp_path / "out.json").read_text())
    for text in (outcome.out, " ".join(told["findings"]), page):
        assert "(--position-unit, --force-unit)" in " ".join(text.split())
