"""What rays, geometries and instances of a :class:`raypath.Unit` have beside their coordinates."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from raypath._raypath import UnitHits, UnitScene

# As the structure ``raypath_unit_verdict`` of C.
_VERDICT = np.dtype(
    {"names": ["accept", "end", "t"], "formats": ["?", "?", "f4"], "offsets": [0, 4, 8], "itemsize": 12}
)


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
    PROCEDURAL = 2
    REFUSED = 3
    MEMORY = 4
    SCENE = 5
    LIMIT = 6


@dataclass(frozen=True, eq=False)
class Geometry:
    """Triangles or procedural boxes of a scene, for a unit with ``queries``.

    Args:
        triangles: float32 array of shape (n, 3, 3): three vertices for each triangle. One with a vertex whose x is NaN
            is inactive: it is not hit, and counts in indices.
        opaque: whether they count as opaque for rays and instances whose flags do not say otherwise.
        boxes: in place of triangles, for ``queries="full"``: float32 array of shape (n, 2, 3), the corners with the
            least and the greatest coordinates of each box. One with a NaN for an x is inactive, and one with a minimum
            above its maximum is the point in its middle.
    """

    triangles: ArrayLike | None = None
    opaque: bool = True
    boxes: ArrayLike | None = None

    def __post_init__(self) -> None:
        if (self.triangles is None) == (self.boxes is None):
            raise ValueError("a geometry has triangles or boxes, expected one of them")
        if not isinstance(self.opaque, (bool, np.bool_)):
            raise ValueError(f"opaque is {self.opaque!r}, expected True or False")


class Candidates:
    """What n rays may hit, which wait for verdicts: triangles that are not opaque, and procedural boxes.

    What is not answered is ignored. ``array`` is a structured array with the fields ``ray`` (the index of the ray),
    ``is_box``, ``is_opaque``, ``primitive``, ``geometry``, ``instance`` (-1 in none), ``custom_index``,
    ``shader_offset``, ``t``, ``t_num``, ``t_denom``, ``u``, ``v``, ``back_face``, and ``origin`` and ``direction`` of
    the ray in the space of the instance, of shape (n, 3). They are attributes as well. All but the indices and the ray
    are 0 for a box.
    """

    def __init__(self, array: NDArray[np.void]) -> None:
        self.array = array
        self._verdicts = np.zeros(len(array), _VERDICT)

    def answer(self, accept: ArrayLike, *, t: ArrayLike = 0.0, end: ArrayLike = False) -> None:
        """Gives verdicts, for all candidates or one for each.

        Args:
            accept: whether the candidate becomes the closest hit of its ray.
            t: the distance of the hit of a box. It counts from the ray's ``t_min`` up to its closest hit or ``t_max``.
            end: whether the ray ends, with its closest hit.

        Raises:
            ValueError: another number or type of values than candidates take.
        """
        verdicts = np.zeros(len(self), _VERDICT)
        for name, given, kinds in (("accept", accept, "b"), ("end", end, "b"), ("t", t, "fiu")):
            values = np.asarray(given)
            expected = "booleans" if kinds == "b" else "numbers"
            if values.dtype.kind not in kinds or values.shape not in ((), (len(self),)):
                found = f"{values.dtype} of shape {values.shape}"
                raise ValueError(f"{name}: found {found}, expected {expected} of shape () or ({len(self)},)")
            with np.errstate(over="ignore"):
                verdicts[name] = values
        self._verdicts = verdicts

    def __getattr__(self, name: str) -> NDArray[Any]:
        if name.startswith("_") or name not in (self.array.dtype.names or ()):
            raise AttributeError(f"'Candidates' has no attribute '{name}'")
        return self.array[name]

    def __len__(self) -> int:
        return len(self.array)

    def __repr__(self) -> str:
        return f"raypath.Candidates(n={len(self)})"


class Query:
    """Rays of a ``Unit`` with ``queries="full"``, from ``Unit.query``.

    Iterate over it for the candidates of rays that wait for a verdict, at most 16,384 at a time. Each ray meets each
    candidate at most once, and none behind its closest hit. Other rays go on, so that the rays of a batch are not in
    order. After the last batch, ``hits`` has the hits.

    Example:
        >>> import numpy as np, raypath
        >>> unit = raypath.Unit("compact", queries="full")
        >>> leaf = np.float32([[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]])
        >>> scene = unit.scene([raypath.Geometry(leaf, opaque=False), raypath.Geometry(leaf - np.float32([0, 0, 1]))])
        >>> rays = scene.rays(np.float32([[0, 0, 4], [0, 0.5, 4]]), np.float32([[0, 0, -1]] * 2))
        >>> query = unit.query(scene, rays)
        >>> for candidates in query:
        ...     candidates.answer(accept=candidates.ray == 0)
        >>> query.hits.geometry, query.hits.t
        (array([0, 1], dtype=int32), array([4., 5.], dtype=float32))
    """

    def __init__(self, inner: Any) -> None:
        self._inner = inner
        # The last batch, whose verdicts are given when the next is asked for, by this iterator or by another.
        self._last: Candidates | None = None

    def __iter__(self) -> Iterator[Candidates]:
        while (array := self._inner.advance(None if self._last is None else self._last._verdicts)) is not None:
            self._last = Candidates(array)
            yield self._last
        self._last = None

    @property
    def hits(self) -> UnitHits:
        """The hits of all rays, as those of ``Unit.trace``. A hit of a box has the status ``PROCEDURAL``.

        Raises:
            ValueError: rays that have not ended.
        """
        hits: UnitHits = self._inner.hits()
        return hits


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
        scene: what is placed, for ``Unit.group``.
    """

    matrix: ArrayLike | NDArray[Any]
    custom_index: int = 0
    mask: int = 0xFF
    shader_offset: int = 0
    flags: InstanceFlags = InstanceFlags.NONE
    scene: UnitScene | None = None
