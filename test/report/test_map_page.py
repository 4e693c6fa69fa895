"""The map as a page: its numbers, its plots, and nothing that has to be loaded."""

import json
import re

import numpy as np
import pytest

import tissue_probe as tp


@pytest.fixture(scope="module")
def found():
    x, y = (each.ravel() for each in np.meshgrid(np.arange(5) / 100.0, np.arange(5) / 100.0))
    k = 450.0 * (1.0 + 1.5 * 0.5 ** (((x - 0.02) ** 2 + (y - 0.01) ** 2) / 0.006**2))
    k *= 1.0 + 0.01 * np.random.default_rng(1).standard_normal(x.size)
    k[24] = np.nan
    return tp.map({"x": x, "y": y, "k": k, "k_sd": np.where(np.isnan(k), np.nan, 0.01 * 450.0)})


@pytest.fixture(scope="module")
def page(found, tmp_path_factory):
    path = tmp_path_factory.mktemp("map") / "map.html"
    found.report(path)
    return path.read_text(encoding="utf-8")


def test_it_says_all_that_the_map_says(found, page):
    for line in found.text.splitlines():
        assert line in page
    first = found.map.inclusions[0]
    assert first.probability > 0.9
    assert f"{1e3 * first.x:.1f} ± " in page
    assert f">{first.contrast:.2f}<" in page
    assert f"{found.map.background.stiffness:.1f} ± " in page


def test_the_surface_is_drawn_with_its_sites_and_boundaries(found, page):
    begin = page.index("[", page.rindex("Plotly.newPlot("))
    traces, _ = json.JSONDecoder().raw_decode(page[begin:])
    heats = [trace for trace in traces if trace["type"] == "heatmap"]
    assert len(heats) == 3
    dots = [trace for trace in traces if trace.get("mode") == "markers"]
    assert [dot["marker"]["symbol"].count("x") for dot in dots] == [1, 1, 1]
    shown = sum(one.probability >= 0.5 for one in found.map.inclusions)
    lines = [trace for trace in traces if trace.get("mode") == "lines"]
    assert len(lines) == 3 * 4 * shown


def test_it_loads_nothing(page):
    assert "default-src 'none'" in page
    assert not re.search(r"<(?:script|link|img)[^>]*(?:src|href)=", page)
