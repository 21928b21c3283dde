"""Conversions of arrays that lose nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def lossless(array: NDArray[Any], dtype: np.dtype[Any]) -> NDArray[Any] | None:
    """The array in this type and in C order, or None if a value would change."""
    if array.dtype != dtype and not (array.dtype.kind in "biuf" and dtype.kind in "uf"):
        return None
    with np.errstate(all="ignore"):
        converted = np.require(array, dtype, ["C", "A"])
        if array.dtype == dtype:
            return converted
        again = converted.astype(array.dtype)
        # A NaN differs from itself; a negative integer comes back from an unsigned type.
        same = (again == array) | ((again != again) & (array != array))
        if array.dtype.kind == "i" and dtype.kind == "u":
            same &= array >= 0
    return converted if same.all() else None
