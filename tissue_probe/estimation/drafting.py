"""The question to a process that compiles a filter, of plain values.

Contents: that question.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tissue_probe.estimation.kernel import Plan
from tissue_probe.estimation.settings import EstimatorSettings
from tissue_probe.estimation.table import ESTIMATORS


@dataclass(frozen=True)
class FilterToCompile:
    """A filter whose machine code is to be on disk.

    Attributes
    ----------
    estimator : str
        A key of ``ESTIMATORS``.
    settings : EstimatorSettings
        They name the model.
    """

    estimator: str
    settings: EstimatorSettings

    def read(self) -> Callable[[], Plan]:
        """Compose the model; return a function that compiles the filter and returns its plan.

        Raises
        ------
        SettingsError
            If the model cannot be used, or cannot run live.
        """
        draft = ESTIMATORS[self.estimator].draft(self.settings)

        def compile_filter() -> Plan:
            draft.compile()
            return draft.plan

        return compile_filter
