"""``tissue_probe map`` on a table of sites, and the same from Python."""

import csv
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import tissue_probe as tp
from tissue_probe.mapping.scatter import scatter

KEYS = {"again", "inclusions", "surface", "could_hide", "background", "check"}
INCLUSION = {
    "x", "y", "probability", "stiffness", "contrast", "boundary_50", "boundary_90", "boundary_95",
}  # fmt: skip


def table(count=7, nodule=(0.021, 0.018), **changed):
    x, y = (each.ravel() for each in np.meshgrid(*[np.linspace(0.0, 0.04, count)] * 2))
    excess = 0.5 ** (((x - nodule[0]) ** 2 + (y - nodule[1]) ** 2) / 0.006**2)
    rng = np.random.default_rng(7)
    k = 450.0 * (1.0 + excess) * (1.0 + 0.01 * rng.standard_normal(x.size))
    return {"x": x, "y": y, "k": k, "k_sd": 0.001 * k, **changed}


def write(path, columns):
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
    return path


@pytest.mark.drawn
def test_a_table_of_sites_gives_the_map_as_json(run, tmp_path):
    written = ("--json", "out.json", "--report", "map.html")
    outcome = run("map", write(tmp_path / "sites.csv", table()), *written)
    assert outcome.status == 0, outcome.err
    assert "49 of 49 sites measured" in outcome.out
    found = json.loads((tmp_path / "out.json").read_text())
    assert set(found) == KEYS
    (one,) = (each for each in found["inclusions"] if each["probability"] >= 0.9)
    assert set(one) >= INCLUSION
    assert (one["x"], one["y"]) == pytest.approx((0.021, 0.018), abs=0.001)
    assert one["contrast"] == pytest.approx(2.0, rel=0.1)
    assert np.array(one["boundary_50"]).shape[1] == 2
    surface, hide = found["surface"], found["could_hide"]
    for raster, layer in ((surface, "mean"), (surface, "sd"), (hide, "radius")):
        assert np.shape(raster[layer]) == (len(raster["y"]), len(raster["x"]))
    assert np.diff(surface["x"]) == pytest.approx(0.0005)
    assert found["background"]["stiffness"] == pytest.approx(450.0, rel=0.03)
    assert found["check"]["model"] == "inclusions"
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")
    assert "49 of 49 sites measured" in (tmp_path / "map.html").read_text()


def test_python_gives_the_same_map(run, tmp_path):
    path = write(tmp_path / "sites.csv", table())
    run("map", path, "--json", "out.json", "--raster", "2")
    from_python = tp.map(path, raster=0.002)
    assert json.loads(json.dumps(from_python.to_dict())) == json.loads(
        (tmp_path / "out.json").read_text()
    )
    assert tp.map(table(), raster=0.002).to_dict() == from_python.to_dict()
    assert "probability" in repr(from_python)


@pytest.mark.parametrize(
    ("header", "sizes"),
    [
        ("x_mm,y_mm,k,k_sd", (1e-3, 1e-3, 1.0, 1.0)),
        ("X [mm],Y [mm],k,k_sd", (1e-3, 1e-3, 1.0, 1.0)),
        ("x (cm),y (mm),k [N/mm],k_sd [N/m]", (1e-2, 1e-3, 1e3, 1.0)),
    ],
)
def test_units_in_the_header_are_read_as_those_of_recordings_are(tmp_path, header, sizes):
    given = dict(zip(header.split(","), table(5).values(), strict=True))
    scaled = {name: v / size for (name, v), size in zip(given.items(), sizes, strict=True)}
    area = {name: v / 1e-3 for name, v in zip(("x_mm", "y_mm"), LEFT_AS_ARRAYS, strict=True)}
    read = tp.map(write(tmp_path / "sites.csv", scaled), raster=0.002, within=area)
    expected = tp.map(table(5), raster=0.002, within=LEFT)
    for name in ("x", "y", "k", "k_sd"):
        assert getattr(read.sites, name) == pytest.approx(getattr(expected.sites, name))
    assert read.map.background.stiffness == pytest.approx(expected.map.background.stiffness, 0.01)


