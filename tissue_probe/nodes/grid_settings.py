"""The parameters of a grid, which the scan and the mapper share."""

from __future__ import annotations

from pydantic import BaseModel, model_validator

from tissue_probe.mapping.grid import Grid
from tissue_probe.settings import setting


class GridSettings(BaseModel):
    """The grid of sites, by default the paper's 5 x 5 over the stock phantom."""

    x: float = setting(0.0, "m", "x of the first site", ge=-1.0, le=1.0)
    y: float = setting(0.0, "m", "y of the first site", ge=-1.0, le=1.0)
    z: float = setting(0.0, "m", "height of the surface", ge=-1.0, le=1.0)
    spacing: float = setting(0.01, "m", "between neighbouring sites", gt=0.0, le=1.0)
    rows: int = setting(5, "", "sites along y", ge=1, le=100)
    columns: int = setting(5, "", "sites along x", ge=1, le=100)

    @model_validator(mode="after")
    def _makes_a_grid(self) -> GridSettings:
        self.make()
        return self

    def make(self) -> Grid:
        """Return the grid; ValueError if it has too many sites."""
        return Grid((self.x, self.y, self.z), self.spacing, self.rows, self.columns)
