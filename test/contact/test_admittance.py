"""Gains with margins, and the file of them as ros2_controllers' admittance_controller takes it."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest
import yaml

import tissue_probe as tp
from tissue_probe.contact.contact import Contact, ContactNumber

MASS, SPRING, DELAY = 2.0, 50.0, 0.012
STATED = {"mass": MASS, "stiffness": SPRING, "delay": DELAY}
#: Types, sizes and bounds of all parameters of the file, as `admittance_controller_parameters.yaml`
#: of ros2_controllers declares them (branch master, 2025).
DECLARED = {
    "ft_sensor.filter_coefficient": (float, None, (0.0, 1.0)),
    "control.frame.id": (str, None, None),
    "admittance.selected_axes": (bool, 6, None),
    "admittance.mass": (float, 6, (0.0001, 1e6)),
    "admittance.damping_ratio": (float, 6, None),
    "admittance.stiffness": (float, 6, (0.0, 1e8)),
    "admittance.joint_damping": (float, None, (0.0, np.inf)),
}


def contact(stiffness=1000.0, damping=3.0, deviation=0.01, verdict="adequate") -> Contact:
    return Contact(
        verdict=verdict,
        stiffness=ContactNumber(stiffness, deviation * stiffness),
        damping=ContactNumber(damping, 0.3),
        tip_mass=ContactNumber(0.8, 1e-4),
        delay=ContactNumber(4e-3, 1e-4),
        error=0.1,
        error_over_noise=1.0,
        lowest=1e-3,
        highest=3e-3,
        fastest=0.025,
        slow=1.0,
        fast=4.0,
    )


def flat(tree, name=""):
    if not isinstance(tree, dict):
        return {name: tree}
    found = {}
    for key, each in tree.items():
        found |= flat(each, f"{name}.{key}".strip("."))
    return found


def test_every_parameter_is_declared_with_its_type_size_and_bounds(tmp_path):
    result = tp.design_admittance(contact(), **STATED, axes=["z", "rx"], frame="tip")
    result.save(tmp_path / "gains.yaml")
    (node, content), *others = yaml.safe_load((tmp_path / "gains.yaml").read_text()).items()
    assert not others
    assert node == "admittance_controller"
    given = flat(content["ros__parameters"])
    assert given.keys() == DECLARED.keys()
    for name, value in given.items():
        kind, size, bounds = DECLARED[name]
        assert isinstance(value, list) == (size is not None)
        values = value if size else [value]
        assert len(values) == (size or 1)
        assert all(type(each) is kind for each in values)  # to ROS 2 is no double: it is an integer
        assert bounds is None or all(bounds[0] <= each <= bounds[1] for each in values)
    assert given["admittance.selected_axes"] == [False, False, True, True, False, False]
    assert given["control.frame.id"] == "tip"


def test_ros_reads_the_file(tmp_path):
    parameter = pytest.importorskip("rclpy.parameter")
    path = tmp_path / "gains.yaml"
    tp.design_admittance(contact(), **STATED).save(path)
    read = parameter.parameter_dict_from_yaml_file(
        str(path), target_nodes=["admittance_controller"]
    )
    assert list(read["admittance.mass"].value.double_array_value) == [MASS] * 6


def test_the_controllers_own_damping_is_the_least_that_holds_the_margins():
    result = tp.design_admittance(contact(), **STATED, gain_margin=3.0, phase_margin=40.0)
    gains = result.gains
    # As the controller computes it: D = 2 zeta sqrt(M S).
    damping = 2.0 * gains.damping_ratio * np.sqrt(MASS * SPRING)
    assert damping == pytest.approx(gains.admittance.damping, rel=1e-9)
    stiff, beta = 1000.0 * (1.0 + 1.96 * 0.01), 3.0 + 1.96 * 0.3
    omega = np.linspace(0.5, 500.0, 400_000)
    s = 1j * omega

    def margins(damping):
        own = MASS * s**2 + damping * s + SPRING
        loop = (stiff + np.array([[beta], [6.0 - beta]]) * s) * np.exp(-DELAY * s) / own
        behind = np.abs(loop.real[:, :-1]) * (np.diff(np.sign(loop.imag)) != 0)
        gain = 1.0 / (behind * (loop.real[:, :-1] < 0.0)).max()
        over = np.diff(np.sign(np.abs(loop) - 1.0)) != 0
        return gain, np.degrees(np.abs(np.angle(-loop[:, :-1][over])).min())

    gain, phase = margins(damping)
    assert gain > 2.99
    assert phase > 39.9
    less = margins(0.98 * damping)
    assert less[0] < 3.0 or less[1] < 40.0


def test_several_tissues_and_the_stiffest_of_a_map_count():
    soft = tp.design_admittance(contact(300.0), **STATED).gains.admittance.damping
    both = tp.design_admittance([contact(300.0), contact(3000.0)], **STATED).gains
    known = tp.design_admittance(contact(300.0), **STATED, stiffest=both.stiffest).gains
    assert both.admittance.damping > 3.0 * soft
    assert known.admittance.damping == pytest.approx(both.admittance.damping, rel=0.01)


def test_a_file_that_is_no_map_is_refused(tmp_path):
    for content in ("{", "[]", "{}", '{"surface": {"mean": [[null]], "sd": [[null]]}}'):
        path = tmp_path / "map.json"
        path.write_text(content)
        with pytest.raises(tp.TissueProbeError, match=r"map\.json"):
            tp.design_admittance(contact(300.0), **STATED, stiffest=path)


def test_a_map_tells_the_stiffest_place_by_itself_and_by_its_file(tmp_path):
    x, y = (each.ravel() for each in np.meshgrid(np.arange(7) / 200.0, np.arange(7) / 200.0))
    middle = np.hypot(x - 0.015, y - 0.015) < 0.006
    k = np.where(middle, 2000.0, 500.0) * (1 + 0.01 * np.random.default_rng(4).standard_normal(49))
    result = tp.map({"x": x, "y": y, "k": k, "k_sd": 0.01 * k})
    path = tmp_path / "map.json"
    path.write_text(json.dumps(result.to_dict()))
    by_map, by_file = (
        tp.design_admittance(contact(300.0), **STATED, stiffest=each).gains.stiffest
        for each in (result, path)
    )
    assert by_file == by_map
    assert 1800.0 < by_map < 3000.0


def test_the_file_tells_the_error_of_the_model_the_range_and_the_margins():
    text = tp.design_admittance(contact(), **STATED).yaml
    head = [line for line in text.splitlines() if line.startswith("#")]
    for part in ("gain margin", "delay 12 ms", "100 mN rms, 1 times the noise", "1 to 4 Hz"):
        assert any(part in line for line in head), part


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"mass": 0.0}, "`mass` is 0.0; give a number"),
        ({"delay": -0.1}, "`delay` is -0.1"),
        ({"axes": ["w"]}, "`axes` is 'w'; give one of x, y"),
        ({"phase_margin": 90.0}, "`phase_margin` is 90.0"),
        ({"contacts": contact(deviation=0.8)}, "the stiffness of a contact is not told"),
        ({"stiffest": -1.0}, "`stiffest` is -1.0; give a number"),
        ({"stiffest": [900.0]}, "`stiffest` is of the type list"),
        ({"stiffest": pd.DataFrame({"k": [900.0]})}, "`stiffest` is of the type DataFrame"),
        ({"stiffest": "none/map.json"}, "none/map.json: No such file"),
        ({"contacts": []}, "`contacts` is of the type list; give a contact, or several"),
        ({"contacts": "none.yaml"}, "none.yaml: No such file"),
    ],
)
def test_gains_for_nothing_are_refused(changes, sentence):
    with pytest.raises(tp.TissueProbeError, match=sentence):
        tp.design_admittance(**{"contacts": contact(), **STATED, **changes})


def test_what_is_made_of_a_contact_that_is_not_adequate_says_so():
    assert "do not rely" not in tp.design_admittance(contact(), **STATED).text
    both = [contact(verdict="missing"), contact(verdict="cannot tell"), contact()]
    told = tp.design_admittance(both, **STATED).text
    assert "the force has something that a spring and a damper do not make: do not rely" in told
    assert "this motion tells too little: do not rely" in told
