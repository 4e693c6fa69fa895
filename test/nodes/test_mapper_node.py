"""The mapper node: the map grows site by site, for late joiners too."""

from __future__ import annotations

import numpy as np
import pytest
from sensor_msgs.msg import PointCloud2

from conftest import collect, fails_with, site_publisher
from tissue_probe.nodes.conversions import site_to_message, to_time
from tissue_probe.nodes.qos import BLOCKS, LATCHED
from tissue_probe.nodes.session import NodeProcess
from tissue_probe.signals import PalpationSite, Phase
from tissue_probe_msgs.msg import StiffnessMap, TissueEstimate

GRID = {"grid.rows": 2, "grid.columns": 3, "grid.spacing": 0.01}


def estimate(name: str, stamp: int, stiffness: float, status: int) -> TissueEstimate:
    message = TissueEstimate(
        estimator=name,
        stiffness=stiffness,
        damping=5.0,
        covariance_trace=1.0,
        stiffness_variance=4.0,
        damping_variance=0.01,
        status=status,
    )
    message.header.stamp = to_time(stamp)
    return message


@pytest.fixture
def mapped(session):
    """A mapper that has heard of one palpated site, and the test's subscriptions."""
    running = session(
        NodeProcess("mapper", "mapper", parameters={**GRID, "estimators": ["ekf", "ukf"]})
    )
    maps = collect(running.node, StiffnessMap, "/probe/stiffness_map", LATCHED)
    sites = site_publisher(running.node)
    publishers = {
        name: running.node.create_publisher(TissueEstimate, f"/probe/{name}/estimate", BLOCKS)
        for name in ("ekf", "ukf")
    }
    running.wait_until(lambda: bool(maps), "the empty map")
    running.wait_until(
        lambda: all(p.get_subscription_count() for p in (sites, *publishers.values())), "the mapper"
    )
    place = (0.01, 0.01, 0.0)
    sites.publish(site_to_message(PalpationSite(1000, 4, place, Phase.DWELL), "stage"))
    running.wait_until(lambda: sites.wait_for_all_acked(), "the announcement to arrive")
    return running, maps, sites, publishers


def test_unvisited_cells_are_not_a_number(mapped):
    _, maps, _, _ = mapped
    assert len(maps[0].stiffness) == 6
    for layer in ("stiffness", "damping", "covariance_trace", "stiffness_stddev"):
        assert np.isnan(getattr(maps[0], layer)).all()


def test_converged_estimates_are_fused_into_the_cell_of_the_site(mapped):
    running, maps, _, publishers = mapped
    converging, converged = TissueEstimate.CONVERGING, TissueEstimate.CONVERGED

    def value() -> float:
        # Sent again until the announcement, which comes on another topic, was heard.
        publishers["ekf"].publish(estimate("ekf", 2000, 500.0, converged))
        publishers["ukf"].publish(estimate("ukf", 2000, 600.0, converged))
        publishers["ukf"].publish(estimate("ukf", 3000, 9999.0, converging))
        return maps[-1].stiffness[4]

    running.wait_until(lambda: value() == 550.0, "the cell")
    # Two estimators on the same samples are no more certain than one.
    assert maps[-1].stiffness_stddev[4] == 2.0
    assert np.isnan(np.delete(maps[-1].stiffness, 4)).all()
    assert (maps[-1].rows, maps[-1].columns, maps[-1].spacing) == (2, 3, 0.01)


def test_the_cloud_carries_the_map_at_its_places_for_late_joiners(mapped):
    running, maps, _, publishers = mapped

    def measured() -> bool:
        publishers["ekf"].publish(estimate("ekf", 2000, 500.0, TissueEstimate.CONVERGED))
        return maps[-1].stiffness[4] == 500.0

    running.wait_until(measured, "the cell")
    clouds = collect(running.node, PointCloud2, "/probe/stiffness_cloud", LATCHED)
    running.wait_until(lambda: bool(clouds), "the cloud, after it was published")
    names = [field.name for field in clouds[0].fields]
    points = np.frombuffer(clouds[0].data, np.float32).reshape(6, len(names))
    point = dict(zip(names, points[4], strict=True))
    assert (point["x"], point["y"], point["z"]) == pytest.approx((0.01, 0.01, 0.0))
    assert point["stiffness"] == 500.0
    assert point["stiffness_stddev"] == 2.0
    assert np.isnan(points[0, names.index("stiffness")])


def test_a_site_off_the_grid_is_told_and_harms_nothing(mapped):
    running, maps, sites, publishers = mapped
    off = PalpationSite(5000, 5, (1.0, 1.0, 0.0), Phase.DWELL)
    sites.publish(site_to_message(off, "stage"))
    running.wait_until(lambda: "site 5 is not on the map" in running.log("mapper"), "the log")

    def measured() -> bool:
        publishers["ekf"].publish(estimate("ekf", 2000, 500.0, TissueEstimate.CONVERGED))
        return maps[-1].stiffness[4] == 500.0

    running.wait_until(measured, "the cell")


def test_a_grid_that_is_too_large_is_refused():
    said = fails_with(NodeProcess("mapper", "mapper", parameters={"grid.rows": 1000}))
    assert "grid.rows" in said
    assert "from 1 to 100" in said
