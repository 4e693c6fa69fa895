"""What earlier versions wrote is read by this one: recordings, model files, answers for programs.

Everything here is as the version of 26 November 2026 wrote it, before maps had verdicts. A change
of today's layouts must not change these samples: let today's readers take them as they are.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import yaml
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from tissue_probe.challenge.grading import GradedDiagnosis
from tissue_probe.devices.calibration import Calibration
from tissue_probe.diagnosis.answer import Answer
from tissue_probe.physics.model_file import load
from tissue_probe.physics.phantom import Phantom
from tissue_probe.recording.bags.definitions import message_definition
from tissue_probe.recording.bags.reader import read_estimates, read_map, read_recording
from tissue_probe.recording.bags.summary import summarize
from tissue_probe.recording.writing.writer import McapWriter
from tissue_probe.signals import NANOSECONDS, Status

REPOSITORY = Path(__file__).parents[2]
EXAMPLE = REPOSITORY / "docs" / "my_effect.py"
STATED = ("--rig", "compliant_probe", "--force-polarity", "compression")

DEFINITIONS = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z\n",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
    "tissue_probe_msgs/ProbeSamples": """
std_msgs/Header header    # stamp: time of the first sample; frame_id: the probe's frame
uint64 sequence           # number of the first sample since activation, from 0 [-]
float64 sample_period     # time between two samples [s]
float64[] position        # displacement of the coil, positive into the tissue [m]
float64[] force           # load-cell force, positive in compression [N]
float64[] command         # voltage commanded to the coil [V]
""",
    "tissue_probe_msgs/PalpationSite": """
uint8 APPROACH=0    # on its way to the site
uint8 DWELL=1       # in contact, measuring
uint8 LIFTED=2      # off the tissue, the site is done
std_msgs/Header header            # stamp: when the phase begins, possibly in the future
uint32 site                       # number of the site in its scan, from 0 [-]
geometry_msgs/Point position      # the site on the tissue's surface [m]
uint8 phase                       # one of the constants above [-]
""",
    "tissue_probe_msgs/TissueEstimate": """
uint8 CONVERGING=0        # not yet known to 5 %
uint8 CONVERGED=1         # two standard deviations of stiffness and of damping are within 5 %
uint8 NO_CONTACT=2        # no tissue under the tip
uint8 MODEL_REJECTED=3    # the innovations say that the model is wrong
std_msgs/Header header                  # stamp: time of the last sample used
uint64 sequence                         # number of the last sample used, since activation [-]
string estimator                        # name of the estimator [-]
float64 stiffness                       # k [N/m]
float64 damping                         # beta [N s/m]
float64 covariance_trace                # trace of the state's covariance [-]
float64 stiffness_variance              # variance of k [N^2/m^2]
float64 damping_variance                # variance of beta [N^2 s^2/m^2]
float64 stiffness_damping_covariance    # covariance of k and beta [N^2 s/m^2]
float64 force_offset                    # constant offset of the load cell [N]
float64 predicted_force                 # force predicted before the last sample was seen [N]
float64 innovation                      # measured minus predicted force [N]
float64 normalized_innovation_squared   # innovation squared over its variance [-]
uint8 status                            # one of the constants above [-]
""",
    "tissue_probe_msgs/StiffnessMap": """
