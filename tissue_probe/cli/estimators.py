"""``tissue_probe estimators``: which filters there are, and their settings."""

from __future__ import annotations


def estimators() -> None:
    """List the filters, and their settings.

    Each setting is shown with its default, its range and its unit.
    """
    from rich.console import Console
    from rich.table import Column, Table

    from tissue_probe.estimation import ESTIMATORS, EstimatorSettings
    from tissue_probe.settings import rule

    console = Console()
    console.print("Estimators: " + ", ".join(ESTIMATORS))
    # A name is to be copied: it is never cut.
    table = Table(Column("setting", no_wrap=True), "default", "takes", "meaning")
    for name, field in EstimatorSettings.model_fields.items():
        # Text, not markup: units stand in square brackets.
        default, takes = str(field.default), rule(field).replace("[", "\\[")
        table.add_row(name, default, takes, field.description)
    console.print(table)
