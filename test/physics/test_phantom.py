"""The simulated phantom, and its file."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from tissue_probe.mapping.grid import Grid
from tissue_probe.physics.phantom import Nodule, Phantom

CONFIG = Path(__file__).parents[2] / "config" / "phantom.yaml"
VALID = """
background_stiffness: 450
background_damping: 5
nodules:
  - {x: 1e-2, y: 0.02, depth: 0.003, radius: 0.005, stiffness_ratio: 3}
"""


def nodule(depth):
    return Nodule(x=0.02, y=0.02, depth=depth, radius=0.006, stiffness_ratio=3.0)


def phantom(*nodules):
    return Phantom(background_stiffness=450.0, background_damping=5.0, nodules=nodules)


@pytest.fixture
def written(tmp_path):
    def write(text):
        path = tmp_path / "phantom.yaml"
        path.write_text(text)
        return path

    return write


def test_far_from_every_nodule_the_tissue_is_background():
    assert phantom(nodule(0.003)).stiffness(0.2, 0.2) == pytest.approx(450.0)
    assert phantom().damping(0.0, 0.0) == 5.0


def test_over_a_nodule_at_the_surface_the_tissue_is_stiffer_by_its_ratio():
    assert phantom(nodule(0.0)).stiffness(0.02, 0.02) == pytest.approx(3.0 * 450.0)
    assert phantom(nodule(0.0)).damping(0.02, 0.02) == pytest.approx(3.0 * 5.0)


def test_deeper_nodules_are_felt_weaker_and_more_broadly():
    shallow, deep = nodule(0.001), nodule(0.005)
    assert deep.excess(0.02, 0.02) < shallow.excess(0.02, 0.02)
    relative = [n.excess(0.03, 0.02) / n.excess(0.02, 0.02) for n in (shallow, deep)]
    assert relative[0] < relative[1]


def test_values_take_the_shape_of_the_places():
    tissue = phantom(nodule(0.003))
    x, y = np.linspace(0.0, 0.04, 4), np.linspace(0.0, 0.04, 3)[:, None]
    assert tissue.stiffness(x, y).shape == (3, 4)
    assert tissue.damping(x, y)[2, 1] == tissue.damping(x[1], y[2, 0])
    assert phantom().stiffness(x, y).shape == (3, 4)


def test_the_default_phantom_is_that_of_the_demonstration():
    tissue = Phantom.load(CONFIG)
    assert (tissue.background_stiffness, tissue.background_damping) == (450.0, 5.0)
    assert sorted(n.depth for n in tissue.nodules) == [0.001, 0.003, 0.005]
    for n in tissue.nodules:
        assert 2.0 < tissue.stiffness(n.x, n.y) / 450.0 < 3.0


def test_the_default_nodules_are_felt_at_separate_sites_of_the_default_grid():
    tissue = Phantom.load(CONFIG)
    grid = Grid((0.0, 0.0, 0.0), 0.01, rows=5, columns=5)
    cells = [grid.nearest((n.x, n.y)) for n in tissue.nodules]
    stiffness = tissue.stiffness(*np.meshgrid(grid.x, grid.y))
    stiff = set(zip(*np.nonzero(stiffness > 2.0 * tissue.background_stiffness), strict=True))
    assert stiff == set(cells)
    apart = [max(abs(a[0] - b[0]), abs(a[1] - b[1])) for a, b in combinations(cells, 2)]
    assert min(apart) >= 2


def test_numbers_in_scientific_notation_are_read(written):
    assert Phantom.load(written(VALID)).nodules[0].x == 0.01


@pytest.mark.parametrize(
    ("good", "bad", "complaint"),
    [
        ("_stiffness: 450", "_stiffness: -1", r"background_stiffness is -1: .*100000 \[N/m\]"),
        ("_damping: 5", "_damping: soft", r"background_damping is 'soft': .*1000 \[N s/m\]"),
        ("depth: 0.003", "depth: 3", r"nodules\[0\].depth is 3: .*from 0 to 0.1 \[m\]"),
        ("depth: 0.003", "depth: .nan", r"nodules\[0\].depth is nan: .*\[m\]"),
        ("depth: 0.003, ", "", r"nodules\[0\].depth is missing: .*\[m\]"),
        ("depth:", "deep:", r"nodules\[0\].depth is missing"),
        ("background_damping: 5", "", "background_damping is missing"),
        ("stiffness_ratio: 3", "stiffness_ratio: 3, hue: 1", r"no nodules\[0\].hue.* depth"),
        ("background_damping", "hue: 1\nbackground_damping", "no hue.*background_stiffness"),
        ("  - {x", "  - 7\n  - {x", r"nodules\[0\] is 7: give the fields x, y, depth"),
        ("nodules:", "nodules: [", "is not YAML"),
    ],
)
def test_a_wrong_file_is_refused_in_one_sentence(written, good, bad, complaint):
    path = written(VALID.replace(good, bad))
    with pytest.raises(ValueError, match=complaint) as refusal:
        Phantom.load(path)
    assert str(path) in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("text", ["", "- 1", "450", "a text"])
def test_a_file_of_another_shape_is_refused_in_one_sentence(written, text):
    with pytest.raises(ValueError, match=r"phantom\.yaml: the file is .*background_stiffness"):
        Phantom.load(written(text))


def test_nodules_that_are_no_list_are_refused(written):
    text = VALID[: VALID.index("nodules")] + "nodules: 3"
    with pytest.raises(ValueError, match="nodules is 3: give a list of nodules"):
        Phantom.load(written(text))


def test_bytes_that_are_no_text_are_refused(tmp_path):
    path = tmp_path / "phantom.yaml"
    path.write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(ValueError, match="is not YAML"):
        Phantom.load(path)


def test_a_file_that_does_not_exist_is_named():
    with pytest.raises(FileNotFoundError, match=r"nowhere\.yaml"):
        Phantom.load(Path("nowhere.yaml"))