std_msgs/Header header          # stamp: time of the newest estimate used
geometry_msgs/Point origin      # the cell in row 0, column 0 [m]
float64 spacing                 # distance between neighbouring cells [m]
uint32 rows                     # cells along y [-]
uint32 columns                  # cells along x [-]
float64[] stiffness             # k [N/m]
float64[] damping               # beta [N s/m]
float64[] covariance_trace      # trace of the state's covariance [-]
float64[] stiffness_stddev      # standard deviation of k [N/m]
""",
}

#: What the node `robust_ekf` told of itself: every parameter that it had, at its default.
FILTER = {
    "estimator": "robust_ekf", "restart_at_site": True, "tip_mass": 0.04,
    "load_cell_stiffness": 9700.0, "load_cell_damping": 0.8, "force_noise": 0.005,
    "encoder_resolution": 1e-07, "discretisation": "exact", "velocity_noise": 1e-09,
    "fading": 1.003, "stiffness_prior": 0.0, "stiffness_prior_sd": 1000.0, "damping_prior": 0.0,
    "damping_prior_sd": 20.0, "tip_position_prior_sd": 0.01, "tip_velocity_prior_sd": 1.0,
    "force_offset_prior_sd": 0.1, "deviation_ceiling": 1.0, "stiffness_minimum": -2000.0,
    "stiffness_maximum": 30000.0, "damping_minimum": -20.0, "damping_maximum": 500.0,
    "contact_stiffness": 20.0, "model": "", "estimate_effects": False, "drive_frequency": 10.0,
    "forgetting": 0.98, "use_sim_time": False,
}  # fmt: skip

CALIBRATION = """\
date: 2026-11-20
instruments: {load cell: LCL-005 no. 17}
force_per_volt: 2.0
force_offset_volts: 0.0
force_polarity: compression
position_per_count: 1.0e-7
current_per_volt: 0.28
tip_mass: 0.04
load_cell_stiffness: 9700.0
load_cell_damping: 0.8
intervals: {force_per_volt: [1.99, 2.01]}
"""
PHANTOM = """\
background_stiffness: 450.0    # [N/m]
background_damping: 5.0        # [N s/m]
nodules:
  - {x: 0.010, y: 0.010, depth: 0.001, radius: 0.005, stiffness_ratio: 3.0}
"""
MODEL = """\
version: 1
rig: compliant_probe
tissue: kelvin_voigt
effects:
- name: quadratic_drag
  file: effects/my_effect.py
constants:
  tip_mass: {value: 0.04, deviation: 0.0, unit: kg}
  load_cell_stiffness: {value: 9700.0, deviation: 0.0, unit: N/m}
  load_cell_damping: {value: 0.8, deviation: 0.0, unit: N s/m}
  contact_position: {value: 0.0, deviation: 0.0, unit: m}
parameters:
  stiffness: {value: 450.0, deviation: 0.2, unit: N/m}
  damping: {value: 5.0, deviation: 0.01, unit: N s/m}
  drag_coefficient: {value: 0.0, deviation: 0.1, unit: N s^2/m^2}
data:
  files:
  - {name: data.csv, sha256: 9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08}
  date: '2026-11-20'
  noise: 0.005
  rmse_training: 0.00501
  rmse_heldout: 0.00502
