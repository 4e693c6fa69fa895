"""The map builder: which estimates count, and how they are fused."""

import math
import sys
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tissue_probe.mapping.fusion import (
    Estimate,
    MapBuilder,
    fuse_stddev,
    inverse_variance_weights,
)
from tissue_probe.mapping.grid import Grid
from tissue_probe.mapping.verdict import CellVerdict
from tissue_probe.signals import TEXT, Leaving, PalpationSite, Phase, Status, TissueEstimates

GRID = Grid((0.0, 0.0, 0.0), 0.01, rows=2, columns=3)
SECOND = 1_000_000_000


def announcement(stamp, site, phase):
    return PalpationSite(stamp, site, GRID.position(site), phase)


def over_the_grid():
    """A builder that has heard of every site of the grid, long before anything was measured."""
    builder = MapBuilder()
    for site in range(len(GRID)):
        builder.announce(announcement(site - 100, site, Phase.APPROACH))
    return builder


def dwelling(site=0, begin=0):
    builder = over_the_grid()
    builder.announce(announcement(begin, site, Phase.DWELL))
    return builder


def estimate(stamp=1, stiffness=450.0, **changed):
    values = {
        "damping": 5.0,
        "covariance_trace": 0.1,
        "stiffness_variance": 0.09,
        "damping_variance": 1e-4,
    }
    return Estimate(stamp, stiffness, **{**values, **changed})


def rows(estimator, stamps, stiffness, status=Status.CONVERGED, variance=0.09):
    n = len(stamps)
    zeros = np.zeros(n)
    return TissueEstimates(
        estimator=estimator,
        stamp=np.array(stamps, dtype=np.int64),
        sequence=np.array(stamps, dtype=np.int64),
        stiffness=np.array(stiffness, dtype=float),
        damping=np.full(n, 5.0),
        covariance_trace=np.full(n, 0.1),
        stiffness_variance=np.broadcast_to(variance, n).astype(float),
        damping_variance=np.full(n, 1e-4),
        stiffness_damping_covariance=zeros,
        force_offset=zeros,
        predicted_force=zeros,
        innovation=zeros,
        normalized_innovation_squared=zeros,
        status=np.broadcast_to(status, n).astype(np.uint8),
        model=np.full(n, "kelvin_voigt", TEXT),
    )


def test_an_untouched_map_is_nan_everywhere():
    built = over_the_grid().map()
    for layer in (built.stiffness, built.damping, built.covariance_trace, built.stiffness_stddev):
        assert layer.shape == (2, 3)
        assert np.isnan(layer).all()
    assert built.stamp == 0


@pytest.mark.parametrize("site", range(6))
def test_an_estimate_lands_in_the_cell_under_the_tip_and_nowhere_else(site):
    builder = dwelling(site)
    builder.add_one("ekf", Status.CONVERGED, estimate(stamp=7))
    built = builder.map()
    assert built.stiffness[GRID.cell(site)] == 450.0
    assert built.damping[GRID.cell(site)] == 5.0
    assert built.covariance_trace[GRID.cell(site)] == 0.1
    assert built.stiffness_stddev[GRID.cell(site)] == pytest.approx(0.3)
    assert built.damping_stddev[GRID.cell(site)] == pytest.approx(0.01)
    assert built.measured.sum() == 1
    assert built.stamp == 7


REASONS = {
    Status.CONVERGING: CellVerdict.NOT_CONVERGED,
    Status.NO_CONTACT: CellVerdict.NO_CONTACT,
    Status.MODEL_REJECTED: CellVerdict.MODEL_REJECTED,
}


@pytest.mark.parametrize("status", REASONS)
@pytest.mark.parametrize("one_by_one", [True, False])
def test_what_an_estimator_knew_before_counts_nothing_if_the_dwell_did_not_end_so(
    status, one_by_one
):
    builder = dwelling()
    if one_by_one:
        builder.add_one("ekf", Status.CONVERGED, estimate(stamp=1))
        builder.add_one("ekf", status, estimate(stamp=2))
    else:
        builder.add(rows("ekf", [1, 2], [450.0, 450.0], [Status.CONVERGED, status]))
    built = builder.map()
    assert not built.measured.any()
    assert built.verdict[0, 0] == REASONS[status]
    assert built.stamp == 2


