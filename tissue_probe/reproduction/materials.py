"""Figure 10: four materials, from soft to stiff."""

from __future__ import annotations

from tissue_probe.reproduction.drawing import LABELS, TRUTH, legend, panels
from tissue_probe.reproduction.experiment import SimulatedTissue, SineExperiment
from tissue_probe.reproduction.filters import AFEKF, ROBUST, ShownFilter
from tissue_probe.reproduction.finding import ReproducedQuantity, Reproduction, describe_settling
from tissue_probe.signals import TissueEstimates

# The values are not stated; these fit the axes of the figure.
MATERIALS = (
    SimulatedTissue(450.0, 7.0),
    SimulatedTissue(1000.0, 20.0),
    SimulatedTissue(2000.0, 45.0),
    SimulatedTissue(3500.0, 90.0),
)
MATERIAL_EXPERIMENTS = tuple(SineExperiment(((0.0, tissue),), duration=2.0) for tissue in MATERIALS)
COLORS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7")
DASHES = {AFEKF: "--", ROBUST: "-"}


def fig10() -> Reproduction:
    """Draw stiffness, damping and covariance trace of each material."""
    runs = {each: [each.run(experiment) for experiment in MATERIAL_EXPERIMENTS] for each in DASHES}
    figure, axes = panels(list(LABELS), "time [s]")
    for each, estimates in runs.items():
        for found, tissue, color in zip(estimates, MATERIALS, COLORS, strict=True):
            label = f"{each.label}, {tissue.stiffness:.0f} N/m"
            for name, panel in axes.items():
                values = getattr(found, name)
                time, dashes = MATERIAL_EXPERIMENTS[0].time, DASHES[each]
                panel.plot(time, values, color=color, linestyle=dashes, label=label)
    for tissue in MATERIALS:
        axes["stiffness"].axhline(tissue.stiffness, **TRUTH)
        axes["damping"].axhline(tissue.damping, **TRUTH)
    axes["stiffness"].set_ylim(-500.0, 4500.0)
    axes["damping"].set_ylim(-15.0, 130.0)
    axes["covariance_trace"].set_yscale("log")
    legend(figure)
    return Reproduction(figure, (_times(runs), _traces(runs)))


def _times(runs: dict[ShownFilter, list[TissueEstimates]]) -> ReproducedQuantity:
    times = {
        each: " / ".join(
            describe_settling(found.stiffness, experiment.truth()[0])
            for found, experiment in zip(estimates, MATERIAL_EXPERIMENTS, strict=True)
        )
        for each, estimates in runs.items()
    }
    names = " / ".join(f"{tissue.stiffness:.0f}" for tissue in MATERIALS)
    stated = "the stiffer, the later"
    return ReproducedQuantity(f"k within 5 % at {names} N/m", stated, times[AFEKF], times[ROBUST])


def _traces(runs: dict[ShownFilter, list[TissueEstimates]]) -> ReproducedQuantity:
    traces = {
        each: " / ".join(f"{found.covariance_trace[-1]:.2g}" for found in estimates)
        for each, estimates in runs.items()
    }
    stated = "grows about as the stiffness"
    return ReproducedQuantity("covariance trace after 2 s", stated, traces[AFEKF], traces[ROBUST])
