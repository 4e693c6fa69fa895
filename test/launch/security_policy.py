"""What the nodes open on the graph, and what config/sros2_policy.xml lets them open.

Run it to write the file anew from the live nodes: ``python test/launch/security_policy.py``.
"""

from __future__ import annotations

import os
import sys
import time
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from collections.abc import Callable
from itertools import count
from pathlib import Path

import domain_coordinator
import rclpy
from declared import ROOT
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.serialization import serialize_message

from tissue_probe.estimation import ESTIMATORS
from tissue_probe.nodes import estimator, estimators
from tissue_probe.nodes.adapter import AdapterNode
from tissue_probe.nodes.driver import Driver
from tissue_probe.nodes.identify import IdentifyNode
from tissue_probe.nodes.mapper import Mapper
from tissue_probe.nodes.monitor import MonitorNode
from tissue_probe.nodes.recorder import Recorder
from tissue_probe.nodes.replay import Replay
from tissue_probe.nodes.scan import Scan
from tissue_probe.nodes.sensor import Sensor
from tissue_probe.nodes.stage import Stage
from tissue_probe.recording.bags.definitions import message_definition
from tissue_probe.recording.writing.writer import McapWriter
from tissue_probe_msgs.msg import PalpationSite, ProbeSamples

POLICY = ROOT / "config" / "sros2_policy.xml"
#: How long the nodes may take to open everything [s].
PATIENCE = 20.0

#: (kind, permission): names. Kinds and permissions are SROS 2's.
Rules = dict[tuple[str, str], set[str]]
#: Rules by (enclave, namespace, node).
Policy = dict[tuple[str, str, str], Rules]

#: Who starts scans, tares, resets, and watches.
OPERATOR = ("/probe/operator", "/probe", "operator")
PARAMETER_SERVICES = {
    *("describe_parameters", "get_parameter_types", "get_parameters", "list_parameters"),
    *("set_parameters", "set_parameters_atomically", "get_type_description"),
}


def make_nodes() -> list[Node]:
    """Make every node of the suite; the driver is configured, since it opens the rest then."""
    made = [Driver()]
    made[0].trigger_configure()  # before there is a replay, beside which it would be refused
    made += [Stage(), Scan(), Mapper(), Recorder(), Replay(), AdapterNode(), Sensor()]
    made += [MonitorNode(), IdentifyNode()]
    made += [node for name in ESTIMATORS for node in estimator.make(name)]
    made += estimators.make()
    return made


def live_policy(folder: Path, enough: Callable[[Policy], bool] = lambda found: False) -> Policy:
    """Run every node and return what they open, when it is ``enough`` or after ``PATIENCE``."""
    bag = folder / "run.mcap"
    write_bag(bag)
    arguments = ["--ros-args", "-r", "stage:__ns:=/stage", "-r", "__ns:=/probe"]
    arguments += ["-p", f"bag:={bag}", "-p", "paused:=true", "-p", "per_sample:=true"]
    arguments += ["-p", "force_polarity:=compression"]
    arguments += ["-p", f"output:={folder / 'out.mcap'}"]
    # Each file begins at a domain of its own: the nodes of another may not yet have died in theirs.
    with domain_coordinator.domain_id(count(91).__next__) as domain:
        rclpy.init(args=arguments, domain_id=domain)
        nodes = make_nodes()
        executor = SingleThreadedExecutor()
        for node in nodes:
            executor.add_node(node)
        deadline = time.monotonic() + PATIENCE
        policy = read_graph(nodes[0])
        while not enough(policy) and time.monotonic() < deadline:
            executor.spin_once(timeout_sec=0.1)
            policy = read_graph(nodes[0])
        executor.shutdown()
        for node in nodes:
            node.destroy_node()
        rclpy.shutdown()
    return policy


