"""``tissue_probe estimators``: which filters there are, and what can be set on them."""

from __future__ import annotations


def estimators() -> None:
    """List the filters, and their settings with units, ranges and defaults."""
    from rich.console import Console
    from rich.table import Table

    from tissue_probe.estimation import ESTIMATORS, EstimatorSettings
    from tissue_probe.settings import rule

    console = Console()
    console.print("Estimators: " + ", ".join(ESTIMATORS))
    table = Table("setting", "default", "takes", "meaning")
    for name, field in EstimatorSettings.model_fields.items():
        # Text, not markup: units stand in square brackets.
        default, takes = str(field.default), rule(field).replace("[", "\\[")
        table.add_row(name, default, takes, field.description)
    console.print(table)