def test_an_estimator_that_rejects_is_left_out_and_the_others_count():
    builder = dwelling()
    builder.add_one("ekf", Status.MODEL_REJECTED, estimate(stiffness=9000.0))
    builder.add_one("ukf", Status.CONVERGED, estimate(stiffness=450.0))
    built = builder.map()
    assert built.stiffness[0, 0] == 450.0
    assert built.verdict[0, 0] == CellVerdict.MEASURED


def test_a_disturbed_estimate_is_used_and_told():
    builder = dwelling()
    builder.add_one("ekf", Status.CONVERGED, estimate())
    builder.add_one("ukf", Status.DISTURBED, estimate())
    assert builder.map().verdict[0, 0] == CellVerdict.DISTURBED
    assert builder.map().stiffness[0, 0] == 450.0


def test_a_cell_that_was_palpated_without_any_estimate_says_so_once_the_dwell_has_ended():
    builder = dwelling(begin=10)
    assert builder.map().verdict[0, 0] == CellVerdict.NOT_PALPATED
    builder.announce(announcement(20, 0, Phase.LIFTED))
    built = builder.map()
    assert built.verdict[0, 0] == CellVerdict.NO_ESTIMATE
    assert built.stamp == 20
    assert (built.verdict.ravel()[1:] == CellVerdict.NOT_PALPATED).all()


def test_the_gravest_reason_is_told_where_no_estimator_is_usable():
    builder = dwelling()
    builder.add_one("ekf", Status.NO_CONTACT, estimate())
    assert builder.map().verdict[0, 0] == CellVerdict.NO_CONTACT
    builder.add_one("robust_ekf", Status.MODEL_REJECTED, estimate())
    builder.add_one("ukf", Status.CONVERGING, estimate())
    assert builder.map().verdict[0, 0] == CellVerdict.MODEL_REJECTED


def test_estimates_after_the_end_are_undone_when_the_end_is_heard_of_late():
    builder = dwelling()
    builder.add_one("ekf", Status.CONVERGED, estimate(stamp=9, stiffness=450.0))
    builder.add_one("ekf", Status.NO_CONTACT, estimate(stamp=10, stiffness=0.0))
    assert not builder.map().measured.any()
    builder.announce(announcement(10, 0, Phase.LIFTED))
    assert builder.map().stiffness[0, 0] == 450.0


def test_an_estimate_that_arrives_after_a_newer_one_changes_nothing():
    builder = dwelling()
    builder.add_one("ekf", Status.CONVERGED, estimate(stamp=2, stiffness=450.0))
    revision = builder.revision
    builder.add_one("ekf", Status.CONVERGED, estimate(stamp=1, stiffness=400.0))
    assert builder.map().stiffness[0, 0] == 450.0
    assert builder.revision == revision


def test_only_estimates_stamped_within_the_dwell_count():
    builder = over_the_grid()
    builder.announce(announcement(0, 0, Phase.APPROACH))
    builder.announce(announcement(10, 0, Phase.DWELL))
    builder.announce(announcement(20, 0, Phase.LIFTED))
    builder.add(rows("ekf", [9], [400.0]))
    builder.add(rows("ukf", [20], [400.0]))
    assert not builder.map().measured.any()
    builder.add(rows("ekf", [9, 10, 19, 20], [1.0, 2.0, 450.0, 3.0]))
    assert builder.map().stiffness[0, 0] == 450.0


@pytest.mark.parametrize("one_by_one", [True, False])
def test_estimates_arriving_after_lifting_count_for_the_dwell_they_were_made_in(one_by_one):
    builder = dwelling(site=0, begin=0)
    builder.announce(announcement(10, 0, Phase.LIFTED))
    builder.announce(announcement(20, 1, Phase.DWELL))
    if one_by_one:
        builder.add_one("ekf", Status.CONVERGED, estimate(stamp=9))
    else:
        builder.add(rows("ekf", [9], [450.0]))
    assert builder.map().measured.nonzero() == ((0,), (0,))


def test_a_dwell_announced_ahead_begins_at_its_stamp():
    builder = dwelling(site=2, begin=100)
    builder.add_one("ekf", Status.CONVERGED, estimate(stamp=99))
    assert not builder.map().measured.any()
    builder.add_one("ekf", Status.CONVERGED, estimate(stamp=100))
    assert builder.map().measured[0, 2]


