"""Whose estimates count: for the map, and for a dwell that has told enough."""

from __future__ import annotations

from pydantic import BaseModel

from tissue_probe.settings import setting


class FusedEstimators(BaseModel):
    """The estimators that mapper and scan hear."""

    estimators: list[str] = setting(
        ["robust_ekf", "ekf", "ukf", "afekf"],
        "",
        "estimators to fuse, by the names of their topics",
    )
