"""Which rows no statistics of a study take, and why."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

#: States of a filter (``signals.Status``) whose values are not to be used, each in a sentence.
NOT_TO_BE_USED = {
    "no_contact": "the filter felt no tissue: its k and beta are not to be used",
    "model_rejected": "the filter's model does not fit: its k and beta are not to be used",
}


def explain_exclusion(row: Mapping[str, Any]) -> str:
    """Return why a row is in no statistics, in a sentence; empty where it is in them."""
    if row["status"] != "done":
        return str(row["sentence"])
    return NOT_TO_BE_USED.get(row.get("quality", ""), "")