def read_graph(watcher: Node) -> Policy:
    """Return what every node in the graph has open, and what an operator needs of it."""
    queries = {
        ("topics", "publish"): watcher.get_publisher_names_and_types_by_node,
        ("topics", "subscribe"): watcher.get_subscriber_names_and_types_by_node,
        ("services", "reply"): watcher.get_service_names_and_types_by_node,
    }
    policy: Policy = {}
    for name, namespace in watcher.get_node_names_and_namespaces():
        # An inbox is a hidden node in the process, so in the enclave, of the node that it serves.
        enclave = f"{namespace}/{name.removeprefix('_').removesuffix('_inbox')}"
        rules = policy[enclave, namespace, name] = defaultdict(set)
        for rule, query in queries.items():
            for topic, _ in query(name, namespace):
                action, is_action, _ = topic.partition("/_action/")
                rules["actions", "execute"].add(action) if is_action else rules[rule].add(topic)
    # The recorder asks every node for its parameters, in passing.
    policy["/probe/recorder", "/probe", "recorder"]["services", "request"] = {
        f"{namespace.rstrip('/')}/{name}/{service}"
        for _, namespace, name in policy
        for service in ("get_parameters", "list_parameters")
        if not name.startswith("_")
    }
    # It commands the driver while it identifies.
    policy["/probe/identify", "/probe", "identify"]["services", "request"] = {
        f"/probe/driver/{service}"
        for service in ("change_state", "get_state", "get_parameters", "set_parameters_atomically")
    }
    # Estimators that share a process are in its enclave, what each may open as in its own.
    for name in ESTIMATORS:
        if alone := policy.get((f"/probe/{name}", "/probe", name)):
            policy["/probe/estimators", "/probe", name] = alone
    # The driver hears the samples' topic only while it finds another node there.
    policy["/probe/driver", "/probe", "driver"]["topics", "subscribe"].add("/probe/samples")
    policy[OPERATOR] = operator_rules(policy)
    return {node: {rule: names for rule, names in r.items() if names} for node, r in policy.items()}


def operator_rules(policy: Policy) -> Rules:
    """Hear everything, ask everyone, and give the states' commands."""
    opened: Rules = defaultdict(set)
    for rules in policy.values():
        for rule, names in rules.items():
            opened[rule] |= names
    return {
        ("topics", "publish"): {
            *("/rosout", "/parameter_events"),
            *(name for name in opened["topics", "subscribe"] - opened["topics", "publish"]),
        },
        ("topics", "subscribe"): opened["topics", "publish"],
        ("services", "request"): opened["services", "reply"],
        ("actions", "call"): opened["actions", "execute"],
    }


def read_policy(path: Path = POLICY) -> Policy:
    """Return what the file allows."""
    policy: Policy = {}
    for enclave in ElementTree.parse(path).getroot().iter("enclave"):
        for profile in enclave.iter("profile"):
            rules: Rules = defaultdict(set)
            for group in profile:
                for permission, effect in group.attrib.items():
                    assert effect == "ALLOW", "everything that is not allowed is denied"
                    rules[group.tag, permission] |= {each.text for each in group}
            policy[enclave.get("path"), profile.get("ns"), profile.get("node")] = dict(rules)
    return policy


def write_policy(policy: Policy, path: Path = POLICY) -> None:
    """Write the file."""
    root = ElementTree.Element("policy", version="0.2.0")
    enclaves = ElementTree.SubElement(root, "enclaves")
    profiles: dict[str, ElementTree.Element] = {}
    for (enclave, namespace, name), rules in sorted(policy.items()):
        if enclave not in profiles:
            element = ElementTree.SubElement(enclaves, "enclave", path=enclave)
            profiles[enclave] = ElementTree.SubElement(element, "profiles")
        profile = ElementTree.SubElement(profiles[enclave], "profile", ns=namespace, node=name)
        for (kind, permission), names in sorted(rules.items()):
            group = ElementTree.SubElement(profile, kind, {permission: "ALLOW"})
            for each in sorted(names):
                ElementTree.SubElement(group, kind.removesuffix("s")).text = each
    ElementTree.indent(root)
    comment = (
        "<!-- What each node may open, and an operator; all else is denied. Generated from the\n"
        "     running nodes: python test/launch/security_policy.py -->\n"
    )
    text = ElementTree.tostring(root, encoding="unicode")
    path.write_text(f'<?xml version="1.0" encoding="UTF-8"?>\n{comment}{text}\n')


def write_bag(path: Path) -> None:
    """Write the least that a replay accepts: one message on each of its topics."""
    with McapWriter(path, {}) as writer:
        samples = ProbeSamples(sample_period=1.0, position=[0.0], force=[0.0], command=[0.0])
        for topic, message in (("samples", samples), ("palpation_site", PalpationSite())):
            typename = f"tissue_probe_msgs/msg/{type(message).__name__}"
            definition = message_definition(typename, [Path(sys.prefix, "share")])
            channel = writer.add_topic(f"/probe/{topic}", typename, definition, "")
            writer.write(channel, 1, 1, serialize_message(message))


if __name__ == "__main__":
    import tempfile

    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    with tempfile.TemporaryDirectory() as folder:
        write_policy(live_policy(Path(folder)))
    sys.exit(0)