@pytest.mark.parametrize("header", ["x,y,stiffness,sd", "x_mm,y_mm,E,E_sd"])
def test_a_table_of_sites_by_other_names_is_told_what_it_needs(run, tmp_path, header):
    named = dict(zip(header.split(","), table(3).values(), strict=True))
    outcome = run("map", write(tmp_path / "sites.csv", named))
    assert outcome.status == 1
    assert "a table of sites has the columns x, y [m], k and perhaps k_sd [N/m]" in outcome.err
    assert f"its columns are {', '.join(named)}" in outcome.err
    with pytest.raises(tp.TissueProbeError, match="a table of sites has the columns x, y"):
        tp.map(named)


def test_what_a_deviation_of_nothing_means_is_told():
    found = tp.map(table(4, k_sd=np.array([0.0] * 3 + [1.0] * 13)), raster=0.005)
    assert any(
        "k_sd is 0 at 3 of 16 sites: taken as exact" in each for each in found.map.check.notes
    )


def test_the_surface_is_written_as_a_table_and_as_a_point_cloud(run, tmp_path):
    x = table()["x"]
    path = write(tmp_path / "sites.csv", table(z=0.1 * x))
    outcome = run("map", path, "--csv", "surface.csv", "--ply", "cloud.ply", "--raster", "2")
    assert outcome.status == 0, outcome.err
    with (tmp_path / "surface.csv").open() as file:
        rows = list(csv.DictReader(file))
    known = [row for row in rows if row["mean"]]
    assert float(known[0]["mean"]) > 300.0
    head, _, points = (tmp_path / "cloud.ply").read_bytes().partition(b"end_header\n")
    assert f"element vertex {len(known)}\n".encode() in head
    cloud = np.frombuffer(points, "<f8").reshape(len(known), 6)
    inside = (cloud[:, 0] >= 0) & (cloud[:, 0] <= 0.04) & (cloud[:, 1] >= 0) & (cloud[:, 1] <= 0.04)
    assert cloud[inside, 2] == pytest.approx(0.1 * cloud[inside, 0], abs=1e-6)
    assert cloud[0, 3:] == pytest.approx(
        [float(known[0][n]) for n in ("mean", "sd", "probability")]
    )


def test_a_higher_contrast_leaves_less_room(run, tmp_path):
    path = write(tmp_path / "sites.csv", table())
    room = []
    for contrast in (1.3, 3.0):
        run("map", path, "--json", "out.json", "--contrast", contrast)
        hide = json.loads((tmp_path / "out.json").read_text())["could_hide"]
        assert hide["contrast"] == contrast
        radius = np.array(hide["radius"], dtype=float)
        room.append(np.where(np.isnan(radius), 0.01, radius).mean())
    assert room[1] < room[0]


@pytest.mark.parametrize(
    ("columns", "arguments", "message"),
    [
        ({"k_sd": None, **{n: v[:5] for n, v in table().items() if n != "k_sd"}}, (), "too few"),
        ({"k_sd": np.full(49, -1.0)}, (), "k_sd of site 0 is -1.0"),
        ({"k": np.full(49, -1.0)}, (), "none of 49 sites has a stiffness above 0"),
        ({}, ("--raster", "0"), "--raster is 0.0; give a number above 0 [m]"),
        ({}, ("--contrast", "0.5"), "contrast is 0.5"),
        ({}, ("--estimator", "ekf"), "a table of sites, which has no samples"),
        ({}, ("--topic", "/samples"), "leave out the options on position, force, time, topic"),
    ],
)
def test_input_that_makes_no_map_is_refused_in_a_sentence(
    run, tmp_path, columns, arguments, message
):
    given = {name: values for name, values in table(**columns).items() if values is not None}
    outcome = run("map", write(tmp_path / "sites.csv", given), *arguments)
    assert outcome.status != 0
    assert message in outcome.err.replace("\n", " ")


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 1000), share=st.floats(0.005, 0.1), tilt=st.floats(-5.0, 5.0))
def test_noise_that_a_table_does_not_tell_is_learnt_from_the_scatter(seed, share, tilt):
    random = np.random.default_rng(seed)
    x, y = 0.05 * random.uniform(size=(2, 300))
    k = 400.0 * np.exp(tilt * x + share * random.standard_normal(300))
    stiff = np.hypot(x - 0.02, y - 0.03) < 0.006
    assert scatter(x, y, np.where(stiff, 2.0 * k, k)) == pytest.approx(share, rel=0.5)


