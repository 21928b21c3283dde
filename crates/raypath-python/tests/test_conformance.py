"""What Khronos's conformance tests of ray queries check, written anew for the unit. Their groups, in
`external/vulkancts/modules/vulkan/ray_query` of KhronosGroup/VK-GL-CTS, and the tests that cover them:

builtin                   `test_builtin`; flow, t, indices and offsets also `test_unit.py::test_candidates` and the
                          crate raypath-traversal, `tests/queries.rs`. Matrices are with the user, who has the scene.
traversal_control         `test_traversal_control`
acceleration_structures   `test_instance_flags`, `test_inactive`; forms of building, copying and updating do not apply:
                          the unit reads memory that a builder has written
procedural_geometry       `test_procedural_geometry`
advanced                  `test_null_scene`; function wrappers are a matter of compilers
watertightness            `test_watertightness`: no miss, and with edges once each triangle of a surface alone
cull_ray_flags            `test_cull_ray_flags`, and `tests/queries.rs` for all combinations
misc                      `test_preserve_flip_facing`; indexing and helper invocations are matters of shaders
direction_length          `test_direction_length`
inside_aabbs              `test_inside_aabbs`
barycentric_coordinates   `test_barycentric_coordinates`
non_uniform_args          `test_non_uniform_args`
multiple_ray_queries      `test_unit.py::test_candidates`: all rays of an array are queries at the same time
stress                    the same, with stacks of two entries
opacity_micromap, position_fetch, helper_invocations: other extensions
"""

from itertools import product
from typing import Any, Callable

import numpy as np
import pytest
from numpy.typing import NDArray

import raypath
from raypath import Geometry, Instance, InstanceFlags, RayFlags, UnitStatus

BACK = RayFlags.CULL_BACK_FACING_TRIANGLES
Asked = list[tuple[int, bool, int, int]]
UNIT = raypath.Unit("compact", queries="full", instances=True, barycentrics=True)
ONCE = raypath.Unit("compact", queries="full", instances=True, edges="once")
SQUARE = [[[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, 0], [0, 1, 0]]]


def f32(values: Any) -> NDArray[np.float32]:
    return np.asarray(values, np.float32)


def ignore(candidates: raypath.Candidates) -> Any:
    return np.zeros(len(candidates.ray), bool)


def ask(
    geometries: list[Geometry],
    instances: list[Instance] | None,
    rays: dict[str, Any],
    accept: Callable[[raypath.Candidates], Any] = ignore,
    t: Callable[[raypath.Candidates], Any] = lambda candidates: f32(np.zeros(len(candidates.ray))),
    unit: raypath.Unit = UNIT,
) -> tuple[Asked, Any]:
    """The candidates (ray, whether it is a box, geometry, primitive) of rays, and their hits. With `None` there is one
    instance, and with an empty list none."""
    places = [Instance(np.eye(3, 4))] if instances is None else instances or None
    scene = unit.scene(geometries, instances=places)
    arrays = np.broadcast_arrays(*(np.atleast_2d(f32(rays[name])) for name in ("origins", "directions")))
    more = {name: value for name, value in rays.items() if name not in ("origins", "directions")}
    query = unit.query(scene, scene.rays(*(f32(array).copy() for array in arrays), **more))
    asked: Asked = []
    for candidates in query:
        fields = (candidates.ray, candidates.is_box, candidates.geometry, candidates.primitive)
        asked.extend(zip(*(field.tolist() for field in fields)))
        candidates.answer(accept(candidates), t=t(candidates))
    return asked, query.hits


def rotation(x: float, y: float) -> NDArray[np.float64]:
    about_x = [[1, 0, 0], [0, np.cos(x), -np.sin(x)], [0, np.sin(x), np.cos(x)]]
    about_y = [[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]]
    return np.array(about_y) @ np.array(about_x)


LENGTHS = list(product([1.0, 0.5, 2.7, 9.3], [(0.0, 0.0), (1.2, 4.4), (5.9, 0.3), (3.3, 2.2)]))


