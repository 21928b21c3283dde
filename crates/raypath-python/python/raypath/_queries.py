"""What rays, geometries and instances of a :class:`raypath.Unit` have beside their coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum, IntFlag
from typing import Any

from numpy.typing import ArrayLike, NDArray


class RayFlags(IntFlag):
    """Flags of a ray, with the bits of SPIR-V's ``RayFlags``.

    At most one of ``OPAQUE``, ``NO_OPAQUE``, ``CULL_OPAQUE`` and ``CULL_NO_OPAQUE``, at most one of the two of faces
    and ``SKIP_TRIANGLES``, and not both ``SKIP_…``: a ray with others is refused.
    """

    NONE = 0
    OPAQUE = 1 << 0
    NO_OPAQUE = 1 << 1
    TERMINATE_ON_FIRST_HIT = 1 << 2
    SKIP_CLOSEST_HIT_SHADER = 1 << 3
    CULL_BACK_FACING_TRIANGLES = 1 << 4
    CULL_FRONT_FACING_TRIANGLES = 1 << 5
    CULL_OPAQUE = 1 << 6
    CULL_NO_OPAQUE = 1 << 7
    SKIP_TRIANGLES = 1 << 8
    SKIP_AABBS = 1 << 9


class InstanceFlags(IntFlag):
    """Flags of an instance, with the bits of Vulkan's ``VkGeometryInstanceFlagBitsKHR``."""

    NONE = 0
    FACING_CULL_DISABLE = 1 << 0
    FLIP_FACING = 1 << 1
    FORCE_OPAQUE = 1 << 2
    FORCE_NO_OPAQUE = 1 << 3


class UnitStatus(IntEnum):
    """How a ray ends: ``status`` of :class:`raypath.UnitHits`."""

    MISS = 0
    HIT = 1
    REFUSED = 3
    MEMORY = 4
    SCENE = 5
    LIMIT = 6


@dataclass(frozen=True, eq=False)
class Geometry:
    """Triangles of a scene, for a unit with ``queries="flags"``.

    Args:
        triangles: float32 array of shape (n, 3, 3): three vertices for each triangle. One with a vertex whose x is NaN
            is inactive: it is not hit, and counts in indices.
        opaque: whether they count as opaque for rays and instances whose flags do not say otherwise.
    """

    triangles: ArrayLike
    opaque: bool = True


@dataclass(frozen=True, eq=False)
class Instance:
    """A place of the triangles of a scene, for a unit with ``instances=True``.

    Args:
        matrix: float64 array of shape (3, 4): the affine matrix from the triangles to the scene. The last number of
            each row is the translation.
        custom_index: a number below 2**24 that hits report. This and what follows is for ``queries="flags"``.
        mask: 8 bits; rays count the instance whose ``cull_mask`` has one of them.
        shader_offset: a number below 2**24 that hits report.
        flags: whether faces are culled or exchanged, and geometries forced to be opaque or not.
    """

    matrix: ArrayLike | NDArray[Any]
    custom_index: int = 0
    mask: int = 0xFF
    shader_offset: int = 0
    flags: InstanceFlags = InstanceFlags.NONE
