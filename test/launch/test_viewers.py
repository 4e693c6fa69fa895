"""The viewers' files name only topics that the nodes publish, of a type that has what is shown."""

from __future__ import annotations

import importlib
import json
import re
import runpy
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count

import domain_coordinator
import pytest
import rclpy
import yaml
from declared import ROOT
from sensor_msgs.msg import PointCloud2

from tissue_probe.estimation import ESTIMATORS
from tissue_probe.nodes.driver import Driver
from tissue_probe.nodes.estimator import EstimatorNode
from tissue_probe.nodes.mapper import Mapper
from tissue_probe.nodes.qos import ANNOUNCEMENTS, LATCHED, SAMPLE_BLOCKS
from tissue_probe.nodes.scan import Scan
from tissue_probe.nodes.stage import Stage
from tissue_probe_msgs.msg import PalpationSite, TissueEstimate

SUITE = {"/probe": [Driver, lambda: EstimatorNode("ekf"), Mapper, Scan], "/stage": [Stage]}
LAYOUT = json.loads((ROOT / "config" / "foxglove_layout.json").read_text())
RVIZ = yaml.safe_load((ROOT / "config" / "rviz.rviz").read_text())["Visualization Manager"]
PLOTJUGGLER = ElementTree.parse(ROOT / "config" / "plotjuggler.xml")
RERUN = runpy.run_path(str(ROOT / "examples" / "rerun_blueprint.py"))
RVIZ_TYPES = {
    "rviz_default_plugins/MarkerArray": "visualization_msgs/msg/MarkerArray",
    "rviz_default_plugins/PointCloud2": "sensor_msgs/msg/PointCloud2",
    "rviz_default_plugins/Pose": "geometry_msgs/msg/PoseStamped",
}


@contextmanager
def ros(namespace: str) -> Iterator[None]:
    """Let nodes of this process live in a namespace, in a domain of their own."""
    with (
        domain_coordinator.domain_id(count(93).__next__) as domain,
        pytest.MonkeyPatch.context() as patch,
    ):
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        rclpy.init(args=["--ros-args", "-r", f"__ns:={namespace}"], domain_id=domain)
        yield
        rclpy.shutdown()


@pytest.fixture(scope="module")
def published() -> dict[str, str]:
    """The type of every topic that the real nodes publish, with one estimator."""
    found: dict[str, str] = {}
    for namespace, makers in SUITE.items():
        with ros(namespace):
            nodes = [make() for make in makers]
            for node in nodes:
                if isinstance(node, Driver):
                    node.trigger_configure()
                for publisher in node.publishers:
                    kind = publisher.msg_type
                    package = kind.__module__.partition(".")[0]
                    found[publisher.topic_name] = f"{package}/msg/{kind.__name__}"
            for node in nodes:
                node.destroy_node()
    return found


def field_type(typename: str, path: list[str]) -> str:
    """Follow a path of fields through a message; return the type at its end."""
    for name in path:
        package, _, message = typename.removesuffix("]").rpartition("/")
        module = importlib.import_module(f"{package.partition('/')[0]}.msg")
        fields = getattr(module, message).get_fields_and_field_types()
        field, index = re.fullmatch(r"(\w+)(\[\d+\])?", name).groups()
        typename = fields[field]
        if index:
            typename = typename.removeprefix("sequence<").removesuffix(">")
    return typename


def shown_numbers() -> Iterator[pytest.param]:
    """Return (topic, path of fields) of every curve in the viewers."""
    for panel, config in LAYOUT["configById"].items():
        for path in config.get("paths", []):
            topic, _, fields = path["value"].partition(".")
            yield pytest.param(topic, fields.split("."), id=f"foxglove:{panel}:{path['value']}")
    for curve in PLOTJUGGLER.iter("curve"):
        topic, _, field = curve.get("name").rpartition("/")
        yield pytest.param(topic, [field], id=f"plotjuggler:{curve.get('name')}")
    for plot, curves in RERUN["PLOTS"].items():
        for topic, _, field in curves:
            yield pytest.param(topic, [field], id=f"rerun:{plot}:{topic}")


