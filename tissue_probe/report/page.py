"""Setting a report as one HTML page that needs nothing else: no network, no other file.

What belongs here: filling the template. What does not: what the page says (``contents``).
"""

from __future__ import annotations

from jinja2 import Environment, PackageLoader, StrictUndefined
from latex2mathml.converter import convert
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from tissue_probe.report.contents import Report
from tissue_probe.report.numbers import interval, significant
from tissue_probe.report.plots import draw_ladder, draw_signals, draw_where


def templates() -> Environment:
    """Return the templates of pages: what is filled in is text, and nothing may be left out."""
    return Environment(
        loader=PackageLoader("tissue_probe.report", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def render(report: Report) -> str:
    """Return a report as HTML.

    Equations are MathML, plots carry their data, Plotly's script is within; the page forbids the
    browser to load anything (Content-Security-Policy).

    Parameters
    ----------
    report : Report
        What the page says.
    """
    environment = templates()
    environment.filters["significant"] = significant
    environment.filters["small"] = lambda error: significant(report.output.per_small * error)
    environment.filters["display"] = lambda latex: Markup(convert(latex, display="block"))
    environment.filters["inline"] = lambda latex: Markup(convert(latex))
    environment.globals["interval"] = interval
    plots = {
        "ladder": Markup(draw_ladder(report)),
        "signals": [
            Markup(draw_signals(each, report.noise_floor, report.output)) for each in report.signals
        ],
        "where": [
            Markup(draw_where(each, report.noise_floor))
            if each.base_localisation or each.final_localisation
            else ""
            for each in report.signals
        ],
    }
    template = environment.get_template("report.html.jinja")
    return template.render(report=report, plots=plots, plotly=Markup(get_plotlyjs()))