def test_a_scan_cut_short_replaces_the_phases_announced_ahead():
    builder = dwelling(site=0, begin=10)
    builder.announce(announcement(100, 0, Phase.LIFTED))
    builder.announce(announcement(110, 1, Phase.DWELL))
    builder.announce(announcement(50, 0, Phase.LIFTED))
    builder.add(rows("ekf", [60, 120], [450.0, 450.0]))
    assert not builder.map().measured.any()


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_site_at_no_place_is_refused_and_changes_nothing(bad):
    builder = dwelling(site=0, begin=0)
    with pytest.raises(ValueError, match="no place"):
        builder.announce(PalpationSite(10, 9, (bad, 0.0, 0.0), Phase.DWELL))
    builder.add_one("ekf", Status.CONVERGED, estimate(stamp=11))
    assert builder.map().measured[0, 0]


def test_a_dwell_that_was_announced_ahead_and_never_came_leaves_no_trace():
    builder = dwelling(site=0, begin=100)
    builder.announce(announcement(50, 0, Phase.LIFTED))
    assert builder.map().verdict[0, 0] == CellVerdict.NOT_PALPATED


@pytest.mark.parametrize("status", [Status.NO_CONTACT, Status.MODEL_REJECTED])
def test_a_second_visit_that_ends_without_a_value_takes_the_first_one_away(status):
    builder = dwelling(site=0, begin=0)
    builder.add_one("ekf", Status.CONVERGED, estimate(stamp=1))
    builder.announce(announcement(10, 0, Phase.LIFTED))
    builder.announce(announcement(20, 0, Phase.DWELL))
    builder.add_one("ekf", status, estimate(stamp=21))
    assert not builder.map().measured.any()


def test_a_result_tells_why_its_dwell_ended():
    builder = dwelling(site=0, begin=0)
    assert builder.results(under_way=False) == []
    builder.announce(replace(announcement(10, 0, Phase.LIFTED), leaving=Leaving.TOLD_ENOUGH))
    builder.announce(announcement(20, 0, Phase.DWELL))
    builder.announce(announcement(30, 0, Phase.LIFTED))
    assert [one.leaving for one in builder.results()] == [Leaving.TOLD_ENOUGH, Leaving.UNTOLD]


def test_a_second_visit_of_which_nothing_is_known_leaves_the_first_value():
    builder = dwelling(site=0, begin=0)
    builder.add_one("ekf", Status.CONVERGED, estimate(stamp=1))
    builder.announce(announcement(10, 0, Phase.LIFTED))
    builder.announce(announcement(20, 0, Phase.DWELL))
    builder.add_one("ekf", Status.CONVERGING, estimate(stamp=21))
    builder.announce(announcement(30, 0, Phase.LIFTED))
    assert builder.map().stiffness[0, 0] == 450.0


def test_a_second_visit_replaces_the_first_once_it_converges():
    builder = dwelling(site=0, begin=1)
    builder.add_one("ekf", Status.CONVERGED, estimate(stamp=1, stiffness=400.0))
    builder.add_one("ukf", Status.CONVERGED, estimate(stamp=1, stiffness=400.0))
    builder.announce(announcement(10, 0, Phase.LIFTED))
    builder.announce(announcement(20, 0, Phase.DWELL))
    assert builder.map().stiffness[0, 0] == 400.0
    assert builder.map().dwell_begin.tolist() == [[1, 0, 0], [0, 0, 0]]
    builder.add_one("ekf", Status.CONVERGED, estimate(stamp=21, stiffness=900.0))
    assert builder.map().stiffness[0, 0] == 900.0
    assert builder.map().dwell_begin.tolist() == [[20, 0, 0], [0, 0, 0]]
    builder.add_one("afekf", Status.CONVERGED, estimate(stamp=5, stiffness=400.0))
    assert builder.map().stiffness[0, 0] == 900.0


def test_a_replay_that_begins_again_measures_again():
    builder = dwelling(site=0, begin=0)
    builder.add_one("ekf", Status.CONVERGED, estimate(stamp=5, stiffness=400.0))
    builder.announce(announcement(10, 0, Phase.LIFTED))
    builder.announce(announcement(0, 0, Phase.DWELL))
    builder.add_one("ekf", Status.CONVERGED, estimate(stamp=3, stiffness=900.0))
    assert builder.map().stiffness[0, 0] == 900.0


