"""Functions that several tests use."""

from collections.abc import Sequence
from typing import Any, Union

import numpy as np
from numpy.typing import NDArray


def f32(values: Union[Sequence[Any], float]) -> NDArray[np.float32]:
    """An array in float32."""
    return np.array(values, np.float32)