def test_a_table_without_errors_has_a_map_that_says_what_stands_for_them(run, tmp_path):
    without = {name: values for name, values in table().items() if name != "k_sd"}
    outcome = run("map", write(tmp_path / "sites.csv", without))
    assert outcome.status == 0, outcome.err
    assert "k_sd is not given: the scatter of sites about their neighbours" in outcome.out


SQUARE = {"x": [0.0, 0.04, 0.04, 0.0], "y": [0.0, 0.0, 0.04, 0.04]}
LEFT = {"x": [-0.001, 0.03, 0.03, -0.001], "y": [-0.001, -0.001, 0.041, 0.041]}


def test_the_next_sites_are_in_the_area_and_in_no_zone(run, tmp_path):
    path, area = write(tmp_path / "sites.csv", table()), write(tmp_path / "area.csv", SQUARE)
    zone = write(tmp_path / "zone.csv", LEFT)
    outcome = run("map", path, "--next", 5, "--within", area, "--no-go", zone, "--json", "out.json")
    assert outcome.status == 0, outcome.err
    assert "next site" in outcome.out
    found = json.loads((tmp_path / "out.json").read_text())
    assert [set(one) for one in found["next"]] == 5 * [{"x", "y", "gain", "purpose"}]
    for one in found["next"]:
        assert 0.03 < one["x"] <= 0.04
        assert 0.0 <= one["y"] <= 0.04
        assert one["gain"] > 0.0
    assert found["answer"]["text"] in " ".join(outcome.out.split())
    from_python = tp.map(path, within=area, no_go=[LEFT], next=5)
    assert json.loads(json.dumps(from_python.to_dict())) == found
    assert from_python.next[0].x == found["next"][0]["x"]


def test_a_map_within_an_area_speaks_of_all_of_it(tmp_path):
    x, y = (each.ravel() for each in np.meshgrid(*[np.linspace(0.0, 0.02, 5)] * 2))
    corner = {"x": x, "y": y, "k": np.full(25, 450.0), "k_sd": np.full(25, 1.0)}
    near, all_of_it = tp.map(corner), tp.map(corner, within=SQUARE)
    assert near.map.surface.x[-1] < 0.03
    assert all_of_it.map.surface.x[-1] > 0.039
    assert np.isfinite(all_of_it.map.surface.mean[-8, -8])
    hide = all_of_it.map.could_hide
    assert np.isnan(hide.radius[hide.y.searchsorted(0.035), hide.x.searchsorted(0.035)])


@pytest.mark.parametrize(
    ("corners", "arguments", "message"),
    [
        (None, ("--next", "3"), "--next is of an area: give --within"),
        ({"x": [0.0, 0.01], "y": [0.0, 0.01]}, (), "--within: a polygon has shape (2, 2)"),
        ({"x": [0.0, 0.01, 0.02], "y": [0.0, 0.01, 0.02]}, (), "lie on one line"),
        (
            {"x": [0.0, 0.04, 0.0, 0.04], "y": [0.0, 0.04, 0.04, 0.0]},
            (),
            "sides of a polygon cross",
        ),
        (
            {"x": [1.0, 1.04, 1.04, 1.0], "y": [0.0, 0.0, 0.04, 0.04]},
            (),
            "no site is in the area or near it: the area is at x 1 to 1.04 m, y 0 to 0.04 m, the "
            "sites are at x 0 to 0.04 m, y 0 to 0.04 m",
        ),
        ({"a": [0.0, 0.01, 0.0], "y": [0.0, 0.0, 0.01]}, (), "has no column x"),
        (SQUARE, ("--next", "101"), "from 1 to 100"),
        (SQUARE, ("--next", "3", "--no-go", "area.csv"), "no place is left"),
    ],
)
def test_areas_that_make_no_question_are_refused_in_a_sentence(
    run, tmp_path, corners, arguments, message
):
    path = write(tmp_path / "sites.csv", table())
    within = () if corners is None else ("--within", write(tmp_path / "area.csv", corners))
    outcome = run("map", path, *within, *arguments)
    assert outcome.status != 0
    assert message in " ".join(outcome.err.split())


LEFT_AS_ARRAYS = [np.array(LEFT[name]) for name in "xy"]


def turned_by_a_quarter(x, y, z=0.0):
    """Another frame, turned about z and set off."""
    return 0.1 - np.asarray(y), 0.2 + np.asarray(x), 0.3 + np.asarray(z)


