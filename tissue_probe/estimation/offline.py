"""A whole recording through one estimator, as the live node would have done it."""

from __future__ import annotations

from collections.abc import Sequence

from tissue_probe.estimation.estimator import Estimator
from tissue_probe.estimation.settings import EstimatorSettings
from tissue_probe.signals import Phase, Recording, TissueEstimates


def estimate(
    recording: Recording,
    name: str,
    settings: EstimatorSettings,
    *,
    restart_at_site: bool = True,
    changes: Sequence[tuple[int, EstimatorSettings]] = (),
) -> TissueEstimates:
    """Return one estimate for each sample of a recording, in its order.

    Parameters
    ----------
    recording : Recording
        At least one block.
    name : str
        A key of ``ESTIMATORS``.
    settings : EstimatorSettings
        Instrument, noise and prior.
    restart_at_site : bool
        Whether the tissue is forgotten where a dwell at a site begins.
    changes : sequence of (int, EstimatorSettings)
        From which stamp on [ns since the epoch] other models hold (``Estimator.take_model``).

    Raises
    ------
    ValueError
        If there is no estimator of this name.
    """
    estimator = Estimator(name, settings)
    for stamp, changed in changes:
        estimator.take_model(changed, stamp)
    if restart_at_site:
        for site in recording.sites:
            if site.phase == Phase.DWELL:
                estimator.restart_at(site.stamp)
    return TissueEstimates.concatenate([estimator.process(block) for block in recording.blocks])
