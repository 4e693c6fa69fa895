"""Setting a report as one HTML page that needs nothing else: no network, no other file.

Contents: filling the template.
"""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from latex2mathml.converter import convert
from markupsafe import Markup

from tissue_probe.report import plots
from tissue_probe.report.contents import Report
from tissue_probe.report.numbers import interval, significant

#: uPlot, of which the package has one copy: the workbench's.
UPLOT = "workbench/page/vendor"


def templates() -> Environment:
    """Return the templates of pages: filled-in values are text, and none may be left out."""
    return Environment(
        loader=PackageLoader("tissue_probe.report", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def render(report: Report) -> str:
    """Return a report as HTML.

    Equations are MathML, plots carry their data, their scripts are within; the page forbids the
    browser to load anything (Content-Security-Policy).

    Parameters
    ----------
    report : Report
        The contents of the page.
    """
    environment = templates()
    factor, unit = plots.unit_of(report)
    environment.filters["significant"] = significant
    environment.filters["small"] = lambda error: significant(error / factor)
    environment.filters["display"] = lambda latex: Markup(convert(latex, display="block"))
    environment.filters["inline"] = lambda latex: Markup(convert(latex))
    environment.filters["data"] = _data
    environment.globals["interval"] = interval
    package = files("tissue_probe")
    script = [f"{UPLOT}/uPlot.js", "report/report.js"]
    drawn = [
        {
            "signals": [plots.signals(each, report.noise_floor, report.output)],
            "where": plots.where(each, report.noise_floor)
            if each.base_localisation or each.final_localisation
            else [],
        }
        for each in report.signals
    ]
    return environment.get_template("report.html.jinja").render(
        report=report,
        unit=unit,
        bars=plots.ladder(report),
        drawn=drawn,
        script=Markup("\n".join(package.joinpath(name).read_text("utf-8") for name in script)),
        style=Markup(package.joinpath(UPLOT, "uPlot.css").read_text("utf-8")),
    )


def _data(values: Any) -> Markup:
    """Return data as JSON that no page takes for its own marks."""
    return Markup(json.dumps(values, separators=(",", ":")).replace("<", "\\u003c"))