def pairs(**changed):
    x, y, z = np.array([0.0, 0.04, 0.0, 0.04]), np.array([0.0, 0.0, 0.04, 0.04]), np.full(4, 0.005)
    off = 0.0001 * np.array([1.0, -1.0, -1.0, 1.0])  # what no rigid motion makes
    there = dict(zip("XYZ", turned_by_a_quarter(x, y, z + off), strict=True))
    return {"x": x, "y": y, "z": z, **there, **changed}


def test_point_pairs_give_the_results_in_another_frame_with_their_error(run, tmp_path):
    path = write(tmp_path / "sites.csv", table(z=np.full(49, 0.005)))
    register = write(tmp_path / "pairs.csv", pairs())
    files = ("--json", "out.json", "--csv", "out.csv", "--ply", "out.ply", "--raster", "2")
    outcome = run("map", path, "--register", register, *files)
    assert outcome.status == 0, outcome.err
    assert "registered by 4 pairs, which stay 0.1 mm apart (rms)" in " ".join(outcome.out.split())
    found = json.loads((tmp_path / "out.json").read_text())
    there = found["registered"]
    assert there["fiducial_error"] == pytest.approx(0.0001, rel=1e-3)
    for one, moved in zip(found["inclusions"], there["inclusions"], strict=True):
        expected = turned_by_a_quarter(one["x"], one["y"], 0.005)
        assert [moved[each] for each in "xyz"] == pytest.approx(expected, abs=1e-6)
        # A quarter turn swaps the axes of the middle's covariance.
        assert moved["covariance"][0][0] == pytest.approx(one["covariance"][1][1], rel=1e-4)
        # In the middle of four pairs it is half of what each is wrong by, and more beside it.
        assert moved["target_error"] > 0.5 * 0.0001
        ring = np.array(one["boundary_95"])
        expected = np.column_stack(turned_by_a_quarter(*ring.T, np.full(len(ring), 0.005)))
        np.testing.assert_allclose(moved["boundary_95"], expected, atol=1e-6)
    surface = found["surface"]
    x, y = np.meshgrid(surface["x"], surface["y"])
    expected = turned_by_a_quarter(x, y, np.full(x.shape, 0.005))
    for axis, layer in zip("xyz", expected, strict=True):
        np.testing.assert_allclose(there["surface"][axis], layer, atol=1e-6)
    with (tmp_path / "out.csv").open() as file:
        row = {name: float(value or "nan") for name, value in next(csv.DictReader(file)).items()}
    expected = turned_by_a_quarter(row["x"], row["y"], 0.005)
    assert [row[each] for each in "XYZ"] == pytest.approx(expected, abs=1e-6)
    data = (tmp_path / "out.ply").read_bytes().split(b"end_header\n")[1]
    assert np.frombuffer(data, "<f8").reshape(-1, 6)[:, 2] == pytest.approx(0.305, abs=1e-6)
    assert tp.map(path, register=pairs(), raster=0.002).to_dict()["registered"] == there


def test_pairs_without_heights_are_taken_in_the_plane_and_with_z_there_on_the_surface():
    sites = table(z=np.full(49, 0.005))
    in_plane = {name: each for name, each in pairs().items() if name not in "zZ"}
    flat = tp.map(sites, register=in_plane, raster=0.01).to_dict()["registered"]
    assert np.array(flat["surface"]["z"]) == pytest.approx(0.005)
    with_height = {name: each for name, each in pairs().items() if name != "z"}
    high = tp.map(sites, register=with_height, raster=0.01).to_dict()["registered"]
    assert np.array(high["surface"]["z"]) == pytest.approx(0.305, abs=1e-6)


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"X": ["a", "b", "c", "d"]}, "line 2: column X is 'a'; give a number"),
        ({"X": [0.1, 0.2, 0.05, 0.1]}, "no rigid motion fits the pairs"),
        ({"Z": None}, "has a column z, but no Z"),
        ({"Y": None}, "no column Y"),
    ],
)
def test_pairs_that_are_none_are_refused_and_the_option_named(run, tmp_path, changed, told):
    path = write(tmp_path / "sites.csv", table(3))
    given = {name: each for name, each in pairs(**changed).items() if each is not None}
    outcome = run("map", path, "--register", write(tmp_path / "pairs.csv", given))
    assert outcome.status == 1
    assert "--register" in outcome.err
    assert told in outcome.err
    assert len(outcome.err.strip().splitlines()) == 1