@pytest.mark.parametrize(
    "bad",
    [
        {"stiffness_variance": 0.0},
        {"stiffness_variance": -1.0},
        {"stiffness_variance": math.nan},
        {"stiffness_variance": math.inf},
        {"damping_variance": 0.0},
        {"damping_variance": math.nan},
        {"stiffness": math.nan},
        {"damping": math.inf},
        {"covariance_trace": math.nan},
    ],
)
def test_an_estimate_without_a_finite_value_and_a_positive_variance_is_refused(bad):
    builder = dwelling()
    builder.add_one("ekf", Status.CONVERGED, estimate(stamp=1))
    builder.add_one("ekf", Status.CONVERGED, estimate(**{"stamp": 2, "stiffness": 9.0, **bad}))
    assert builder.map().stiffness[0, 0] == 450.0


def test_a_refused_estimate_leaves_the_one_before_it_standing():
    builder = dwelling()
    builder.add(rows("ekf", [1, 2, 3], [450.0, 500.0, math.nan], variance=[0.09, 0.0, 0.09]))
    assert builder.map().stiffness[0, 0] == 450.0


def test_the_revision_rises_with_every_change_of_the_map():
    builder = dwelling()
    builder.add_one("ekf", Status.CONVERGED, estimate(stamp=1))
    first = builder.revision
    builder.add_one("ukf", Status.CONVERGED, estimate(stamp=1))
    assert 0 < first < builder.revision


finite = st.floats(-1e5, 1e5)
variances = st.floats(1e-300, 1e300)


@given(
    st.lists(st.tuples(finite, finite, variances, variances), min_size=1, max_size=6),
    st.data(),
)
def test_fusion_does_not_depend_on_the_order_and_stays_within_the_estimates(found, data):
    named = [
        (f"filter {number}", estimate(1, k, damping=b, stiffness_variance=vk, damping_variance=vb))
        for number, (k, b, vk, vb) in enumerate(found)
    ]
    maps = []
    for order in (named, data.draw(st.permutations(named))):
        builder = dwelling()
        for name, one in order:
            builder.add_one(name, Status.CONVERGED, one)
        maps.append(builder.map())
    fused = maps[0]
    assert fused.stiffness[0, 0] == maps[1].stiffness[0, 0]
    k, b, vk, _ = np.array(found).T
    assert k.min() - 1e-6 <= fused.stiffness[0, 0] <= k.max() + 1e-6
    assert b.min() - 1e-6 <= fused.damping[0, 0] <= b.max() + 1e-6
    assert math.isfinite(fused.covariance_trace[0, 0])
    stddev = fused.stiffness_stddev[0, 0]
    largest = math.hypot(np.sqrt(vk.max()), k.max() - k.min())
    assert np.sqrt(vk.min()) * (1 - 1e-9) <= stddev <= largest * (1 + 1e-9)


@given(st.lists(st.floats(1e-3, 1e3), min_size=1, max_size=6))
def test_weights_are_inverse_to_the_variances_and_sum_to_one(values):
    variance = np.array(values)
    weights = inverse_variance_weights(variance)
    assert weights.sum() == pytest.approx(1.0)
    assert np.allclose(weights * variance, weights[0] * variance[0])


@given(st.lists(st.tuples(st.integers(0, 60), st.integers(0, 4), finite), max_size=30))
def test_many_estimates_at_once_give_the_same_map_as_one_by_one(found):
    stamps, status, stiffness = zip(*found, strict=True) if found else ((), (), ())
    together, apart = over_the_grid(), over_the_grid()
    for builder in (together, apart):
        for site in range(len(GRID)):
            builder.announce(announcement(10 * site, site, Phase.DWELL))
            builder.announce(announcement(10 * site + 8, site, Phase.LIFTED))
    together.add(rows("ekf", stamps, stiffness, np.array(status, dtype=np.uint8)))
    for stamp, state, k in found:
        apart.add_one("ekf", state, estimate(stamp=stamp, stiffness=k))
    np.testing.assert_array_equal(together.map().stiffness, apart.map().stiffness)
    np.testing.assert_array_equal(together.map().verdict, apart.map().verdict)


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.9, 1.0])
def test_the_fused_standard_deviation_is_not_overconfident(correlation):
    rng = np.random.default_rng(7)
    sigma = np.array([0.2, 0.3, 0.5])
    covariance = np.outer(sigma, sigma) * np.where(np.eye(3, dtype=bool), 1.0, correlation)
    errors = rng.multivariate_normal(np.zeros(3), covariance, size=20_000)
    weights = inverse_variance_weights(sigma**2)
    claimed = fuse_stddev(weights, np.full(3, 450.0), sigma**2)
    observed = (errors @ weights).std()
    assert observed < 1.02 * claimed
    if correlation == 1.0:
        assert observed > 0.98 * claimed  # and it is no larger than it must be
        independent = 1.0 / np.sqrt(np.sum(1.0 / sigma**2))
        assert independent < 0.8 * observed  # what textbook fusion would have claimed


