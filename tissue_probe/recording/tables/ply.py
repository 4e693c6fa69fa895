"""A point cloud as a PLY file, which CloudCompare, MeshLab and Open3D read.

Contents: the file.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from tissue_probe.signals import FloatArray


def write_ply(path: str | Path, columns: Mapping[str, FloatArray]) -> None:
    """Write points, a property a column, every digit kept.

    Parameters
    ----------
    path : path
        A file of that name is overwritten.
    columns : mapping of str to array
        x, y, z [m] first, then further values of each point; all of one length.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    dtype = np.dtype([(name, "<f8") for name in columns])
    points = np.empty(len(next(iter(columns.values()))), dtype)
    for name, values in columns.items():
        points[name] = values
    properties = "".join(f"property double {name}\n" for name in columns)
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {points.size}\n"
        f"{properties}end_header\n"
    )
    Path(path).write_bytes(head.encode() + points.tobytes())