def as_ekf(topic: str) -> str:
    """Return a topic of any estimator as that of the one that runs here."""
    return re.sub(rf"/({'|'.join(ESTIMATORS)})/", "/ekf/", topic)


@pytest.mark.parametrize(("topic", "fields"), list(shown_numbers()))
def test_every_curve_is_a_number_in_a_published_message(topic, fields, published):
    assert as_ekf(topic) in published
    assert field_type(published[as_ekf(topic)], fields) == "double"


def test_rerun_reads_each_curve_from_a_message_of_the_topics_type(published):
    for curves in RERUN["PLOTS"].values():
        for topic, component, _ in curves:
            package, _, name = published[as_ekf(topic)].partition("/msg/")
            assert component == f"{package}.msg.{name}:message"


def test_foxglove_places_every_panel_that_it_configures():
    def leaves(place) -> list[str]:
        if isinstance(place, str):
            return [place]
        assert place["direction"] in ("row", "column")
        return [*leaves(place["first"]), *leaves(place["second"])]

    assert sorted(leaves(LAYOUT["layout"])) == sorted(LAYOUT["configById"])


def test_foxglove_shows_the_map_the_probe_and_the_health(published):
    panels = LAYOUT["configById"]
    scene = panels["3D!map"]["topics"]
    assert {topic: published[topic] for topic in scene} == {
        "/probe/stiffness_cloud": "sensor_msgs/msg/PointCloud2",
        "/stage/measured_cp": "geometry_msgs/msg/PoseStamped",
    }
    raw = panels["RawMessages!map"]["topicPath"]
    assert published[raw] == "tissue_probe_msgs/msg/StiffnessMap"
    health = panels["DiagnosticSummary!health"]["topicToRender"]
    assert published[health] == "diagnostic_msgs/msg/DiagnosticArray"


def test_rviz_shows_published_topics_of_the_types_of_its_displays(published):
    shown = {
        display["Topic"]["Value"]: RVIZ_TYPES[display["Class"]]
        for display in RVIZ["Displays"]
        if "Topic" in display
    }
    assert shown == {topic: published[topic] for topic in shown}
    assert set(shown) == {
        "/probe/inclusion_markers",
        "/probe/stiffness_cloud",
        "/stage/measured_cp",
    }


def test_the_map_is_coloured_by_a_channel_of_the_cloud_in_the_frame_that_is_shown():
    clouds: list[PointCloud2] = []
    with ros("/probe"):
        mapper = Mapper()
        mapper.create_subscription(PointCloud2, "stiffness_cloud", clouds.append, LATCHED)
        sites = mapper.create_publisher(PalpationSite, "palpation_site", ANNOUNCEMENTS)
        for stamp, phase in ((1, PalpationSite.DWELL), (2, PalpationSite.LIFTED)):
            site = PalpationSite(phase=phase)
            site.header.stamp.sec = stamp
            sites.publish(site)
        estimates = mapper.create_publisher(TissueEstimate, "ekf/estimate", SAMPLE_BLOCKS)
        estimate = TissueEstimate(estimator="ekf", status=TissueEstimate.CONVERGED)
        estimate.stiffness, estimate.stiffness_variance, estimate.damping_variance = 450.0, 1.0, 1.0
        estimate.header.stamp.sec, estimate.header.stamp.nanosec = 1, 500_000_000
        for _ in range(600):  # where nothing is kept compiled, the first map takes half a minute
            if not clouds:
                estimates.publish(estimate)
                rclpy.spin_once(mapper, timeout_sec=0.1)
        mapper.destroy_node()
    channels = {field.name for field in clouds[0].fields}
    scene = LAYOUT["configById"]["3D!map"]
    assert scene["topics"]["/probe/stiffness_cloud"]["colorField"] in channels
    display = next(each for each in RVIZ["Displays"] if each["Name"] == "Stiffness")
    assert display["Channel Name"] in channels
    frames = {scene["followTf"], RVIZ["Global Options"]["Fixed Frame"]}
    assert frames == {clouds[0].header.frame_id}
