"""A blueprint for Rerun: the samples and the estimates of a recorded run as curves.

``python examples/rerun_blueprint.py config/rerun.rbl`` writes it, with ``rerun-sdk`` installed;
``rerun run.mcap config/rerun.rbl`` shows it. Rerun reads our messages by the definitions that the
recording holds. A block of samples is shown by its first one, as in the other layouts. A blueprint
is for recordings of one name: of another than run.mcap, name that as second argument.
"""

from __future__ import annotations

import sys

ESTIMATORS = ("ekf", "ukf", "robust_ekf")
ESTIMATE = "tissue_probe_msgs.msg.TissueEstimate:message"
SAMPLES = "tissue_probe_msgs.msg.ProbeSamples:message"

#: Of each plot its name, and of each of its curves the topic, the component and the field.
PLOTS = {
    "position of the coil [m]": [("/probe/samples", SAMPLES, "position[0]")],
    "force of the load cell [N]": [("/probe/samples", SAMPLES, "force[0]")],
    "stiffness [N/m]": [(f"/probe/{name}/estimate", ESTIMATE, "stiffness") for name in ESTIMATORS],
    "damping [N s/m]": [(f"/probe/{name}/estimate", ESTIMATE, "damping") for name in ESTIMATORS],
    "innovation [N]": [(f"/probe/{name}/estimate", ESTIMATE, "innovation") for name in ESTIMATORS],
}


def write_blueprint(path: str, recording: str = "run") -> None:
    """Write the blueprint for recordings of a name to a file that ends in .rbl."""
    import rerun as rr
    import rerun.blueprint as rrb
    from rerun.blueprint.encodings import ComponentSourceKind, VisualizerComponentMapping

    def draw(component: str, field: str) -> rrb.Visualizer:
        mapping = VisualizerComponentMapping(
            "Scalars:scalars",
            ComponentSourceKind.SourceComponent,
            source_component=component,
            selector=f".{field}",
        )
        return rr.SeriesLines().visualizer(mappings=[mapping])

    views = [
        rrb.TimeSeriesView(
            origin="/",
            name=name,
            contents=[topic for topic, _, _ in curves],
            overrides={topic: draw(component, field) for topic, component, field in curves},
        )
        for name, curves in PLOTS.items()
    ]
    rrb.Blueprint(rrb.Vertical(*views), collapse_panels=True).save(recording, path)


if __name__ == "__main__":
    write_blueprint(*sys.argv[1:])