def test_the_standard_deviation_holds_the_spread_between_the_estimators():
    builder = dwelling()
    for name, k in (("ekf", 450.0), ("ukf", 550.0)):
        builder.add_one(name, Status.CONVERGED, estimate(stiffness=k, stiffness_variance=0.16))
    assert builder.map().stiffness[0, 0] == 500.0
    assert builder.map().stiffness_stddev[0, 0] == pytest.approx(math.hypot(0.4, 50.0))


def test_more_estimators_of_one_accuracy_do_not_make_the_map_more_certain():
    builder = dwelling()
    for name in ("ekf", "ukf", "afekf"):
        builder.add_one(name, Status.CONVERGED, estimate())
    assert builder.map().stiffness_stddev[0, 0] == pytest.approx(0.3)


def calls_of_one_estimate(builder, stamps):
    """How many calls a live estimate takes: its work, on a machine of any speed."""
    made = estimate(next(stamps))
    calls = Counter()
    sys.setprofile(lambda frame, event, what: calls.update([event]))
    try:
        builder.add_one("ekf", Status.CONVERGED, made)
    finally:
        sys.setprofile(None)
    return calls["call"] + calls["c_call"]


def test_one_live_estimate_costs_little_however_many_came_before():
    builder = over_the_grid()
    for site in range(len(GRID)):
        builder.announce(announcement(site * SECOND, site, Phase.DWELL))
    stamps = iter(range(5 * SECOND, 6 * SECOND))
    builder.add_one("ekf", Status.CONVERGED, estimate(next(stamps)))  # an estimator is heard of
    first = calls_of_one_estimate(builder, stamps)
    for _ in range(2000):
        builder.add_one("ekf", Status.CONVERGED, estimate(next(stamps)))
    assert calls_of_one_estimate(builder, stamps) <= first
    assert first < 50  # three times those of today


@pytest.mark.parametrize("why", [Leaving.NO_CONTACT, Leaving.IN_CONTACT, Leaving.FORCE_LIMIT])
def test_a_site_where_no_surface_was_found_is_a_visit_without_value(why):
    builder = over_the_grid()
    builder.announce(replace(announcement(5, 1, Phase.LIFTED), leaving=why))
    builder.add_one("ekf", Status.CONVERGED, estimate(5))
    (one,) = builder.results(under_way=False)
    assert (one.site, one.verdict, one.leaving) == (1, CellVerdict.CONTACT_NOT_FOUND, why)
    assert math.isnan(one.stiffness)
    found = builder.map()
    assert found.verdict[0, 1] == CellVerdict.CONTACT_NOT_FOUND
    assert not found.measured.any()


def test_a_place_whose_surface_was_not_found_again_keeps_the_value_before():
    builder = dwelling(site=1)
    builder.add_one("ekf", Status.CONVERGED, estimate(1))
    builder.announce(announcement(10, 1, Phase.LIFTED))
    builder.announce(replace(announcement(20, 1, Phase.LIFTED), leaving=Leaving.NO_CONTACT))
    assert builder.map().stiffness[0, 1] == 450.0
    assert [one.verdict for one in builder.results()] == [
        CellVerdict.MEASURED,
        CellVerdict.CONTACT_NOT_FOUND,
    ]


MILLISECOND = SECOND // 1000


def series(begin, count, stiffness, first=0, step=5 * MILLISECOND):
    """Stamps, numbers of samples and stiffnesses of estimates that follow one another."""
    return [(begin + step * i, first + 10 * i, stiffness) for i in range(count)]


