"""Functions that several tests use."""

from collections.abc import Sequence
from typing import Any, Union

import numpy as np
from numpy.typing import NDArray


def f32(values: Union[Sequence[Any], float]) -> NDArray[np.float32]:
    """An array in float32."""
    return np.array(values, np.float32)


Mesh = tuple[NDArray[np.float32], NDArray[np.uint32]]


def nearest(
    mesh: Mesh, origins: NDArray[np.float32], directions: NDArray[np.float32]
) -> tuple[NDArray[np.float64], ...]:
    """For each ray the nearest front face or -1, its distance, and the least distance from an edge or another hit."""
    a, b, c = mesh[0].astype(np.float64)[mesh[1]].swapaxes(0, 1)
    offset, direction = origins[:, None].astype(np.float64) - a, directions[:, None].astype(np.float64)
    normal, across = np.cross(b - a, c - a), np.cross(offset, direction)
    determinant = -(direction * normal).sum(-1)
    u, v = ((c - a) * across).sum(-1) / determinant, -((b - a) * across).sum(-1) / determinant
    t = (offset * normal).sum(-1) / determinant
    inside = np.minimum.reduce([u, v, 1 - u - v])
    distances = np.where((inside > 0) & (determinant > 0) & (t > 0), t, np.inf)
    triangle = np.where(np.isfinite(distances.min(1)), distances.argmin(1), -1)
    ordered = np.sort(distances, axis=1)
    with np.errstate(invalid="ignore"):
        gap = np.nan_to_num(ordered[:, 1] - ordered[:, 0], nan=np.inf)
    doubt = np.minimum(np.where(determinant > 0, np.abs(inside), np.inf).min(1), gap)
    return triangle, ordered[:, 0], np.minimum(doubt, np.abs(determinant).min(1) * 1e3)
