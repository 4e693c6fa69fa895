"""A figure that a notebook shows by itself.

Contents: that alone. Pictures are drawn without pyplot, which would choose a window's toolkit and
keep every figure; without it a notebook would show a figure's name only.
"""

from __future__ import annotations

import io

from matplotlib.figure import Figure

#: Of a picture in a notebook [dots per inch].
NOTEBOOK_RESOLUTION = 80


class ShownFigure(Figure):
    """A figure of Matplotlib, shown as a picture where it is the value of a notebook's cell."""

    def _repr_png_(self) -> bytes:
        file = io.BytesIO()
        self.savefig(file, format="png", dpi=NOTEBOOK_RESOLUTION)
        return file.getvalue()
