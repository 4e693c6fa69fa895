"""How often a site errs far more than it states: for the map, and for the choice of sites."""

from __future__ import annotations

from pydantic import BaseModel

from tissue_probe.settings import setting


class ErringSites(BaseModel):
    """The statement on sites that mapper and scan share."""

    outliers: float = setting(
        0.0,
        "",
        "share of sites that err far more than they state, by a slip for one; 0 where contact is "
        "verified",
        ge=0.0,
        lt=1.0,
    )