def open_dwell(found, one_by_one):
    """The map of a dwell at site 0 from 0 on that no announcement ends."""
    builder = dwelling()
    if one_by_one:
        for stamp, sequence, k in found:
            builder.add_one("ekf", Status.CONVERGED, estimate(stamp, k), sequence)
    else:
        stamps, sequences, stiffness = zip(*found, strict=True)
        columns = rows("ekf", stamps, stiffness)
        builder.add(replace(columns, sequence=np.array(sequences)))
    return builder.map()


@pytest.mark.parametrize("one_by_one", [True, False])
@pytest.mark.parametrize(
    ("later", "first"),
    [(60 * SECOND, 12_000), (600 * MILLISECOND, 0)],
    ids=["after a silence", "after a new activation"],
)
def test_of_a_scan_that_died_nothing_counts_that_came_of_another_run(one_by_one, later, first):
    before = series(-200 * MILLISECOND, 60, 450.0, first=10_000)
    found = open_dwell(before + series(later, 60, 1046.0, first), one_by_one)
    assert found.stiffness[0, 0] == 450.0


@pytest.mark.parametrize("one_by_one", [True, False])
def test_samples_that_were_silent_as_the_dwell_began_are_not_of_it(one_by_one):
    before = series(-200 * MILLISECOND, 30, 450.0)
    found = open_dwell(before + series(60 * SECOND, 60, 1046.0, 10_000), one_by_one)
    assert not found.measured.any()


@pytest.mark.parametrize("one_by_one", [True, False])
def test_lost_messages_and_long_blocks_end_no_dwell(one_by_one):
    lossy = series(-200 * MILLISECOND, 60, 400.0) + series(400 * MILLISECOND, 9, 450.0, 1000)
    assert open_dwell(lossy, one_by_one).stiffness[0, 0] == 450.0
    long_blocks = series(-3 * SECOND, 9, 450.0, step=SECOND)
    assert open_dwell(long_blocks, one_by_one).stiffness[0, 0] == 450.0


def test_the_next_scan_counts_at_the_site_of_one_that_died():
    builder = dwelling()
    for begin, k in ((-SECOND, 450.0), (60 * SECOND, 500.0)):
        for stamp, sequence, stiffness in series(begin, 400, k):
            if stamp == 61 * SECOND:
                builder.announce(announcement(stamp, 0, Phase.DWELL))
            builder.add_one("ekf", Status.CONVERGED, estimate(stamp, stiffness), sequence)
    assert builder.map().stiffness[0, 0] == 500.0


@pytest.mark.parametrize("lives", [False, True])
def test_a_scan_that_falls_silent_ends_its_dwell_unless_it_says_when_it_lifted(lives):
    builder = dwelling()
    for stamp, sequence, k in series(0, 200, 450.0) + series(SECOND, 200, 1046.0, 2000):
        builder.add_one("ekf", Status.CONVERGED, estimate(stamp, k), sequence)
    builder.fall_silent(SECOND)
    assert builder.map().stiffness[0, 0] == 450.0
    builder.add_one("ekf", Status.CONVERGED, estimate(2 * SECOND, 1046.0), 4000)
    if lives:
        builder.announce(announcement(1900 * MILLISECOND, 0, Phase.LIFTED))
    else:
        builder.announce(announcement(90 * SECOND, 0, Phase.APPROACH))
    assert builder.map().stiffness[0, 0] == (1046.0 if lives else 450.0)


def test_silence_between_dwells_changes_nothing():
    builder = dwelling()
    builder.add_one("ekf", Status.CONVERGED, estimate(1, 450.0))
    builder.announce(announcement(10, 0, Phase.LIFTED))
    revision = builder.revision
    builder.fall_silent(SECOND)
    assert builder.revision == revision
    assert builder.map().stiffness[0, 0] == 450.0


@pytest.mark.parametrize("one_by_one", [True, False])
def test_an_estimate_of_a_sample_that_is_not_known_says_nothing_of_the_site(one_by_one):
    """A filter that forgets nothing between sites still claims the tissue before."""
    builder = dwelling()
    if one_by_one:
        builder.add_one("ekf", Status.CONVERGED, estimate(5, innovation=math.nan))
    else:
        unknown = np.array([math.nan])
        builder.add(replace(rows("ekf", [5], [450.0]), innovation=unknown))
    builder.announce(announcement(10, 0, Phase.LIFTED))
    found = builder.map()
    assert not found.measured.any()
    assert found.verdict[0, 0] == CellVerdict.NO_ESTIMATE
