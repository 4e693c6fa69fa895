"""The parameters of a grid, which the scan and the mapper share."""

from __future__ import annotations

from pydantic import BaseModel, Field, model_validator

from tissue_probe.mapping.grid import Grid


class GridSettings(BaseModel):
    """The grid of sites, by default the paper's 5 x 5 over the stock phantom."""

    x: float = Field(
        0.0, ge=-1.0, le=1.0, description="x of the first site", json_schema_extra={"unit": "m"}
    )
    y: float = Field(
        0.0, ge=-1.0, le=1.0, description="y of the first site", json_schema_extra={"unit": "m"}
    )
    z: float = Field(
        0.0, ge=-1.0, le=1.0, description="height of the surface", json_schema_extra={"unit": "m"}
    )
    spacing: float = Field(
        0.01,
        gt=0.0,
        le=1.0,
        description="between neighbouring sites",
        json_schema_extra={"unit": "m"},
    )
    rows: int = Field(5, ge=1, le=100, description="sites along y")
    columns: int = Field(5, ge=1, le=100, description="sites along x")

    @model_validator(mode="after")
    def _makes_a_grid(self) -> GridSettings:
        self.make()
        return self

    def make(self) -> Grid:
        """Return the grid; ValueError if it has too many sites."""
        return Grid((self.x, self.y, self.z), self.spacing, self.rows, self.columns)
