"""The loop of revisions: a model asks for one, is fitted to the revised samples, and asks again.

Contents: the number of revisions, and the names of those made.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from tissue_probe.diagnosis.fitting.fit import Fit
from tissue_probe.diagnosis.fitting.refit_samples import refit_measurements
from tissue_probe.diagnosis.observation.instrument import Instrument
from tissue_probe.diagnosis.ranking.candidates import fit_base
from tissue_probe.diagnosis.revisions.table import Revision, apply_to_instrument

#: How often samples are weighed anew: without corners, without those that hang on the position's
#: noise, without outliers, with less noise or more, and with another motion in a noisy position:
#: each once, and the noise again after them.
REVISION_ROUNDS = 6


class Revisions:
    """The revisions of one question.

    Parameters
    ----------
    instrument : Instrument
        The rig and its constants, before any revision.
    given : collection of str
        Names of revisions that are not made: the user has given their result.
    """

    def __init__(self, instrument: Instrument, given: Collection[str] = ()) -> None:
        self.names: list[str] = []
        self._given, self._left, self._instrument = given, REVISION_ROUNDS, instrument

    @property
    def instrument(self) -> Instrument:
        """The rig and its constants, after the revisions made so far."""
        return apply_to_instrument(self._instrument, self.names)

    def revise_until_settled(self, fit: Fit, table: Sequence[Revision]) -> Fit | None:
        """Return a model after all revisions that it asks for; None where it asks for none."""
        settled, revised = None, self._revise_once(fit, table)
        while revised is not None:
            settled, revised = revised, self._revise_once(revised, table)
        return settled

    def _revise_once(self, fit: Fit, table: Sequence[Revision]) -> Fit | None:
        """Return a model after the first revision of a table for which it gives a reason."""
        for each in filter(self._may, table):
            told = each.revise(fit, self.instrument) if each.when(fit) else None
            if not told:
                continue
            revised = refit_measurements(
                fit, told, apply_to_instrument(self.instrument, [each.name])
            )
            if revised is not None:
                self.names.append(each.name)
                self._left -= not (each.once or each.ends)
                return revised
        return None

    def _may(self, revision: Revision) -> bool:
        if revision.name in self._given or (revision.once and revision.name in self.names):
            return False
        return revision.once or revision.ends or self._left > 0

    def of_base(self, base: Fit, revised: Fit) -> Fit:
        """Return the model that was asked about, fitted to the samples as revised by another."""
        if revised.composition is base.composition:
            return revised
        samples = revised.measurements
        again = refit_measurements(base, samples, self.instrument)
        return again or fit_base(base.composition, samples, self.instrument)