"""


@pytest.fixture(scope="module")
def earlier(tmp_path_factory):
    """A share folder with the definitions of then, and a store that makes messages by them."""
    folder = tmp_path_factory.mktemp("earlier")
    for name, text in DEFINITIONS.items():
        package, short = name.split("/")
        (folder / package / "msg").mkdir(parents=True, exist_ok=True)
        (folder / package / "msg" / f"{short}.msg").write_text(text)
    store, definitions = get_typestore(Stores.EMPTY), {}
    for name in ("ProbeSamples", "PalpationSite", "TissueEstimate", "StiffnessMap"):
        typename = f"tissue_probe_msgs/msg/{name}"
        definitions[name] = message_definition(typename, [folder])
        store.register(get_types_from_msg(definitions[name], typename))
    return store, definitions


@pytest.fixture
def recording(tmp_path, earlier, scan) -> Path:
    """A scan of 4 x 4 sites as a recorder of then left it: samples, sites, estimates, a map."""
    store, definitions = earlier
    blocks, sites = scan

    def made(name, *values):
        return store.types[name](*values)

    def header(stamp):
        time = made("builtin_interfaces/msg/Time", *divmod(stamp, NANOSECONDS))
        return made("std_msgs/msg/Header", time, "probe")

    entries = [
        ("samples", "ProbeSamples", b.stamp, (header(b.stamp), b.sequence, b.sample_period,
                                              b.position, b.force, b.command))
        for b in blocks
    ] + [
        ("palpation_site", "PalpationSite", s.stamp,
         (header(s.stamp), s.site, made("geometry_msgs/msg/Point", *s.position), int(s.phase)))
        for s in sites
    ]  # fmt: skip
    for number in range(16):
        stiffness = 1125.0 if number == 5 else 450.0
        values = (stiffness, stiffness / 90, 1e-3, 1.0, 0.01, 0.0, 0.0, 0.1, 0.0, 1.0)
        for block in blocks[60 * number + 40 : 60 * number + 60]:
            stamp = int(block.stamps[-1])
            told = (header(stamp), block.sequence + 9, "robust_ekf", *values, 1)
            entries.append(("robust_ekf/estimate", "TissueEstimate", stamp, told))
    cells = np.full(16, 450.0)
    origin = made("geometry_msgs/msg/Point", 0.0, 0.0, 0.0)
    told = (header(blocks[-1].end), origin, 0.01, 4, 4, cells, cells / 90, cells, cells / 450)
    entries.append(("stiffness_map", "StiffnessMap", blocks[-1].end, told))
    description = yaml.safe_dump({"phantom": yaml.safe_load(PHANTOM)})
    parameters = {
        "/probe/robust_ekf": FILTER,
        "/probe/driver": {"device_description": description, "calibration": CALIBRATION},
    }
    metadata = {
        node: {name: yaml.safe_dump(value) for name, value in values.items()}
        for node, values in parameters.items()
    }
    with McapWriter(tmp_path / "run.mcap", metadata) as writer:
        channels = {
            topic: writer.add_topic(f"/probe/{topic}", f"tissue_probe_msgs/msg/{name}",
                                    definitions[name], "")
            for topic, name in {(topic, name) for topic, name, _, _ in entries}
        }  # fmt: skip
        for topic, name, stamp, values in sorted(entries, key=lambda entry: entry[2]):
            typename = f"tissue_probe_msgs/msg/{name}"
            data = bytes(store.serialize_cdr(made(typename, *values), typename))
            writer.write(channels[topic], stamp, stamp, data)
    return tmp_path / "run.mcap"


def test_a_recording_is_read(recording, scan):
    blocks, sites = scan
    read = read_recording(recording)
    assert len(read) == 9600
    np.testing.assert_array_equal(read.force, np.concatenate([b.force for b in blocks]))
    assert read.sites == tuple(sites)
    assert [samples.lost for samples in summarize(recording).samples] == [0]
    (estimates,) = read_estimates(recording).values()
    assert len(estimates) == 16 * 20
    assert set(estimates.status) == {Status.CONVERGED}
    assert set(estimates.model) == {""}  # which was not told then
    assert read_recording(recording).models == ()
    assert estimates.stiffness.max() == 1125.0
    found = read_map(recording)
    np.testing.assert_array_equal(found.stiffness, np.full((4, 4), 450.0))
    np.testing.assert_array_equal(found.stiffness_stddev, np.full((4, 4), 1.0))


@pytest.mark.slow
def test_commands_take_a_recording(run, recording, tmp_path):
    outcome = run("info", recording, "--parameters")
    assert outcome.status == 0, outcome.err
    assert "/probe/samples: 9600 samples, 0 lost\n16 sites palpated\n" in outcome.out
    outcome = run("map", recording)
    assert outcome.status == 0, outcome.err
    assert re.search(r"16 of 16 sites measured; background (449|450)\.\d ±", outcome.out)
    assert "1 of 1 nodules found" in outcome.out
    outcome = run("estimate", recording, "--estimator", "robust_ekf")
    assert outcome.status == 0, outcome.err
    stiffness = float(re.search(r"stiffness ([\d.]+) ± ", outcome.out)[1])
    assert stiffness == pytest.approx(450.0, rel=0.01)
    (tmp_path / "calibration.yaml").write_text(CALIBRATION)
    outcome = run("export", recording, "--calibration", "calibration.yaml")
    assert outcome.status == 0, outcome.err


def test_a_model_file_with_an_effect_of_ones_own_is_read_where_its_file_is_named(
    run, csv, tmp_path
):
    csv()
    (tmp_path / "model.yaml").write_text(MODEL)
    model = load(tmp_path / "model.yaml", [EXAMPLE])
    assert model.composition.names == ("quadratic_drag",)
    assert model.values["stiffness"] == 450.0
    assert model.data.converged
    named = ("--model", "model.yaml", "--effects", EXAMPLE)
    outcome = run("estimate", "measured.csv", "--estimator", "robust_ekf", *named)
    assert outcome.status == 0, outcome.err
    stiffness = float(re.search(r"stiffness ([\d.]+) ± ", outcome.out)[1])
    assert stiffness == pytest.approx(450.0, rel=0.01)
    outcome = run("compare", "measured.csv", *STATED, *named)
    assert outcome.status == 0, outcome.err
    assert float(re.search(r"error over noise +([\d.]+)", outcome.out)[1]) < 1.1


def test_calibration_and_phantom_are_read(tmp_path):
    (tmp_path / "calibration.yaml").write_text(CALIBRATION)
    (tmp_path / "phantom.yaml").write_text(PHANTOM)
    assert Calibration.load(tmp_path / "calibration.yaml").force_delay == 0.0
    assert Phantom.load(tmp_path / "phantom.yaml").nodules[0].stiffness_ratio == 3.0


def fitted(**values: float) -> dict[str, dict[str, object]]:
    return {
        name: {"value": value, "deviation": 0.1, "unit": "N/m"} for name, value in values.items()
    }


STEP = {
    "effects": [], "parameters": fitted(stiffness=450.0), "rmse_training": 0.02,
    "rmse_heldout": 0.021, "converged": True,
}  # fmt: skip
ANSWER = {
    "version": 1,
    "verdict": "missing",
    "output": {"quantity": "force", "unit": "N"},
    "ranking": [
        {
            "effect": "coulomb_friction", "family": "friction", "heldout_rmse": 0.005,
            "rmse": 0.005, "gain": 4000.0, "converged": True,
            "parameters": fitted(coulomb_force=0.1),
        },
        {
            "effect": "adc_saturation", "family": "data", "heldout_rmse": None, "rmse": None,
            "gain": None, "converged": True, "parameters": {},
        },
    ],
    "indistinguishable": ["coulomb_friction"],
    "alternatives": [],
    "unseen": ["added_mass"],
    "effects": ["coulomb_friction"],
    "rmse": {"training": {"base": 0.02, "final": 0.005}, "heldout": {"base": 0.02, "final": None}},
    "noise_floor": 0.005,
    "ladder": [STEP, STEP | {"effects": ["coulomb_friction"]}],
    "suggested_excitation": {
        "excitation": {"kind": "chirp", "amplitude": 0.001, "start": 1.0, "stop": 60.0},
        "preload": 0.002, "duration": 2.0, "separation": 3.5, "shows": [], "calibration": "",
        "command": "ros2 run tissue_probe driver", "command_notes": ["Press in by 2 mm."],
    },
    "carries_over": None,
    "findings": ["data.csv: 3 samples were filled in"],
    "seconds": 1.5,
    "compared": None,
}  # fmt: skip


def test_an_answer_for_programs_is_read():
    schema = json.loads((REPOSITORY / "docs" / "diagnosis.schema.json").read_text())
    jsonschema.validate(ANSWER, schema)
    answer = Answer.model_validate_json(json.dumps(ANSWER))
    assert answer.ranking[0].parameters["coulomb_force"].value == 0.1
    assert GradedDiagnosis.parse(ANSWER).verdict == "missing"


def test_what_a_program_of_then_reads_is_still_written():
    """Each key of then, with a value of its type, is one that today's answers have, too."""
    answer = json.loads(Answer.model_validate(ANSWER).model_dump_json())

    def holds(now: object, then: object) -> bool:
        if isinstance(then, dict):
            return then.keys() <= now.keys() and all(holds(now[k], v) for k, v in then.items())
        if isinstance(then, list):
            return all(holds(one, other) for one, other in zip(now, then, strict=True))
        return now == then

    assert holds(answer, ANSWER)
