"""The posterior map: what is found, how surely, and what could still hide."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tissue_probe.errors import ParameterError
from tissue_probe.mapping.posterior.posterior_map import map_of
from tissue_probe.mapping.sites import Sites


def grid(count, side=0.04):
    along = np.linspace(0.0, side, count)
    return tuple(each.ravel() for each in np.meshgrid(along, along))


def felt(x, y, *nodules, noise=0.01, seed=0, background=450.0):
    """Return k at sites over nodules of x, y, radius at half height, and contrast."""
    excess = sum(
        (c - 1.0) * 0.5 ** (((x - nx) ** 2 + (y - ny) ** 2) / r**2) for nx, ny, r, c in nodules
    )
    rng = np.random.default_rng(seed)
    return background * (1.0 + excess) * (1.0 + noise * rng.standard_normal(x.size))


def sites(x, y, k, t=None, relative=0.001):
    return Sites(x, y, np.zeros_like(x), t, k, relative * np.abs(k))


def sure(found):
    return [one for one in found.inclusions if one.probability >= 0.9]


def test_two_nodules_are_found_with_place_contrast_and_extent():
    x, y = grid(9)
    true = ((0.011, 0.012, 0.005, 2.5), (0.029, 0.027, 0.006, 0.5))
    found = sure(map_of(sites(x, y, felt(x, y, *true))))
    assert len(found) == 2
    for one, (nx, ny, radius, contrast) in zip(sorted(found, key=lambda o: o.x), true, strict=True):
        assert np.hypot(one.x - nx, one.y - ny) < 0.001
        assert one.contrast == pytest.approx(contrast, rel=0.1)
        assert one.stiffness == pytest.approx(450.0 * contrast, rel=0.1)
        far = np.hypot(*(one.boundary_50 - [nx, ny]).T)
        assert far.mean() == pytest.approx(radius, abs=0.001)
        assert np.sqrt(np.diag(one.covariance)).max() < 0.0015


def test_boundaries_lie_around_one_another():
    x, y = grid(7)
    (one,) = sure(map_of(sites(x, y, felt(x, y, (0.02, 0.021, 0.006, 2.0)))))
    areas = [area(getattr(one, f"boundary_{p}")) for p in (50, 90, 95)]
    assert areas == sorted(areas)
    assert areas[0] == pytest.approx(np.pi * 0.006**2, rel=0.2)


def area(ring):
    a, b = ring.T
    return 0.5 * abs(a @ np.roll(b, 1) - b @ np.roll(a, 1))


def test_nodules_side_by_side_are_two():
    x, y = grid(9)
    true = ((0.013, 0.02, 0.004, 2.5), (0.027, 0.02, 0.004, 2.5))
    found = sure(map_of(sites(x, y, felt(x, y, *true))))
    assert sorted(round(1e3 * one.x) for one in found) == [13, 27]


@pytest.mark.parametrize("seed", range(3))
def test_plain_tissue_has_no_inclusion_and_little_room(seed):
    x, y = grid(7)
    found = map_of(sites(x, y, felt(x, y, noise=0.02, seed=seed)))
    assert sure(found) == []
    assert found.background.stiffness == pytest.approx(450.0, rel=0.03)
    assert np.quantile(found.could_hide.radius, 0.9) < 0.005
    assert np.abs(found.surface.mean / 450.0 - 1.0).max() < 0.06


def test_a_tilt_is_background():
    x, y = grid(7)
    k = felt(x, y, noise=0.02) * (1.0 + 0.5 * (x / 0.04 - 0.5))
    found = map_of(sites(x, y, k))
    assert sure(found) == []
    assert found.background.tilt[0] == pytest.approx(0.5 / 0.04, rel=0.2)


def test_relaxation_during_the_scan_is_drift():
    x, y = grid(5)
    t = 1.57 * np.random.default_rng(0).permutation(25)  # row by row it would be a tilt, too
    k = felt(x, y, noise=0.01) * (1.0 + 0.4 * np.exp(-t / 15.0))
    found = map_of(sites(x, y, k, t))
    assert sure(found) == []
    assert found.background.drift == pytest.approx(0.36, abs=0.15)


def test_a_nodule_between_sites_is_not_denied():
    """Midway between four sites 10 mm apart a nodule of 3 mm is not felt; it could be there."""
    x, y = grid(5)
    found = map_of(sites(x, y, felt(x, y, (0.015, 0.015, 0.0025, 2.5))))
    row, column = (int(np.abs(axis - 0.015).argmin()) for axis in (found.could_hide.y,) * 2)
    assert found.could_hide.radius[row, column] >= 0.0025


def test_a_denser_scan_leaves_less_room():
    room = []
    for count in (5, 9):
        x, y = grid(count)
        hide = map_of(sites(x, y, felt(x, y, noise=0.01))).could_hide
        room.append(np.median(hide.radius))
    assert room[1] < 0.8 * room[0]


def test_a_stronger_contrast_hides_less():
    x, y = grid(5)
    table = sites(x, y, felt(x, y, noise=0.03))
    weak, strong = (map_of(table, contrast=c).could_hide.radius for c in (1.3, 3.0))
    weak, strong = (np.where(np.isnan(each), 0.01, each) for each in (weak, strong))
    assert strong.mean() < weak.mean()


def test_the_same_sites_in_another_order_have_the_same_map():
    x, y = grid(5)
    table = sites(x, y, felt(x, y, (0.021, 0.018, 0.005, 2.0)), t=np.arange(25.0))
    order = np.random.default_rng(1).permutation(25)
    names = ("x", "y", "z", "t", "k", "k_sd")
    mixed = replace(table, **{name: getattr(table, name)[order] for name in names})
    first, second = map_of(table), map_of(mixed)
    assert np.array_equal(first.surface.mean, second.surface.mean)
    assert np.array_equal(first.could_hide.radius, second.could_hide.radius, equal_nan=True)
    assert [one.probability for one in first.inclusions] == [
        one.probability for one in second.inclusions
    ]


def test_sites_too_far_apart_for_the_raster_are_refused_before_the_chains_run(monkeypatch):
    def run(*given):
        raise AssertionError("chains run")

    monkeypatch.setattr("tissue_probe.mapping.posterior.posterior_sample.Chains.further", run)
    x, y = grid(5)
    x[0] = 90.0  # m: one of the millimetres of a careless table
    with pytest.raises(ParameterError, match="if these are mm"):
        map_of(sites(x, y, felt(x, y)))


def test_a_raster_is_as_fine_as_asked():
    x, y = grid(5)
    surface = map_of(sites(x, y, felt(x, y)), raster=0.002).surface
    assert np.diff(surface.x) == pytest.approx(0.002)
    assert surface.mean.shape == surface.sd.shape == (surface.y.size, surface.x.size)
    assert surface.x[0] <= 0.0
    assert surface.x[-1] >= 0.04


def test_sites_outside_the_tissue_leave_a_rim_unknown():
    x, y = grid(7)
    k = felt(x, y)
    off = x > 0.034
    k[off] = 25.0  # half a contact
    found = map_of(sites(x, y, k))
    columns = np.broadcast_to(found.surface.x, found.surface.mean.shape)
    assert np.isnan(found.surface.mean[columns > 0.038]).all()
    assert np.isfinite(found.surface.mean[columns < 0.034]).all()
    assert sure(found) == []
    assert "7 of 49 sites feel less than 10%" in found.check.notes[0]


def test_three_sites_tell_no_inclusion_and_exclude_none():
    x, y = np.array([0.0, 0.01, 0.0]), np.array([0.0, 0.0, 0.01])
    found = map_of(sites(x, y, np.array([450.0, 900.0, 440.0])))
    assert found.inclusions == ()
    assert np.isnan(found.could_hide.radius).all()
    assert "3 sites cannot tell an inclusion from a tilted background" in found.check.notes[0]


@pytest.mark.parametrize("visits", [1, 2, 5])
def test_one_place_has_a_map_and_a_background_as_unsure_as_what_could_lie_there(visits):
    """Nothing tells whether it lies on an inclusion: the background could be that much softer."""
    place = np.zeros(visits)
    found = map_of(sites(place, place, np.full(visits, 500.0)))
    assert np.nanmedian(found.surface.mean) == pytest.approx(500.0, rel=0.05)
    assert found.background.stiffness == pytest.approx(500.0, rel=0.02)
    assert 75.0 < found.background.stiffness_sd < 250.0
    assert found.inclusions == ()
    assert "cannot tell an inclusion from a tilted background" in found.check.notes[0]


def test_visits_of_one_place_that_contradict_one_another_are_told():
    place, k = np.full(2, 0.01), np.array([500.0, 900.0])
    found = map_of(sites(place, place, k))
    assert "at x 10 mm, y 10 mm visits felt 500 and 900 N/m" in found.check.notes[0]
    assert abs(found.background.stiffness - 671.0) < found.background.stiffness_sd
    assert found.background.stiffness_sd > 100.0
    rough = map_of(sites(place, place, k, relative=0.3))
    assert not any("visits felt" in note for note in rough.check.notes)


def test_sites_all_alike_are_plain_tissue():
    x, y = grid(5)
    found = map_of(sites(x, y, np.full(25, 450.0), relative=0.0))
    assert sure(found) == []
    known = np.isfinite(found.surface.mean)
    assert known.mean() > 0.9
    off = np.abs(found.surface.mean[known] / 450.0 - 1.0)
    assert np.median(off) < 1e-3
    assert off.max() < 0.1  # midway between four sites a stiff one with a hard edge is not felt
    assert np.isfinite(found.surface.sd[known]).all()


def test_a_site_that_was_rejected_three_times_is_unknown_and_the_others_are_not():
    x, y = grid(7)
    k = np.concatenate([felt(x, y, noise=0.01), [np.nan] * 2])
    k[24] = np.nan
    x, y = (np.append(each, [0.02, 0.02]) for each in (x, y))
    table = replace(sites(x, y, k), k_sd=np.where(np.isnan(k), np.nan, 1.0))
    found = map_of(table)
    assert "3 of 51 sites have no value" in found.check.notes[0]
    row, column = (np.abs(axis - 0.02).argmin() for axis in (found.surface.y, found.surface.x))
    assert np.isnan(found.surface.mean[row, column])
    assert np.isnan(found.surface.mean).mean() < 0.05
    hide = found.could_hide
    row, column = (np.abs(axis - 0.02).argmin() for axis in (hide.y, hide.x))
    assert np.isnan(hide.radius[row, column]) or hide.radius[row, column] > 0.003


def test_tissue_that_is_stiff_for_the_most_part_is_told():
    x, y = grid(7)
    k = felt(x, y, noise=0.01) * np.where(x < 0.024, 2.0, 1.0)
    found = map_of(sites(x, y, k))
    assert any("which tissue is the background" in note for note in found.check.notes)
    columns = np.broadcast_to(found.surface.x, found.surface.mean.shape)
    assert np.median(found.surface.mean[columns < 0.018]) == pytest.approx(900.0, rel=0.1)
    assert np.median(found.surface.mean[columns > 0.032]) == pytest.approx(450.0, rel=0.1)


def test_sites_that_no_inclusions_explain_are_mapped_by_a_gaussian_process():
    x, y = grid(7)
    stiff = np.random.default_rng(3).random(49) < 0.6
    k = felt(x, y, noise=0.01) * np.where(stiff, 2.0, 1.0)
    found = map_of(sites(x, y, k))
    assert found.check.model == "gaussian_process"
    assert any("Gaussian process" in note for note in found.check.notes)
    at = [
        found.surface.mean[
            np.abs(found.surface.y - b).argmin(), np.abs(found.surface.x - a).argmin()
        ]
        for a, b in zip(x, y, strict=True)
    ]
    assert np.array(at) == pytest.approx(k, rel=0.15)


def test_repeats_of_a_site_make_it_surer():
    x, y = grid(5)
    sd = []
    for repeats in (1, 6):
        places = np.tile(x, repeats), np.tile(y, repeats)
        k = felt(*places, noise=0.05, seed=4)
        found = map_of(sites(*places, k, relative=0.05))
        sd.append(np.median(found.surface.sd))
    assert sd[1] < 0.8 * sd[0]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"raster": 0.0}, "raster is 0 m"),
        ({"raster": float("nan")}, "raster is nan m"),
        ({"raster": 1e-6}, "make raster coarser"),
        ({"raster": 5e-324}, "make raster coarser"),
        ({"contrast": 1.0}, "contrast is 1.0"),
    ],
)
def test_parameters_out_of_range_are_refused(wrong, message):
    x, y = grid(3)
    with pytest.raises(ParameterError, match=message):
        map_of(sites(x, y, felt(x, y)), **wrong)


def test_sites_in_millimetres_are_refused_before_anything_is_computed():
    x, y = grid(7)
    with pytest.raises(ParameterError, match=r"span 40 x 40 m.*are these mm"):
        map_of(sites(1e3 * x, 1e3 * y, felt(x, y)))


def test_no_site_with_a_value_is_refused():
    x, y = grid(3)
    with pytest.raises(ParameterError, match="none of 9 sites has a stiffness above 0"):
        map_of(sites(x, y, np.full(9, np.nan)))


@pytest.mark.battery
@settings(max_examples=4, deadline=None)
@given(
    st.lists(
        st.tuples(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.floats(1.0, 1e5)),
        min_size=1,
        max_size=12,
    ),
    st.floats(0.0, 0.5),
)
def test_any_sites_have_a_map_of_finite_numbers(rows, relative):
    x, y, k = (np.array(column) for column in zip(*rows, strict=True))
    found = map_of(sites(x, y, k, relative=relative), raster=0.004)
    known = np.isfinite(found.surface.mean)
    assert known.any()
    assert (found.surface.mean[known] > 0.0).all()
    assert np.isfinite(found.surface.sd[known]).all()
    probabilities = [one.probability for one in found.inclusions]
    assert all(0.0 <= p <= 1.0 for p in probabilities)
    assert probabilities == sorted(probabilities, reverse=True)


def test_a_form_that_the_model_has_not_is_not_made_up_of_further_inclusions():
    """A tail like that of a pressed half-space falls as a power of the distance."""
    x, y = grid(9)
    squared = ((x - 0.021) ** 2 + (y - 0.019) ** 2) / 0.007**2
    found = map_of(sites(x, y, 450.0 * (1.0 + 1.2 * (1.0 + squared) ** -1.5)))
    assert [one.probability > 0.9 for one in found.inclusions] == [True]
    assert found.check.disagreement <= 0.05


def test_a_disc_with_a_hard_edge_is_where_its_ellipse_says_and_within_its_boundary():
    """Sites tell a hard edge only to lie between two of them: a form with a blunt one is sure."""
    x, y = grid(7)
    rng = np.random.default_rng(7)
    off, held = [], []
    for _ in range(8):
        place, radius = rng.uniform(0.01, 0.03, 2), rng.uniform(0.005, 0.007)
        inside = np.hypot(x - place[0], y - place[1]) < radius
        k = 400.0 * (1.0 + inside) * (1.0 + 0.02 * rng.standard_normal(x.size))
        (one,) = sure(map_of(sites(x, y, k, relative=0.02)))
        apart = np.array([one.x, one.y]) - place
        off.append(apart @ np.linalg.solve(one.covariance, apart))
        held.append(np.hypot(*(one.boundary_95 - place).T).min() > radius - 5e-4)
    assert sum(chi2 < 6.0 for chi2 in off) >= 6
    assert sum(held) >= 6