@pytest.mark.parametrize(("scale", "angles"), LENGTHS)
@pytest.mark.parametrize("is_box", [False, True])
def test_direction_length(scale: float, angles: tuple[float, float], is_box: bool) -> None:
    """A hit at distance 4 has t = 4 / scale, in an interval of 0.001 about it, and the ray is that of the object."""
    triangle = f32([[[0, 0.5, 5], [-0.5, -0.5, 5], [0.5, -0.5, 5]]])
    geometry = Geometry(boxes=f32([[[-0.5, -0.5, 5], [0.5, 0.5, 5]]])) if is_box else Geometry(triangle, opaque=False)
    turn = rotation(*angles)
    at = 4 / scale
    rays = {"origins": turn @ [0, 0, 1], "directions": turn @ [0, 0, scale], "t_min": at - 5e-4, "t_max": at + 5e-4}
    placed = Instance(np.column_stack([turn, np.zeros(3)]))

    def note(candidates: raypath.Candidates) -> Any:
        np.testing.assert_allclose(candidates.origin, [[0, 0, 1]], atol=1e-6)
        np.testing.assert_allclose(candidates.direction, [[0, 0, scale]], atol=1e-5)
        return candidates.t >= 0

    asked, hits = ask([geometry], [placed], rays, note, lambda c: f32(np.full(len(c.ray), at)))
    assert asked == [(0, is_box, 0, 0)]
    assert abs(hits.t[0] - at) < 1e-3


@pytest.mark.parametrize(("scale", "angles"), LENGTHS)
@pytest.mark.parametrize("end", ["zero", "inside", "edge", "outside"])
def test_inside_aabbs(scale: float, angles: tuple[float, float], end: str) -> None:
    """A ray that begins in a box meets it, wherever it ends."""
    turn, edge = rotation(*angles), 4 / scale
    t_max = {"zero": 0.0, "inside": edge / 2, "edge": edge, "outside": edge + 1}[end]
    rays = {"origins": turn @ [0, 0, 1], "directions": turn @ [0, 0, scale], "t_max": t_max}
    placed = Instance(np.column_stack([turn, np.zeros(3)]))
    asked, hits = ask([Geometry(boxes=f32([[[-0.5, -0.5, 0], [0.5, 0.5, 5]]]))], [placed], rays, lambda c: c.is_box)
    assert asked == [(0, True, 0, 0)]
    assert (hits.status[0], hits.t[0]) == (UnitStatus.PROCEDURAL, 0)


def ellipsoid(origins: NDArray[np.float32]) -> NDArray[np.float64]:
    """Where rays along -z enter an ellipsoid at (32, 32, -30) with radii (30, 15, 5); NaN where they do not."""
    x, y = (origins[:, 0] - 32.0) / 30, (origins[:, 1] - 32.0) / 15
    with np.errstate(invalid="ignore"):
        depth: NDArray[np.float64] = origins[:, 2] + 30.0 - 5 * np.sqrt(1 - x * x - y * y)
    return depth


@pytest.mark.parametrize("with_triangle", [False, True])
def test_procedural_geometry(with_triangle: bool) -> None:
    """An object that lies behind its boxes, also behind a triangle between the two, is found as in a box around it."""
    x, y = np.meshgrid(np.arange(64) + 0.5, np.arange(64) + 0.5)
    origins = f32(np.stack([x.ravel(), y.ravel(), np.full(64 * 64, 2)], axis=1))
    at = ellipsoid(origins)
    wall = [[[0, 0, 0], [20, 64, 1]], [[20, 0, 0], [44, 64, 1]], [[44, 0, 0], [64, 64, 1]]]
    around = [[[0, 0, -64], [64, 64, -16]]]
    triangle = Geometry(f32([[[16, 16, -8], [56, 32, -8], [32, 48, -8]]]))
    hits = []
    for boxes in (around, wall):
        geometries = [Geometry(boxes=f32(boxes)), *([triangle] if with_triangle else [])]
        rays = {"origins": origins, "directions": [0, 0, -1], "t_max": 50.0, "flags": BACK}
        _, found = ask(geometries, None, rays, lambda c: ~np.isnan(at[c.ray]), lambda c: f32(np.nan_to_num(at[c.ray])))
        hits.append(found)
    np.testing.assert_array_equal(hits[0].t, hits[1].t)
    np.testing.assert_array_equal(hits[0].status, hits[1].status)
    counts = [(hits[0].status == status).sum() for status in (UnitStatus.HIT, UnitStatus.PROCEDURAL)]
    assert (counts[0] > 300) == with_triangle
    assert counts[1] > 500


