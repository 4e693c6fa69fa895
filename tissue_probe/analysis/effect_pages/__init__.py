"""One page for each effect: its law, its values, how it shows, and which experiment tells it."""

from tissue_probe.analysis.effect_pages.page import write_pages as write_pages
