"""``tissue_probe estimate``: right numbers from CSV and from recordings, or one clear sentence."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal
from pyarrow import csv as arrow_csv
from pyarrow import parquet

from conftest import palpate
from tissue_probe.analysis.estimating import _within
from tissue_probe.estimation import EstimatorSettings
from tissue_probe.estimation.offline import estimate
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.model_file import save
from tissue_probe.recording.bags.reader import read_recording

COLUMNS = [
    "time",
    "stiffness",
    "damping",
    "stiffness_variance",
    "damping_variance",
    "covariance_trace",
    "innovation",
    "normalized_innovation_squared",
    "status",
    "model",
]


def table(path):
    return arrow_csv.read_csv(path).to_pydict()


@pytest.mark.parametrize("name", ["ekf", "ukf", "afekf", "robust_ekf"])
def test_every_filter_finds_the_tissue_within_one_percent(run, csv, name):
    outcome = run("estimate", csv(), "--estimator", name)
    assert outcome.status == 0
    found = table("estimates.csv")
    assert list(found) == COLUMNS
    assert len(found["time"]) == 4000
    assert found["stiffness"][-1] == pytest.approx(450.0, rel=0.01)
    assert found["damping"][-1] == pytest.approx(5.0, rel=0.01)
    assert found["status"][-1] == "converged"


def test_the_end_is_printed_with_its_uncertainty_and_where_the_table_is(run, csv):
    outcome = run("estimate", csv(), "-o", "found [1].csv")
    assert outcome.err == ""
    assert outcome.out.count("\n") == 2
    found = table("found [1].csv")
    deviation = np.sqrt(found["stiffness_variance"][-1])
    assert f"stiffness {found['stiffness'][-1]:.2f} ± {deviation:.2f} N/m" in outcome.out
    assert outcome.out.startswith("ekf: 4000 samples written to found [1].csv\n")
    assert outcome.out.endswith(", converged\n")


def test_tension_positive_forces_give_the_same_with_the_sign_turned(run, fails, csv):
    run("estimate", csv(), "-o", "compression.csv")
    tension = csv("tension.csv", sign=-1.0)
    run("estimate", tension, "-o", "turned.csv", "--force-polarity", "tension")
    assert "--force-polarity" in fails("estimate", tension, "-o", "wrong.csv")
    assert table("turned.csv") == table("compression.csv")


def test_columns_are_found_by_the_names_given(run, csv):
    run("estimate", csv(), "-o", "plain.csv")
    renamed = csv("renamed.csv", header="seconds,coil,cell")
    outcome = run(
        *("estimate", renamed, "-o", "renamed_estimates.csv"),
        *("--time", "seconds", "--position", "coil", "--force", "cell"),
        *("--position-unit", "m", "--force-unit", "N", "--force-polarity", "compression"),
    )
    assert outcome.status == 0
    assert table("renamed_estimates.csv") == table("plain.csv")


def test_time_is_that_of_the_csv_file(run, csv):
    run("estimate", csv(begin=12.5))
    assert table("estimates.csv")["time"] == pytest.approx(12.5 + 5e-4 * np.arange(4000))


def test_csv_and_parquet_hold_the_same(run, csv):
    measured = csv(seconds=0.2)
    run("estimate", measured, "-o", "out.csv")
    run("estimate", measured, "-o", "out.parquet")
    assert parquet.read_table("out.parquet").to_pydict() == table("out.csv")


def test_a_table_that_is_there_is_replaced(run, csv):
    measured = csv(seconds=0.1)
    run("estimate", csv("longer.csv", seconds=0.2))
    run("estimate", measured)
    assert len(table("estimates.csv")["time"]) == 200


def test_a_setting_changes_what_the_filter_works_with(run, csv):
    outcome = run("estimate", csv(), "--set", "tip_mass=0.02", "--set", "force_noise = 0.01")
    assert outcome.status == 0
    # The force of inertia that the filter no longer expects, it takes for missing stiffness.
    expected = 450.0 - 0.02 * (2.0 * np.pi * 10.0) ** 2
    assert table("estimates.csv")["stiffness"][-1] == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--estimator", "magic"], "there is no estimator 'magic'; there are "),
        (["--set", "tip_mass"], "--set tip_mass: write NAME=VALUE, such as force_noise=0.01"),
        (["--set", "mass=1"], "there is no mass; there are tip_mass, load_cell_stiffness, "),
        (["--set", "tip_mass=heavy"], "tip_mass is 'heavy': give a number from 0 to 10 [kg]"),
        (["--set", "tip_mass=11"], "tip_mass is '11': give a number from 0 to 10 [kg]"),
        (["--set", "force_noise=nan"], "force_noise is 'nan': give a number from 1e-09 to 100 [N]"),
        (["--set", "discretisation=best"], "discretisation is 'best': give one of exact, euler"),
        (["--output", "estimates.xlsx"], "estimates.xlsx ends in '.xlsx'; tables are .csv or "),
        (["--output", "none/estimates.csv"], "none/estimates.csv"),
        (["--force", "N"], "has no column N; its columns are t, u, F"),
        (["--output", "measured.csv"], "measured.csv holds the samples and would be replaced"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line(fails, csv, tmp_path, arguments, said):
    measured = csv(seconds=0.1)
    before = measured.read_bytes()
    assert said in fails("estimate", measured, *arguments)
    assert measured.read_bytes() == before
    assert list(tmp_path.glob("estimates.*")) == []


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("none.csv", None, "none.csv: No such file or directory"),
        ("empty.csv", "", "empty.csv is empty: nothing was recorded"),
        ("header.csv", "t,u,F\n", "header.csv has a header line perhaps, but no rows below it"),
        (
            "column.csv",
            "t,u\n0,0\n",
            "column.csv does not say which column is the force: give --force; its columns are t, u",
        ),
        ("word.csv", "t,u,F\n0,0,0\n1,0,x\n", "word.csv, line 3: column F is 'x'"),
        ("none.mcap", None, "none.mcap: No such file or directory"),
        ("empty.mcap", "", "empty.mcap is empty: nothing was recorded"),
        ("text.mcap", "t,u,F\n0,0,0\n", "text.mcap is not an MCAP file"),
        (
            "measured.txt",
            "t,u,F\n0.0,0,0\n",
            "measured.txt has 1 samples; give at least two",
        ),
    ],
)
def test_a_file_that_is_no_measurement_is_named_with_what_is_wrong(
    fails, tmp_path, name, content, said
):
    if content is not None:
        (tmp_path / name).write_text(content)
    assert said in fails("estimate", name)


def test_a_recording_is_estimated_bit_for_bit_as_the_filter_does_it(run, bag):
    recorded = bag()
    assert run("estimate", recorded).status == 0
    expected = estimate(read_recording(recorded), "ekf", EstimatorSettings())
    found = table("estimates.csv")
    assert_array_equal(found["stiffness"], expected.stiffness)
    assert_array_equal(found["damping"], expected.damping)
    assert_array_equal(found["covariance_trace"], expected.covariance_trace)
    assert found["time"] == pytest.approx(5e-4 * np.arange(9600), abs=1e-12)


def test_a_recording_s_own_settings_count_unless_changed(run, bag):
    recorded = bag(
        metadata={
            "/probe/other": {"estimator": "ukf", "tip_mass": "0.01"},
            "/probe/ekf": {"estimator": "ekf", "tip_mass": "0.02", "restart_at_site": "false"},
        }
    )
    run("estimate", recorded, "-o", "recorded.csv")
    run("estimate", recorded, "-o", "changed.csv", "--set", "tip_mass=0.04", "--restart-at-site")
    recording = read_recording(recorded)
    as_recorded = estimate(
        recording, "ekf", EstimatorSettings(tip_mass=0.02), restart_at_site=False
    )
    changed = estimate(recording, "ekf", EstimatorSettings(), restart_at_site=True)
    assert_array_equal(table("recorded.csv")["stiffness"], as_recorded.stiffness)
    assert_array_equal(table("changed.csv")["stiffness"], changed.stiffness)
    assert not np.array_equal(as_recorded.stiffness, changed.stiffness)


def test_metadata_of_other_recorders_does_no_harm(run, bag):
    recorded = bag(metadata={"rig": {"estimator": "{not: yaml", "device_description": "a: b: c"}})
    assert run("estimate", recorded).status == 0


def test_a_recorded_setting_out_of_range_is_named(fails, bag):
    recorded = bag(metadata={"/probe/ekf": {"estimator": "ekf", "tip_mass": "-1.0"}})
    assert "tip_mass is -1.0: give a number from 0 to 10 [kg]" in fails("estimate", recorded)


def test_a_topic_that_is_not_there_is_said_with_those_that_are(fails, bag):
    assert "no samples on /left/samples; it has them on /probe/samples" in fails(
        "estimate", bag(), "--topic", "/left/samples"
    )


def test_of_several_topics_of_samples_one_is_chosen(run, fails, bag, messages, scan):
    block = scan[0][0]
    other = ("/left/samples", messages.SAMPLES, block.stamp, messages.samples(block))
    recorded = bag(more=[other])
    assert "samples on several topics, choose one: " in fails("estimate", recorded)
    assert run("estimate", recorded, "--topic", "/left/samples").status == 0
    assert len(table("estimates.csv")["time"]) == 10


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_an_improved_model_is_taken_from_its_file(run, fails, tmp_path):
    composition = Composition(effects=(EFFECTS["force_gain"],))
    entries = composition.entries(map(str, composition.model.values))
    values = {entry.name: entry.default for entry in entries} | {"gain_error": 0.2}
    save(tmp_path / "model.yaml", composition, values, {})
    time = np.arange(4000) * 5e-4
    position, force = palpate(time, 450.0, 5.0)
    columns = np.stack([time, position, 1.2 * force], axis=1)
    np.savetxt(tmp_path / "gain.csv", columns, delimiter=",", header="t,u,F", comments="")
    outcome = run("estimate", "gain.csv", "--model", "model.yaml")
    assert outcome.status == 0, outcome.err
    stiffness = float(outcome.out.partition("stiffness ")[2].split()[0])
    assert stiffness == pytest.approx(450.0, rel=0.02)
    (tmp_path / "model.yaml").write_text("version: 1\n")
    assert "model.yaml: rig is missing" in fails("estimate", "gain.csv", "--model", "model.yaml")
    assert "rls knows Kelvin-Voigt tissue only" in fails(
        "estimate", "gain.csv", "--model", "model.yaml", "--estimator", "rls"
    )


@given(st.floats(-1e4, 1e4), st.floats(1e-9, 1e3), st.integers(2, 3))
def test_a_deviation_is_told_to_two_digits_or_the_usual_decimals_however_small(
    value, deviation, decimals
):
    told, within = _within(value, deviation, decimals).split(" ± ")
    assert float(within) == pytest.approx(deviation, abs=0.5 * 10.0**-decimals, rel=0.05)
    assert float(within) > 0.0
    assert abs(float(told) - value) <= max(deviation, 10.0**-decimals)


def rigid(path, stiffness=500.0, damping=3.0, rate=500.0):
    """Write what a testing machine measures at 5 Hz, its tip without mass."""
    t = np.arange(int(4.0 * rate)) / rate
    w, random = 2.0 * np.pi * 5.0, np.random.default_rng(7)
    u = 2e-3 + 1e-3 * np.sin(w * t)
    force = stiffness * u + damping * 1e-3 * w * np.cos(w * t)
    table = np.column_stack([
        t, 1e3 * u + 1e-3 * random.standard_normal(t.size),
        force + 5e-3 * random.standard_normal(t.size),
    ])  # fmt: skip
    np.savetxt(path, table, delimiter=",", header="t_s,u_mm,F", comments="", fmt="%.9g")
    return path


@pytest.mark.parametrize("estimator", ["robust_ekf", "ukf", "rls"])
def test_a_rigid_probe_is_estimated_too(estimator, run, tmp_path):
    path = rigid(tmp_path / "machine.csv")
    outcome = run("estimate", path, "-e", estimator, "--rig", "rigid_probe", "--set",
                  "encoder_resolution=3.5e-6")  # fmt: skip
    assert outcome.status == 0, outcome.err
    assert "the tip is taken to have no mass, as --set tells none" in " ".join(outcome.out.split())
    found = re.search(
        r"stiffness ([\d.]+) ± ([\d.]+) N/m, damping ([\d.]+) ± ([\d.]+)", outcome.out
    )
    k, k_deviation, beta, beta_deviation = map(float, found.groups())
    assert k == pytest.approx(500.0, abs=3.0 * k_deviation)
    assert k == pytest.approx(500.0, rel=0.01)
    assert beta == pytest.approx(3.0, abs=3.0 * beta_deviation)


def test_a_value_that_the_settings_hold_back_is_told_with_the_setting(run, tmp_path):
    path = rigid(tmp_path / "machine.csv", damping=40.0)
    outcome = run("estimate", path, "--rig", "rigid_probe", "--set", "damping_maximum=20")
    told = " ".join(outcome.out.split())
    assert "the damping ends at 20 N s/m, where damping_maximum holds it" in told


def test_a_force_that_drives_is_refused_by_filters(run, tmp_path):
    outcome = run("estimate", rigid(tmp_path / "machine.csv"), "--rig", "force_driven")
    assert outcome.status == 2
    assert "is not one of 'compliant_probe', 'rigid_probe'" in " ".join(outcome.err.split())
