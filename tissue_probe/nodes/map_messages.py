"""The map and its sites as messages: results, inclusions, cloud, markers.

Contents: turning data into messages.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from geometry_msgs.msg import Point, Vector3
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from tissue_probe.mapping.lift import Lift, covariance_in_space
from tissue_probe.mapping.site_result import SiteResult
from tissue_probe.nodes.conversions import cloud_message, to_time
from tissue_probe.signals import FloatArray
from tissue_probe_msgs.msg import Inclusion as InclusionMessage
from tissue_probe_msgs.msg import Inclusions, SiteResults
from tissue_probe_msgs.msg import SiteResult as SiteResultMessage

if TYPE_CHECKING:
    from tissue_probe.mapping.posterior.results import Inclusion, PosteriorMap

#: Inclusions that are marked: more likely there than not.
MARKED = 0.5
_LINE = 0.0006  # m
#: Name and colour of the lines: white the likely boundary, red that which holds all of it.
_LINES = {"boundary_50": (1.0, 1.0, 1.0), "boundary_95": (1.0, 0.2, 0.2)}


def results_message(header: Header, results: Sequence[SiteResult]) -> SiteResults:
    """Turn results of sites into a message."""
    return SiteResults(header=header, results=[_result(header.frame_id, one) for one in results])


def _result(frame_id: str, result: SiteResult) -> SiteResultMessage:
    return SiteResultMessage(
        header=Header(stamp=to_time(result.stamp), frame_id=frame_id),
        site=result.site,
        repeat=result.repeat,
        position=Point(**dict(zip("xyz", result.position, strict=True))),
        normal=Vector3(**dict(zip("xyz", result.normal, strict=True))),
        stiffness=result.stiffness,
        stiffness_stddev=result.stiffness_stddev,
        damping=result.damping,
        damping_stddev=result.damping_stddev,
        verdict=int(result.verdict),
        leaving=int(result.leaving),
    )


def inclusions_message(header: Header, found: PosteriorMap, lift: Lift) -> Inclusions:
    """Turn the inclusions of a map into a message."""
    return Inclusions(
        header=header,
        inclusions=[_inclusion(one, lift) for one in found.inclusions],
        background=found.background.stiffness,
        notes=list(found.check.notes),
    )


def _inclusion(one: Inclusion, lift: Lift) -> InclusionMessage:
    lines = {
        name: _points(getattr(one, name), lift)
        for name in ("boundary_50", "boundary_90", "boundary_95")
    }
    (middle,) = _points(np.array([[one.x, one.y]]), lift)
    return InclusionMessage(
        position=middle,
        covariance=covariance_in_space(lift, one.x, one.y, one.covariance)[:2, :2].ravel().tolist(),
        probability=one.probability,
        stiffness=one.stiffness,
        stiffness_stddev=one.stiffness_sd,
        contrast=one.contrast,
        **lines,
    )


def _points(ring: FloatArray, lift: Lift) -> list[Point]:
    return [Point(**dict(zip("xyz", map(float, place), strict=True))) for place in lift(*ring.T)]


def surface_cloud(header: Header, found: PosteriorMap, lift: Lift) -> PointCloud2:
    """Turn the surface, where it is known, into a cloud with its error and P(inclusion)."""
    surface = found.surface
    known = np.isfinite(surface.mean)
    x, y = (layer[known] for layer in np.meshgrid(surface.x, surface.y))
    layers = {
        "stiffness": surface.mean[known],
        "stiffness_stddev": surface.sd[known],
        "probability": surface.probability[known],
    }
    points = np.column_stack([lift(x, y), *layers.values()])
    return cloud_message(header, points, ["x", "y", "z", *layers])


def markers_message(header: Header, found: PosteriorMap, lift: Lift) -> MarkerArray:
    """Return lines of boundaries and a text for each inclusion that is likely there."""
    markers = [Marker(header=header, action=Marker.DELETEALL)]
    for number, one in enumerate(each for each in found.inclusions if each.probability >= MARKED):
        for name, (red, green, blue) in _LINES.items():
            line = Marker(header=header, ns=name, id=number, type=Marker.LINE_STRIP)
            line.pose.orientation.w = 1.0
            line.scale.x = _LINE
            line.color = ColorRGBA(r=red, g=green, b=blue, a=1.0)
            line.points = _points(getattr(one, name), lift)
            markers.append(line)
        text = Marker(header=header, ns="contrast", id=number, type=Marker.TEXT_VIEW_FACING)
        (text.pose.position,) = _points(np.array([[one.x, one.y]]), lift)
        text.pose.orientation.w = 1.0
        text.scale.z = 5.0 * _LINE
        text.color = ColorRGBA(r=1.0, g=1.0, b=1.0, a=1.0)
        text.text = f"{one.contrast:.1f}x, P {one.probability:.2f}"
        markers.append(text)
    return MarkerArray(markers=markers)