def test_preserve_flip_facing() -> None:
    """The flip of an instance holds for all its triangles: two whose normals point along the ray are not culled."""
    corners = [[-1, -1], [1, -1], [0, 1]]
    triangles = f32([[[x, y, z] for x, y in corners] for z in (5, 6)])
    for flags, count in [(InstanceFlags.FLIP_FACING, 2), (InstanceFlags(0), 0)]:
        rays = {"origins": [0, 0, 0], "directions": [0, 0, 1], "t_min": 1.0, "t_max": 10.0, "flags": BACK}
        placed = Instance(np.eye(3, 4), flags=flags)
        asked, _ = ask([Geometry(triangles, opaque=False)], [placed], rays)
        assert len(asked) == count


def squares(count: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Two triangles for each of `count` squares along x at z = 0, whose normals point along +z, and a ray along -z
    through each square."""
    across = f32(np.arange(count))[:, None, None, None] * f32([1, 0, 0])
    origins = f32([[x + 0.4, 0.7, 0.2] for x in range(count)])
    return (f32(SQUARE) + across).reshape(-1, 3, 3), origins


def towards(origins: Any) -> dict[str, Any]:
    return {"origins": origins, "directions": [0, 0, -1], "t_max": 9.0}


@pytest.mark.parametrize("is_box", [False, True])
def test_builtin(is_box: bool) -> None:
    """What candidates and hits say of squares: two instances of eight geometries each, every other square reversed."""
    triangles, origins = squares(8)
    triangles[2::4], triangles[3::4] = triangles[2::4, ::-1], triangles[3::4, ::-1]
    boxes = np.stack([triangles.min(axis=1), triangles.max(axis=1)], axis=1)[::2]
    parts = [{"boxes": boxes[k : k + 1]} if is_box else {"triangles": triangles[2 * k : 2 * k + 2]} for k in range(8)]
    geometries = [Geometry(**part, opaque=is_box and k % 3 == 0) for k, part in enumerate(parts)]
    move = np.eye(3, 4)
    move[1, 3] = 2
    placed = [
        Instance(np.eye(3, 4), custom_index=77, shader_offset=9),
        Instance(move, custom_index=0xFFFFFF, shader_offset=0xABCDEF),
    ]
    seen: list[tuple[Any, ...]] = []

    def note(candidates: raypath.Candidates) -> Any:
        names = ("ray", "instance", "custom_index", "shader_offset", "geometry", "primitive", "back_face", "is_opaque")
        seen.extend(zip(*(getattr(candidates, name).tolist() for name in names)))
        return candidates.ray >= 0

    rays = towards(np.concatenate([origins, origins + f32([0, 2, 0])]))
    _, hits = ask(geometries, placed, rays, note, lambda c: f32(np.full(len(c.ray), 0.2)))
    indices = [(0, 77, 9)] * 8 + [(1, 0xFFFFFF, 0xABCDEF)] * 8
    primitive = 0 if is_box else 1
    expected = [
        (ray, *indices[ray], ray % 8, primitive, not is_box and ray % 2 == 1, is_box and ray % 8 % 3 == 0)
        for ray in range(16)
    ]
    assert sorted(seen) == expected
    names = ("instance", "custom_index", "shader_offset", "geometry", "primitive", "back_face")
    fields = zip(range(16), *(getattr(hits, name).tolist() for name in names))
    assert list(fields) == [one[:-1] for one in expected]
    np.testing.assert_allclose(hits.t, 0.2, rtol=1e-6)
    assert set(hits.status) == {UnitStatus.PROCEDURAL if is_box else UnitStatus.HIT}


@pytest.mark.parametrize("is_box", [False, True])
def test_traversal_control(is_box: bool) -> None:
    """A candidate that is accepted is the hit, one that is not is none, and a query that ends has what it had."""
    layers = [f32(SQUARE) - f32([0, 0, depth]) for depth in (0, 1, 2)]
    geometry = Geometry(boxes=f32([[[0, 0, -d], [1, 1, -d]] for d in (0, 1, 2)])) if is_box else None
    geometry = geometry or Geometry(np.concatenate(layers), opaque=False)
    scene = UNIT.scene([geometry], instances=[Instance(np.eye(3, 4))])
    origins = np.repeat(f32([[0.4, 0.7, 0.5]]), 4, axis=0)
    query = UNIT.query(scene, scene.rays(origins, np.repeat(f32([[0, 0, -1]]), 4, axis=0)))
    asked: list[list[int]] = [[], [], [], []]
    for candidates in query:
        # Of rays 0 to 3: the nearest is accepted, all are ignored, the second is accepted, the first one ends the ray.
        layer = candidates.primitive if is_box else candidates.primitive // 2
        for ray, number in zip(candidates.ray.tolist(), layer.tolist()):
            asked[ray].append(number)
        accept = (candidates.ray == 0) | ((candidates.ray == 2) & (layer == 1))
        candidates.answer(accept, t=f32(layer) + f32(0.5), end=candidates.ray == 3)
    np.testing.assert_allclose(query.hits.t, [0.5, np.inf, 1.5, np.inf], rtol=1e-6)
    assert sorted(asked[1]) == [0, 1, 2]
    assert len(asked[3]) == 1
    assert all(len(set(layers)) == len(layers) for layers in asked)


FLAGS = [RayFlags(0), *RayFlags]


@pytest.mark.parametrize("flags", FLAGS, ids=[flag.name or "none" for flag in FLAGS])
def test_cull_ray_flags(flags: RayFlags) -> None:
    """Whether a ray meets a square, and whether it asks: front and back faces, opaque or not, and boxes."""
    front, back = f32(SQUARE), f32(SQUARE)[:, ::-1] + f32([1, 0, 0])
    box = f32([[[0, 0, -0.25], [1, 1, 0]]])
    geometries = [
        Geometry(front),
        Geometry(front + f32([2, 0, 0]), opaque=False),
        Geometry(back),
        Geometry(back + f32([2, 0, 0]), opaque=False),
        Geometry(boxes=box + f32([4, 0, 0])),
        Geometry(boxes=box + f32([5, 0, 0]), opaque=False),
    ]
    at = {0: 0.4, 1: 2.4, 2: 1.4, 3: 3.4, 4: 4.4, 5: 5.4}
    origins = f32([[at[k], 0.7, 0.2] for k in range(6)])
    rays: dict[str, Any] = {**towards(origins), "flags": flags}
    asked, hits = ask(geometries, None, rays, lambda c: c.ray >= 0, lambda c: f32(np.full(len(c.ray), 0.2)))
    gone = {
        RayFlags.CULL_BACK_FACING_TRIANGLES: {2, 3},
        RayFlags.CULL_FRONT_FACING_TRIANGLES: {0, 1},
        RayFlags.CULL_OPAQUE: {0, 2, 4},
        RayFlags.CULL_NO_OPAQUE: {1, 3, 5},
        RayFlags.SKIP_TRIANGLES: {0, 1, 2, 3},
        RayFlags.SKIP_AABBS: {4, 5},
    }.get(flags, set())
    asks = {RayFlags.OPAQUE: {4, 5}, RayFlags.NO_OPAQUE: {0, 1, 2, 3, 4, 5}}.get(flags, {1, 3, 4, 5})
    assert {ray for ray, *_ in asked} == asks - gone
    assert {int(ray) for ray in np.flatnonzero(hits.status)} == {0, 1, 2, 3, 4, 5} - gone


@pytest.mark.parametrize("flip", [False, True])
@pytest.mark.parametrize("no_cull", [False, True])
def test_instance_flags(flip: bool, no_cull: bool) -> None:
    """Triangles whose vertices run the other way are seen by a ray that culls back faces if a flag says so."""
    flags = InstanceFlags.FLIP_FACING * flip | InstanceFlags.FACING_CULL_DISABLE * no_cull
    for turned in (False, True):
        triangles = f32(SQUARE)[:, ::-1].copy() if turned else f32(SQUARE)
        move = np.column_stack([rotation(0.3, 0.2) * [1, 1, -2], [0, 0, 0]])
        for matrix in (np.eye(3, 4), move):
            origin = matrix @ [0.4, 0.7, 0.2, 1]
            rays = {"origins": origin, "directions": matrix[:, :3] @ [0, 0, -1], "flags": BACK}
            _, hits = ask([Geometry(triangles)], [Instance(matrix, flags=InstanceFlags(flags))], rays)
            assert (hits.status[0] == UnitStatus.HIT) == (no_cull or turned == flip)


@pytest.mark.parametrize("which", [[0], [1], [2], [0, 1], [0, 1, 2]])
def test_inactive(which: list[int]) -> None:
    """A triangle with a vertex whose x is NaN is not there, a box as well, and they count in the indices of others."""
    triangles = f32(SQUARE)
    triangles[0, which, 0] = np.nan
    rays = towards([[0.7, 0.4, 0.2], [0.4, 0.7, 0.2]])
    _, hits = ask([Geometry(triangles)], None, rays)
    assert hits.status.tolist() == [UnitStatus.MISS, UnitStatus.HIT]
    assert hits.primitive[1] == 1
    boxes = f32([[[np.nan, 0, 0], [1, 1, 0]], [[0, 0, -1], [1, 1, -1]]])
    asked, _ = ask([Geometry(boxes=boxes)], None, rays)
    assert [primitive for *_, primitive in asked] == [1, 1]


def test_degenerate() -> None:
    """A triangle whose vertices are on one line is never hit, although rounding moves them apart."""
    line, origin, direction = f32([[[1, 0, 1], [1, 1, 2], [1, 2, 3]]]), f32([[3, -2, 1]]), f32([[-2, 3, 1]])
    for triangles, found in ((line, 0), (np.concatenate([line, f32(SQUARE)]), 1)):
        rays = {"origins": np.concatenate([origin, f32([[0.7, 0.2, 9]])]), "directions": [*direction, [0, 0, -1]]}
        _, hits = ask([Geometry(triangles)], None, rays)
        assert hits.status.tolist() == [UnitStatus.MISS, found]
    mesh = raypath.Scene(line[0], np.array([[0, 1, 2]]))
    assert raypath.trace(mesh, raypath.rays(origin, direction), two_sided=True).triangle.tolist() == [-1]


def test_null_scene() -> None:
    """A scene without anything is missed by all rays."""
    scene = raypath.UnitScene(b"", 0)
    rays = scene.rays(np.zeros((3, 3), np.float32), f32(np.eye(3)))
    assert UNIT.trace(scene, rays).status.tolist() == [UnitStatus.MISS] * 3


def test_barycentric_coordinates() -> None:
    """Of random points in a triangle that is placed anywhere, with the weights of its second and third vertex."""
    random = np.random.default_rng(8)
    corners = random.uniform(-1, 1, (3, 3))
    weights = random.dirichlet([1, 1, 1], 300)
    weights = weights[weights.min(axis=1) > 1e-3]
    directions = f32(weights @ corners - [3, 4, 5])
    for opaque in (False, True):
        seen = np.zeros((len(directions), 2))

        def note(candidates: raypath.Candidates, seen: NDArray[np.float64] = seen) -> Any:
            seen[candidates.ray] = np.stack([candidates.u, candidates.v], axis=1)
            return candidates.ray >= 0

        rays = {"origins": [3, 4, 5], "directions": directions}
        _, hits = ask([Geometry(f32([corners]), opaque=opaque)], None, rays, note)
        np.testing.assert_allclose(np.stack([hits.u, hits.v], axis=1), weights[:, 1:], atol=1e-4)
        np.testing.assert_allclose(seen, 0 if opaque else weights[:, 1:], atol=1e-4)


CAUSES: dict[str, dict[str, Any]] = {
    "none": {},
    "flags": {"flags": RayFlags.SKIP_TRIANGLES},
    "cull mask": {"cull_mask": 0xF0},
    "origin": {"origins": [0, 8, 0]},
    "t_min": {"t_min": 5.5},
    "direction": {"directions": [1, 0, 0]},
    "t_max": {"t_max": 4.5},
}


@pytest.mark.parametrize("cause", CAUSES)
def test_non_uniform_args(cause: str) -> None:
    """Each argument of a ray alone can keep it from a triangle."""
    away, near = (f32([[[0, 2.5, z], [-0.5, 1.5, z], [0.5, 1.5, z]]]) for z in (-5, 5))
    geometries = [Geometry(triangles, opaque=False) for triangles in (away, near)]
    placed = [Instance(np.eye(3, 4), mask=0x0F, flags=InstanceFlags.FACING_CULL_DISABLE)]
    rays = {"origins": [0, 2, 0], "directions": [0, 0, 1], "t_min": 4.0, "t_max": 6.0, "cull_mask": 0x0F}
    asked, _ = ask(geometries, placed, {**rays, **CAUSES[cause]})
    assert asked == ([(0, False, 1, 0)] if cause == "none" else [])


def test_watertightness() -> None:
    """No ray passes between the triangles of closed fans, aimed at their edges and centres, or through the lines of a
    flat grid, also from far away. With edges once, each passes through exactly one triangle."""
    random = np.random.default_rng(9)
    several = 0
    for count in (3, 5, 17, 64):
        angles = np.sort(np.concatenate([random.uniform(0, 2 * np.pi, count - 3), [0.1, 2.2, 4.3]]))
        rim = f32(np.stack([np.cos(angles), np.sin(angles), 0.3 * np.cos(2 * angles)], axis=1))
        centre = f32([0.01, -0.02, 0.03])
        fan = f32([[centre, rim[k], rim[(k + 1) % count]] for k in range(count)])
        along = random.uniform(0, 0.99, (2000, 1)) * (random.random((2000, 1)) < 0.7)
        aimed = centre + along * (rim[random.integers(0, count, 2000)] - centre)
        origins = f32(random.uniform([-0.4, -0.4, 4.6], [0.4, 0.4, 5.4], (2000, 3)))
        rays = {"origins": origins, "directions": f32(aimed) - origins}
        asked, hits = ask([Geometry(fan, opaque=False)], None, rays, lambda c: c.ray >= 0)
        assert (hits.status == UnitStatus.HIT).all()
        assert len({ray for ray, *_ in asked}) == 2000
        asked, _ = ask([Geometry(fan, opaque=False)], None, rays)
        several += len(asked) - 2000
        asked, _ = ask([Geometry(fan, opaque=False)], None, rays, unit=ONCE)
        assert sorted(ray for ray, *_ in asked) == list(range(2000))
    x, y = np.meshgrid(np.arange(20), np.arange(20), indexing="ij")
    corners = f32(np.stack([0.37 * x, 0.21 * y, 0 * x], axis=-1))
    a, b, c, d = corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]
    grid = np.concatenate([np.stack(face, axis=2).reshape(-1, 3, 3) for face in ((a, b, c), (a, c, d))])
    aimed = corners[random.integers(1, 19, 4000), random.integers(1, 19, 4000)]
    aimed[:2000, 0] += f32(random.uniform(0, 0.37, 2000))
    origins = aimed + f32(random.uniform([-3, -3, 2], [3, 3, 5], (4000, 3)) * 4.0 ** random.uniform(0, 6, (4000, 1)))
    rays = {"origins": origins, "directions": aimed - origins}
    assert (ask([Geometry(grid)], [], rays)[1].status == UnitStatus.HIT).all()
    asked, _ = ask([Geometry(grid, opaque=False)], [], rays)
    several += len(asked) - 4000
    asked, _ = ask([Geometry(grid, opaque=False)], [], rays, unit=ONCE)
    assert sorted(ray for ray, *_ in asked) == list(range(4000))
    assert several > 500
