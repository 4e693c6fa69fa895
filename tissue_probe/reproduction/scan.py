"""Figure 12: a grid of sites over a phantom with three nodules."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Circle
from scipy.interpolate import RBFInterpolator

from tissue_probe.configuration import stock_configuration
from tissue_probe.mapping.grid import Grid
from tissue_probe.mapping.matching import match
from tissue_probe.mapping.posterior.posterior_map import map_of
from tissue_probe.mapping.sites import Sites
from tissue_probe.mapping.stiffness_map import StiffnessMapData
from tissue_probe.mapping.verdict import CellVerdict
from tissue_probe.physics.phantom import Phantom
from tissue_probe.reproduction.drawing import LABELS
from tissue_probe.reproduction.experiment import SimulatedTissue, SineExperiment
from tissue_probe.reproduction.filters import AFEKF, EKF, ROBUST, UKF, ShownFilter
from tissue_probe.reproduction.finding import ReproducedQuantity, Reproduction
from tissue_probe.signals import FloatArray, TissueEstimates

GRID = Grid((0.0, 0.0, 0.0), 0.01, 5, 5)
#: An inclusion that is declared has this probability.
DECLARED_PROBABILITY = 0.9
#: Places of the picture between two sites.
FINE = 10
#: The filters drawn in each row: the paper averages its own.
FILTERS_COMPARED = {"paper's three, averaged": (UKF, EKF, AFEKF), "robust_ekf": (ROBUST,)}


def palpate(phantom: Phantom) -> dict[ShownFilter, list[TissueEstimates]]:
    """Run every filter for one second at each cell, by rising index, knowing nothing before."""
    x, y = (place.ravel() for place in np.meshgrid(GRID.x, GRID.y))
    cells = zip(phantom.stiffness(x, y), phantom.damping(x, y), strict=True)
    experiments = [
        SineExperiment(((0.0, SimulatedTissue(k, b)),), seed=i) for i, (k, b) in enumerate(cells)
    ]
    filters = [each for row in FILTERS_COMPARED.values() for each in row]
    return {each: [each.run(experiment) for experiment in experiments] for each in filters}


def fig12() -> Reproduction:
    """Draw stiffness, damping and covariance trace over the grid."""
    phantom = Phantom.load(stock_configuration("phantom.yaml"))
    runs = palpate(phantom)
    maps = {
        title: _map([runs[each] for each in filters]) for title, filters in FILTERS_COMPARED.items()
    }
    theirs, ours = maps.values()
    nodules, errors = [_nodules(m, phantom) for m in maps.values()], _errors(maps, phantom)
    return Reproduction(
        _draw(maps, phantom),
        (
            ReproducedQuantity("nodules found", "each of 3", *nodules),
            ReproducedQuantity("rms error of k over the sites", "not known", *errors),
            ReproducedQuantity(
                "covariance trace, stiffest site over softest",
                "higher over the nodules",
                _contrast(theirs),
                _contrast(ours),
            ),
        ),
    )


def _map(runs: Sequence[Sequence[TissueEstimates]]) -> StiffnessMapData:
    """Average the filters' estimates at the end of each site's second."""

    def cells(name: str) -> FloatArray:
        values = [[getattr(estimates, name)[-1] for estimates in sites] for sites in runs]
        found: FloatArray = np.mean(values, axis=0).reshape(GRID.shape)
        return found

    deviations = [np.sqrt(cells(f"{name}_variance")) for name in ("stiffness", "damping")]
    verdicts = np.full(GRID.shape, CellVerdict.MEASURED, dtype=np.uint8)
    k, beta, trace = (cells(name) for name in LABELS)
    k_stddev, beta_stddev = deviations
    never = np.zeros(GRID.shape, dtype=np.int64)
    return StiffnessMapData(GRID, 0, k, beta, trace, k_stddev, beta_stddev, verdicts, never)


def _nodules(found: StiffnessMapData, phantom: Phantom) -> str:
    x, y = (place.ravel() for place in np.meshgrid(GRID.x, GRID.y))
    k, k_sd = found.stiffness.ravel(), found.stiffness_stddev.ravel()
    inclusions = map_of(Sites(x, y, np.zeros_like(x), None, k, k_sd)).inclusions
    sure = [(one.x, one.y) for one in inclusions if one.probability >= DECLARED_PROBABILITY]
    pairs = match(sure, [(n.x, n.y) for n in phantom.nodules]).pairs
    return f"{len(pairs)} of {len(phantom.nodules)}, {len(sure) - len(pairs)} false"


def _errors(maps: dict[str, StiffnessMapData], phantom: Phantom) -> list[str]:
    true = phantom.stiffness(*np.meshgrid(GRID.x, GRID.y))
    errors = [np.sqrt(np.mean((each.stiffness / true - 1.0) ** 2)) for each in maps.values()]
    return [f"{100.0 * error:.2f} %" for error in errors]


def _contrast(found: StiffnessMapData) -> str:
    order = np.argsort(found.stiffness, axis=None)
    trace = found.covariance_trace.ravel()[order]
    return f"{trace[-1] / trace[0]:.2f}"


def _draw(maps: dict[str, StiffnessMapData], phantom: Phantom) -> Figure:
    figure = Figure(figsize=(12.0, 7.4), layout="constrained")
    rows = figure.subplots(len(maps), len(LABELS), sharex=True, sharey=True)
    for row, (title, found) in zip(rows, maps.items(), strict=True):
        for axes, (name, label) in zip(row, LABELS.items(), strict=True):
            image = _surface(axes, getattr(found, name), phantom)
            figure.colorbar(image, ax=axes, label=label, shrink=0.82)
        row[0].set_ylabel(f"{title}\ny [mm]")
    for axes in rows[-1]:
        axes.set_xlabel("x [mm]")
    figure.suptitle("Circles: true nodules, radius = depth; dots: sites", fontsize=10)
    return figure


def _between(values: FloatArray) -> FloatArray:
    """Return values of the sites over the picture, by thin plates through them."""
    sites = np.column_stack([each.ravel() for each in np.meshgrid(GRID.x, GRID.y)])
    fine = [np.linspace(a[0], a[-1], FINE * (a.size - 1) + 1) for a in (GRID.x, GRID.y)]
    places = np.column_stack([each.ravel() for each in np.meshgrid(*fine)])
    scale = np.abs(values).max()
    between = RBFInterpolator(sites / GRID.spacing, values.ravel() / scale)(places / GRID.spacing)
    return np.asarray(scale * between.reshape(fine[1].size, fine[0].size))


def _surface(axes: Axes, values: FloatArray, phantom: Phantom) -> AxesImage:
    millimetres = 1e3
    left, right, bottom, top = (
        millimetres * float(edge) for edge in (GRID.x[0], GRID.x[-1], GRID.y[0], GRID.y[-1])
    )
    image = axes.imshow(
        _between(values),
        origin="lower",
        extent=(left, right, bottom, top),
        interpolation="bilinear",
    )
    x, y = np.meshgrid(millimetres * GRID.x, millimetres * GRID.y)
    axes.plot(x.ravel(), y.ravel(), ".", color="white", markeredgecolor="black", markersize=5)
    for nodule in phantom.nodules:
        place, radius = (millimetres * nodule.x, millimetres * nodule.y), millimetres * nodule.depth
        axes.add_patch(Circle(place, radius, fill=False, color="black", linewidth=3.0))
        axes.add_patch(Circle(place, radius, fill=False, color="white", linewidth=1.5))
    return image
