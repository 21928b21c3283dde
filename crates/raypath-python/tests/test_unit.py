"""The traversal unit: hits against a brute-force oracle in float64, cycle-exact against functional model."""

import re
import subprocess
import sys
from collections import deque
from pathlib import Path
from typing import Any, Callable, Literal

import numpy as np
import pytest
from helpers import Mesh, f32, nearest
from numpy.typing import NDArray

import raypath

Float32 = NDArray[np.float32]
BACK, FRONT = raypath.RayFlags.CULL_BACK_FACING_TRIANGLES, raypath.RayFlags.CULL_FRONT_FACING_TRIANGLES


@pytest.fixture(scope="module")
def unit() -> raypath.Unit:
    """A small unit, so that rays wait for contexts."""
    return raypath.Unit("compact", contexts=8, stack=2, memory_width=256, id_width=12, barycentrics=True)


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    """Triangles at random places and angles, none of which shares a vertex with another."""
    random = np.random.default_rng(3)
    vertices = random.uniform(-1, 1, (100, 1, 3)) + random.uniform(-0.3, 0.3, (100, 3, 3))
    return vertices.reshape(-1, 3).astype(np.float32), np.arange(300, dtype=np.uint32).reshape(-1, 3)


@pytest.fixture(scope="module")
def scene(unit: raypath.Unit, mesh: Mesh) -> raypath.UnitScene:
    return unit.scene(mesh[0][mesh[1]])


def numbers(count: int) -> tuple[Float32, Float32]:
    """Origins, and directions towards the scene."""
    random = np.random.default_rng(4)
    origins = random.uniform(-4, 4, (count, 3)).astype(np.float32)
    return origins, (random.uniform(-1, 1, (count, 3)) - origins).astype(np.float32)


def test_trace(unit: raypath.Unit, scene: raypath.UnitScene, mesh: Mesh) -> None:
    """The closest hit of each ray, except where rounding decides: of front faces, and of back faces of a mesh that is
    turned inside out."""
    origins, directions = numbers(2000)
    triangle, t, doubt = nearest(mesh, origins, directions)
    clear, hit = doubt > 1e-4, triangle >= 0
    assert clear.mean() > 0.8
    assert 0.2 < hit.mean() < 0.9
    inside_out = unit.scene(mesh[0][mesh[1]][:, ::-1].copy())
    for memory, flags, is_back in [(scene, BACK, False), (inside_out, FRONT, True)]:
        hits = unit.trace(memory, memory.rays(origins, directions, flags=flags))
        np.testing.assert_array_equal(hits.status[clear], hit[clear])
        chosen = clear & hit
        np.testing.assert_array_equal(hits.primitive[chosen], triangle[chosen])
        np.testing.assert_allclose(hits.t[chosen], t[chosen], rtol=1e-3)
        np.testing.assert_array_equal(hits.t[chosen], hits.t_num[chosen] / hits.t_denom[chosen])
        assert (hits.back_face[chosen] == is_back).all()
        corners = mesh[0][mesh[1]].astype(np.float64)[triangle[chosen]][:, :: -1 if is_back else 1]
        weights = np.stack([1 - hits.u - hits.v, hits.u, hits.v], axis=1)[chosen]
        points = (origins + t[:, None] * directions)[chosen]
        np.testing.assert_allclose((weights[:, :, None] * corners).sum(1), points, atol=1e-3)
        assert (hits.t_denom[chosen] < 0).all() == is_back
        assert np.isinf(hits.t[hits.status == 0]).all()
        assert (hits.primitive[hits.status == 0] == -1).all()
        assert len(hits) == 2000


def test_fields_of_rays() -> None:
    """Range, faces and any hit, set for single rays, and what the unit refuses. Weights are a feature."""
    unit = raypath.Unit()
    scene = unit.scene(f32([[[-1, -1, z], [1, -1, z], [0, 1, z]] for z in (0, 2)]))
    rays = scene.rays(np.tile(f32([0, 0, 4]), (7, 1)), np.tile(f32([0, 0, -2]), (7, 1)), t_max=10)
    rays["t_min"][1] = 1.5
    rays["t_max"][2] = 0.5
    rays["flags"][3] = FRONT
    rays["flags"][4] = raypath.RayFlags.TERMINATE_ON_FIRST_HIT
    rays["direction"][5] = 0
    rays["t_min"][6] = -1
    hits = unit.trace(scene, rays)
    assert hits.status.tolist() == [1, 1, 0, 0, 1, 3, 3]
    assert hits.t.tolist()[:4] == [1, 2, np.inf, np.inf]
    assert hits.primitive.tolist()[:2] == [1, 0]
    assert not hits.u.any()
    small = raypath.Unit(node="quantised")
    assert small.parameters["node"] == "quantised"
    their_scene = small.scene(f32([[[-1, -1, z], [1, -1, z], [0, 1, z]] for z in (0, 2)]))
    rays_there = rays.copy()
    rays_there["root"] = their_scene.root
    assert small.trace(their_scene, rays_there).t.tolist() == hits.t.tolist()
    beyond = raypath.UnitScene(b"", scene.root)
    assert unit.trace(beyond, rays[:1]).status.tolist() == [raypath.UnitStatus.MEMORY]
    again = raypath.UnitScene(scene.data, scene.root)
    np.testing.assert_array_equal(unit.trace(again, rays).array, hits.array)


def run(model: raypath.UnitModel, scene: raypath.UnitScene, rays: NDArray[np.void], latency: int) -> dict[int, Any]:
    """The hits by number, through a memory that answers in order after a latency, in beats of 32 bytes."""
    found: dict[int, Any] = {}
    beats: deque[tuple[int, int, bytes]] = deque()
    offered = cycle = 0
    while len(found) < len(rays):
        response = None
        if beats and beats[0][0] <= cycle:
            response = beats.popleft()[1:]
        outputs = model.step(rays[offered] if offered < len(rays) else None, offered % len(rays), response=response)
        offered += outputs.ray_ready and offered < len(rays)
        if outputs.request is not None:
            address, tag = outputs.request
            parts = (scene.data[address + at : address + at + 32] for at in range(0, 128, 32))
            beats.extend((cycle + latency, tag, part) for part in parts)
        if outputs.hit_id is not None:
            assert outputs.hit_id not in found
            found[outputs.hit_id] = outputs.hit
        cycle += 1
        if offered == len(rays) and beats and outputs.request is None and beats[0][0] > cycle:
            cycle += model.skip(beats[0][0] - cycle)
    assert model.counts["cycles"] == cycle
    return found


def test_model(unit: raypath.Unit, scene: raypath.UnitScene) -> None:
    """A ray's hit does not depend on the memory and on time. The jobs are those of the nodes and triangles of hits."""
    rays = scene.rays(*numbers(60))
    hits = unit.trace(scene, rays)
    model = raypath.UnitModel(unit)
    for latency in (1, 90):
        found = run(model, scene, rays, latency)
        names = hits.array.dtype.names or ()
        assert [found[ray] for ray in range(60)] == [dict(zip(names, hit.item())) for hit in hits.array]
        counts = model.counts
        assert (counts["rays"], counts["boxes"], counts["triangles"]) == (60, hits.nodes.sum(), hits.triangles.sum())
        assert counts["restarts"] > 0
        assert counts["rays_inside"] == 0
        assert 1 < counts["ray_cycles"] / counts["cycles"] <= 8
        model.reset()
    assert not any(model.counts.values())
    deep = raypath.UnitModel(raypath.Unit("compact", contexts=8, stack=32, memory_width=256, id_width=12))
    run(deep, scene, rays, 1)
    assert deep.counts["restarts"] == 0
    assert model.outputs.hit is None


def test_run(unit: raypath.Unit, scene: raypath.UnitScene) -> None:
    """Many cycles at once are as single ones, also in two calls, with sinks that are not always ready."""
    rays, model = scene.rays(*numbers(60)), raypath.UnitModel(unit)
    ids = np.arange(60)[::-1].copy()
    ready = np.random.default_rng(6).random((2, 40_000)) < 0.7
    options: Any = {"scene": scene, "latency": 9}
    first = model.run(700, rays, ids, hit_ready=ready[0, :700], request_ready=ready[1, :700], **options)
    left = slice(first["accepted"], None)
    rest = model.run(39_300, rays[left], ids[left], hit_ready=ready[0, 700:], request_ready=ready[1, 700:], **options)
    assert 0 < first["accepted"] < 60 == first["accepted"] + rest["accepted"]
    found = dict(zip(first["hit_ids"].tolist() + rest["hit_ids"].tolist(), [*first["hits"], *rest["hits"]]))
    expected = unit.trace(scene, rays)
    assert [found[59 - ray].tolist() for ray in range(60)] == expected.array.tolist()

    single = raypath.UnitModel(unit)
    accepted, beats, cycles = 0, deque[tuple[int, int, bytes]](), []
    for cycle in range(700):
        response = beats.popleft()[1:] if beats and beats[0][0] <= cycle else None
        hit, request = (bool(bits[cycle]) for bits in ready)
        ray, number = (rays[accepted], int(ids[accepted])) if accepted < 60 else (None, 0)
        outputs = single.step(ray, number, response=response, hit_ready=hit, request_ready=request)
        accepted += outputs.ray_ready
        if outputs.request is not None and request:
            address, tag = outputs.request
            beats.extend((cycle + 9, tag, scene.data[address + at : address + at + 32]) for at in range(0, 128, 32))
            cycles.append(cycle)
    assert (accepted, cycles) == (first["accepted"], first["request_cycles"].tolist())
    assert single.counts["cycles"] == 700


def test_skip(unit: raypath.Unit, scene: raypath.UnitScene) -> None:
    """``skip`` stops where a ray is accepted that was not before, as where a hit or a request is at the outputs."""
    rays, stepped, skipped = scene.rays(*numbers(1)), raypath.UnitModel(unit), raypath.UnitModel(unit)
    for model in (stepped, skipped):
        while model.step(rays[0]).ray_ready:
            pass
    cycles = 0
    while (outputs := stepped.outputs).hit is None and outputs.request is None and not outputs.ray_ready:
        stepped.step(hit_ready=False, request_ready=False)
        cycles += 1
    assert cycles > 0
    assert outputs.ray_ready
    assert skipped.skip(1000) == cycles


def test_simulation(unit: raypath.Unit, scene: raypath.UnitScene) -> None:
    """The hits of ``trace``; more cycles with a longer latency or less bandwidth, fewer misses than fetches with a
    cache."""
    rays = scene.rays(*numbers(3000))
    expected = unit.trace(scene, rays)
    hits, timing = unit.simulate(scene, rays, latency=20)
    np.testing.assert_array_equal(hits.array, expected.array)
    assert (timing["rays"], timing["boxes"], timing["triangles"]) == (3000, hits.nodes.sum(), hits.triangles.sum())
    assert timing["beats"] == 4 * timing["fetches"]
    assert 7 < timing["rays_in_flight"] <= 8
    assert timing["jobs_per_cycle"] == (timing["boxes"] + timing["triangles"]) / timing["cycles"]
    slow, narrow, cached = (
        unit.simulate(scene, rays, **options)[1]
        for options in ({"latency": 200}, {"latency": 20, "bandwidth": 4}, {"latency": 200, "cache": 1 << 16})
    )
    # 8 rays share the latency of all fetches, less that which other work covers.
    assert slow["cycles"] > 200 * slow["fetches"] / 8
    assert narrow["cycles"] > narrow["fetches"] * 128 / 4
    assert cached["cache_misses"] < cached["cache_hits"]
    assert cached["cycles"] < slow["cycles"]


def test_bases() -> None:
    """Two rays in different windows of 4 GiB, of which the first has the scene: a node and a leaf."""
    unit = raypath.Unit("compact", contexts=8, address_width=40)
    scene = unit.scene(f32([[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]]))
    rays = scene.rays(np.tile(f32([0, 0, 4]), (2, 1)), np.tile(f32([0, 0, -1]), (2, 1)), base=255)
    rays["base"][1] = 0
    assert unit.trace(scene, rays).status.tolist() == [raypath.UnitStatus.MEMORY, raypath.UnitStatus.HIT]
    found = raypath.UnitModel(unit).run(500, rays, scene=scene)
    assert found["request_addresses"].tolist() == [255 << 32, 0, 128]
    assert dict(zip(found["hit_ids"].tolist(), found["hits"].status.tolist())) == {0: 4, 1: 1}


def test_parameters(unit: raypath.Unit) -> None:
    """Keywords and TOML set the same parameters."""
    numbers_of = {
        "contexts": 8,
        "stack": 2,
        "memory_width": 256,
        "id_width": 12,
        "address_width": 32,
        "divider_latency": 11,
        "ram_latency": 1,
        "node_limit": 1 << 24,
    }
    parts = {"instances": False, "nested_instances": False, "queries": "none", "search": "none"}
    parts |= {"parity": False, "front": "counter-clockwise"}
    expected = {**numbers_of, "node": "wide4", **parts}
    assert unit.parameters == expected
    lines = ["contexts = 8", "stack = 2", "memory-width = 256", "id-width = 12", "barycentrics = true"]
    toml = raypath.Unit(config='preset = "compact"\n' + "\n".join(lines))
    assert (toml.parameters, repr(toml)) == (expected, repr(unit))


def test_generate(unit: raypath.Unit, tmp_path: Path) -> None:
    """The files of ``raypath generate --unit`` with the parameters of the unit."""
    assert unit.generate(tmp_path) == sum(path.is_file() for path in tmp_path.rglob("*"))
    text = (tmp_path / "rtl/raypath_unit.sv").read_text()
    assert re.search(r"\[255:0\] +mem_rsp_data_i", text)
    assert (tmp_path / "raypath_unit_axi.f").exists()
    with pytest.raises(OSError, match="/dev/null"):
        unit.generate("/dev/null/x")


TRIANGLE = f32([[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]])
TWO_LEVELS = raypath.Unit("compact", contexts=8, memory_width=256, instances=True)
# The object itself, moved, and with its axes exchanged: under these, transforms of numbers on a grid are exact.
PLACES = np.array(
    [
        [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]],
        [[1, 0, 0, 8], [0, 1, 0, 0], [0, 0, 1, 16]],
        [[0, 0, 1, 0], [1, 0, 0, -16], [0, 1, 0, 0]],
    ],
    np.float64,
)


def on_grid(values: NDArray[np.floating[Any]]) -> Float32:
    """Multiples of 1/1024."""
    return (np.round(values * 1024) / 1024).astype(np.float32)


def two_levels(mesh: Mesh) -> tuple[Float32, Float32, Float32, Float32]:
    """The triangles of an object, those of its instances, and rays towards the instances."""
    triangles = on_grid(mesh[0][mesh[1]])
    flat = np.concatenate([triangles @ place[:, :3].T + place[:, 3] for place in PLACES]).astype(np.float32)
    random = np.random.default_rng(9)
    origins = on_grid(random.uniform(-4, 4, (900, 3)))
    targets = flat[random.integers(len(flat), size=900), 0] + on_grid(random.uniform(-0.3, 0.3, (900, 3)))
    return triangles, flat, origins, targets - origins


def test_instances(mesh: Mesh) -> None:
    """Hits of instances have the bits of those of all their triangles as one mesh, by both models."""
    triangles, flat, origins, directions = two_levels(mesh)
    scene, expected_scene = TWO_LEVELS.scene(triangles, instances=PLACES), TWO_LEVELS.scene(flat)
    rays, expected_rays = (memory.rays(origins, directions, flags=BACK) for memory in (scene, expected_scene))
    hits, expected = TWO_LEVELS.trace(scene, rays), TWO_LEVELS.trace(expected_scene, expected_rays)
    hit = hits.status == 1
    assert 0.2 < hit.mean() < 0.9
    assert (np.bincount(hits.instance[hit]) > 20).all()
    np.testing.assert_array_equal(hits.status, expected.status)
    np.testing.assert_array_equal((hits.instance * 100 + hits.primitive)[hit], expected.primitive[hit])
    for name in ("t", "t_num", "t_denom", "back_face"):
        np.testing.assert_array_equal(hits.array[name], expected.array[name])
    assert (hits.instance[~hit] == -1).all()
    assert (expected.instance == -1).all()
    timed, _ = TWO_LEVELS.simulate(scene, rays, latency=5)
    np.testing.assert_array_equal(timed.array, hits.array)
    found = run(raypath.UnitModel(TWO_LEVELS), scene, rays[:30], 3)
    assert [found[ray]["instance"] for ray in range(30)] == hits.instance[:30].tolist()
    near = TWO_LEVELS.scene(triangles, instances=PLACES, reach=64)
    np.testing.assert_array_equal(TWO_LEVELS.trace(near, rays).t, hits.t)
    far = near.rays(f32([[0, 0, 400]]), f32([[0, 0, -1]]))
    with pytest.warns(UserWarning, match="1 rays begin .* away .* built for a reach of 64: .* reach="):
        TWO_LEVELS.trace(near, far)


@pytest.mark.parametrize("node", ["wide4", "quantised", "wide8"])
def test_groups(node: Literal["wide4", "quantised", "wide8"]) -> None:
    """Scenes in scenes, in three levels: the hits of all triangles at their places, whose coordinates are exact. The
    rays of candidates meet their triangles in the space of these."""

    def moved(scale: float, *by: float) -> NDArray[np.float64]:
        return np.concatenate([scale * np.eye(3), np.array(by)[:, None]], axis=1)

    unit = raypath.Unit("compact", instances=True, nested_instances=True, queries="full", node=node)
    random = np.random.default_rng(3)
    corners = random.uniform(-1, 1, (40, 1, 3)) + random.uniform(-0.3, 0.3, (40, 3, 3))
    triangles = (np.round(corners * 64) / 64).astype(np.float32)
    body = unit.scene([raypath.Geometry(triangles, opaque=False)])
    inner, outer = (
        [moved(1, 0, 0, 0), moved(0.5, 3, 0, 0)],
        [moved(1, 0, 0, 0), moved(-2, 0, 8, 0), moved(0.5, 4, -4, 1)],
    )
    pair = unit.group([raypath.Instance(place, scene=body) for place in inner], reach=4000)
    parts = [raypath.Instance(place, scene=pair) for place in outer]
    world = unit.group([*parts, raypath.Instance(moved(1, -5, 0, 0), scene=body)], reach=500)
    assert (pair.reach, world.reach) == (4000, 500)
    paths = [(first, second) for first in outer for second in inner] + [(moved(1, -5, 0, 0), moved(1, 0, 0, 0))]

    def put(place: NDArray[np.float64], points: NDArray[Any]) -> NDArray[Any]:
        return points @ place[:, :3].T + place[:, 3]

    flat = unit.scene(
        np.concatenate([put(first, put(second, triangles)) for first, second in paths]).astype(np.float32)
    )
    origins = random.uniform(-12, 12, (4000, 3)).astype(np.float32)
    targets = np.concatenate([put(a, put(b, triangles.mean(axis=1))) for a, b in paths])
    directions = targets[random.integers(0, len(targets), 4000)].astype(np.float32) - origins
    found = unit.trace(world, world.rays(origins, directions))
    expected = unit.trace(flat, flat.rays(origins, directions))
    same = (found.status == expected.status) & (np.abs(found.t - expected.t) < 1e-4)
    same |= ~np.isfinite(found.t) & ~np.isfinite(expected.t)
    assert (found.status == raypath.UnitStatus.HIT).sum() > 2000
    assert (~same).sum() < 8
    hit = same & (found.status == raypath.UnitStatus.HIT)
    path = expected.primitive[hit] // 40
    innermost = np.where(path < 6, path % 2, 3)
    right = (found.primitive[hit] == expected.primitive[hit] % 40) & (found.instance[hit] == innermost)
    assert (~right).sum() < 8
    for candidates in unit.query(world, world.rays(origins, directions)):
        a, b, c = triangles[candidates.primitive].swapaxes(0, 1)
        normal = np.cross(b - a, c - a)
        away = candidates.origin + candidates.t[:, None] * candidates.direction - a
        assert np.abs((away * normal).sum(1) / np.linalg.norm(normal, axis=1)).max() < 1e-4
    with pytest.raises(ValueError, match=r"scene 0 was built for a reach of 4000, expected at least .* at its places"):
        unit.group(parts, reach=9000)
    with pytest.raises(ValueError, match="instance 0 has the scene None, expected a UnitScene"):
        unit.group([raypath.Instance(outer[0])])
    with pytest.raises(ValueError, match="bytes from elsewhere"):
        unit.group([raypath.Instance(outer[0], scene=raypath.UnitScene(body.data, body.root))])
    with pytest.raises(ValueError, match="no nested instances, expected a unit with nested instances"):
        raypath.Unit("compact", instances=True, queries="full", node=node).group(parts, reach=500)


@pytest.mark.parametrize("node", ["wide4", "quantised", "wide8"])
def test_small_far_triangle(node: Any) -> None:
    """A triangle of 1e-7 of its distance, 24 degrees beside the ray: with edges shared, products that are equal after
    rounding make it a hit where its box is hit."""
    small = [[-2.36888973e-05, -1.56584443e-04, -7.90799095e-05], [-1.89789425e-04, 8.59675492e-05, -2.98614148e-04]]
    small.append([-7.75014923e-05, -1.79507842e-04, 4.44700672e-05])
    corners = 1e6 * f32([[-1, -1, 1], [1, -1, -1], [-1, 1, -1], [-1, 1, -1.01]])
    big = corners[:, None] + f32([[0, 0, 0], [9, 0, 0], [0, 9, 0]])
    for edges in ("shared", "once"):
        unit = raypath.Unit("compact", node=node, edges=edges)
        scene = unit.scene(np.concatenate([f32([small]), big]))
        rays = scene.rays(f32([[1159.3567, -394.22552, -4307.6147]]), f32([[-0.69405454, 0.4443117, 1]]))
        assert unit.trace(scene, rays).status[0] == (edges == "shared" and node != "wide4")


def test_queries() -> None:
    """Geometries that are opaque or not and have indices; masks, flags and indices of instances."""
    unit = raypath.Unit("compact", instances=True, queries="flags", barycentrics=True)
    assert (unit.parameters["queries"], unit.parameters["front"]) == ("flags", "counter-clockwise")
    depths = [TRIANGLE + f32([0, 0, z]) for z in (0, 1, 2)]
    inactive = depths[1].copy()
    inactive[0, 1, 0] = np.nan
    leaves = raypath.Geometry(np.concatenate([inactive, depths[2]]), opaque=False)
    objects = [
        raypath.Instance(PLACES[0], custom_index=7, mask=1, shader_offset=9),
        raypath.Instance(PLACES[0], mask=2, flags=raypath.InstanceFlags.FORCE_OPAQUE),
    ]
    scene = unit.scene([raypath.Geometry(depths[0]), leaves], instances=objects)
    flags = raypath.RayFlags
    rays = scene.rays(np.tile(f32([0.25, -0.5, 4]), (6, 1)), np.tile(f32([0, 0, -2]), (6, 1)))
    rays["flags"] = [
        0,
        flags.CULL_NO_OPAQUE,
        flags.CULL_NO_OPAQUE,
        flags.CULL_OPAQUE,
        flags.OPAQUE | flags.NO_OPAQUE,
        0,
    ]
    rays["cull_mask"] = [1, 1, 2, 3, 3, 4]
    hits = unit.trace(scene, rays)
    assert hits.status.tolist() == [1, 1, 1, 1, raypath.UnitStatus.REFUSED, raypath.UnitStatus.MISS]
    assert hits.t.tolist()[:4] == [1, 2, 1, 1]
    assert hits.geometry.tolist() == [1, 0, 1, 1, -1, -1]
    # The first of the second geometry is inactive, and counts.
    assert hits.primitive.tolist() == [1, 0, 1, 1, -1, -1]
    assert hits.instance.tolist() == [0, 0, 1, 0, -1, -1]
    assert hits.custom_index.tolist() == [7, 7, 0, 7, 0, 0]
    assert hits.shader_offset.tolist() == [9, 9, 0, 9, 0, 0]
    # u is the weight of the second vertex, v that of the third.
    np.testing.assert_allclose([hits.u[0], hits.v[0]], [0.5, 0.25])
    timed, _ = unit.simulate(scene, rays, latency=5)
    np.testing.assert_array_equal(timed.array, hits.array)
    clockwise = raypath.Unit("compact", front="clockwise")
    plain = clockwise.scene(TRIANGLE)
    assert clockwise.trace(plain, plain.rays(f32([[0, 0, 4]]), f32([[0, 0, -2]]))).back_face.tolist() == [True]


def test_candidates() -> None:
    """Alpha-tested triangles and procedural spheres, against float64: the loop of a ray query over arrays of rays, and
    the same rays through the cycle-exact model."""
    unit = raypath.Unit("compact", queries="full", instances=True, contexts=16, stack=2)
    random = np.random.default_rng(12)
    leaves = random.uniform(-1, 1, (60, 1, 3)) + random.uniform(-0.5, 0.5, (60, 3, 3))
    walls = random.uniform(-1, 1, (20, 1, 3)) + random.uniform(-0.5, 0.5, (20, 3, 3))
    centres, radii = random.uniform(-1, 1, (30, 3)), random.uniform(0.05, 0.3, 30)
    boxes = np.stack([centres - radii[:, None] * 1.01, centres + radii[:, None] * 1.01], axis=1)
    move = np.eye(3, 4)
    move[:, 3] = [0.5, -0.25, 0.125]
    scene = unit.scene(
        [
            raypath.Geometry(leaves.astype(np.float32), opaque=False),
            raypath.Geometry(walls.astype(np.float32)),
            raypath.Geometry(boxes=boxes.astype(np.float32)),
        ],
        instances=[raypath.Instance(move)],
    )
    origins, directions = numbers(3000)
    rays = scene.rays(origins, directions, flags=BACK)
    local = origins.astype(np.float64) - move[:, 3]

    def sphere(ray: Any, index: Any) -> tuple[Any, Any]:
        """Where rays enter spheres."""
        d, o = directions[ray].astype(np.float64), local[ray] - centres[index]
        a, b, c = (d * d).sum(1), (d * o).sum(1), (o * o).sum(1) - radii[index] ** 2
        root = b * b - a * c
        t = (-b - np.sqrt(np.maximum(root, 0))) / a
        return (root > 0) & (t > 0), t.astype(np.float32)

    seen: set[tuple[int, int, int]] = set()
    query = unit.query(scene, rays)
    with pytest.raises(ValueError, match=r"0 of 3000 rays have ended"):
        query.hits  # noqa: B018
    # A loop that is left and begun again goes on.
    while (candidates := next(iter(query), None)) is not None:
        assert set(np.unique(candidates.geometry)) <= {0, 2}
        names = list(zip(candidates.ray.tolist(), candidates.geometry.tolist(), candidates.primitive.tolist()))
        assert not seen.intersection(names)
        seen.update(names)
        np.testing.assert_array_equal(candidates.direction, directions[candidates.ray])
        np.testing.assert_allclose(candidates.origin, local[candidates.ray], atol=1e-6)
        is_hit, t = sphere(candidates.ray, candidates.primitive % 30)
        for wrong in ({"accept": "no"}, {"accept": [True] * (len(t) + 1)}, {"accept": True, "end": 0.5}):
            with pytest.raises(ValueError, match=r"(accept|end): found .*, expected booleans of shape"):
                candidates.answer(**wrong)
        candidates.answer(np.where(candidates.is_box, is_hit, candidates.primitive % 3 == 0), t=t)
    hits = query.hits
    # In float64: the nearest wall, leaf that is not cut out, or sphere.
    kept = np.concatenate([leaves[::3], walls])
    vertices = kept.reshape(-1, 3).astype(np.float32), np.arange(3 * len(kept), dtype=np.uint32).reshape(-1, 3)
    triangle, t, doubt = nearest(vertices, local.astype(np.float32), directions)
    every, ball = np.repeat(np.arange(3000), 30), np.tile(np.arange(30), 3000)
    meets, at = (found.reshape(3000, 30) for found in sphere(every, ball))
    at = np.where(meets, at, np.inf)
    expected = np.where(at.min(1) < t, 2, np.where(triangle >= 20, 1, 0))
    expected[np.isinf(np.minimum(at.min(1), t))] = -1
    gap = np.abs(np.minimum(at.min(1), 1e9) - np.minimum(t, 1e9))
    clear = (doubt > 1e-3) & ((gap > 1e-3) | np.isinf(t))
    assert clear.mean() > 0.7
    np.testing.assert_array_equal(hits.geometry[clear], expected[clear])
    assert all((expected == geometry).sum() > 100 for geometry in (-1, 0, 1, 2))
    np.testing.assert_array_equal(hits.status, np.select([hits.geometry == 2, hits.geometry >= 0], [2, 1], 0))
    np.testing.assert_allclose(hits.t[clear], np.minimum(at.min(1), t)[clear], rtol=1e-3)

    model, found, verdict, beats = raypath.UnitModel(unit), {}, None, deque()  # type: ignore[var-annotated]
    sent = 0
    while len(found) < 60:
        beat = beats.popleft() if beats else None
        outputs = model.step(rays[sent] if sent < 60 else None, sent, response=beat, verdict=verdict)
        sent += outputs.ray_ready and sent < 60
        verdict = None
        if outputs.hit_id is not None:
            found[outputs.hit_id] = outputs.hit
        if outputs.candidate is not None:
            tag, ray, one = outputs.candidate
            assert one["direction"] == directions[ray].tolist()
            is_hit, t = sphere(np.array([ray]), np.array([one["primitive"] % 30]))
            verdict = (tag, bool(is_hit[0]) if one["is_box"] else one["primitive"] % 3 == 0, False, float(t[0]))
        if outputs.request is not None:
            address, tag = outputs.request
            beats.extend((tag, scene.data[address + at : address + at + 64]) for at in (0, 64))
    for ray, hit in found.items():
        assert hit == dict(zip(hits.array.dtype.names or (), hits.array[ray].item()))


def test_instances_of_the_command(mesh: Mesh, tmp_path: Path) -> None:
    """``scene --instances`` writes the bytes of ``Unit.scene``, and ``render`` finds the hits of ``Unit.trace``."""
    triangles, _, origins, directions = two_levels(mesh)
    scene = TWO_LEVELS.scene(triangles, instances=PLACES)
    hits = TWO_LEVELS.trace(scene, scene.rays(origins, directions, flags=BACK))
    corners = triangles.reshape(-1, 3).astype(np.float64).tolist()
    faces = np.arange(1, len(corners) + 1).reshape(-1, 3).tolist()
    obj = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {a} {b} {c}" for a, b, c in faces]
    (tmp_path / "mesh.obj").write_text("\n".join(obj))
    np.savetxt(tmp_path / "places.txt", PLACES.reshape(-1, 12))
    extents = np.full((len(origins), 1), np.inf)
    np.savetxt(tmp_path / "rays.txt", np.hstack([origins, directions, extents]).astype(np.float64))

    def command(*words: str) -> None:
        program = [sys.executable, "-m", "raypath", words[0], "mesh.obj", "--instances", "places.txt", *words[1:]]
        subprocess.run(program, cwd=tmp_path, check=True, capture_output=True)

    command("scene", "--out", "scene.bin")
    assert (tmp_path / "scene.bin").read_bytes() == scene.data
    command("render", "--through", "unit", "--rays", "rays.txt", "--hits", "hits.txt")
    lines = [line.split() for line in (tmp_path / "hits.txt").read_text().splitlines() if not line.startswith("#")]
    names = [words[0] for words in lines]
    is_hit = hits.status == 1
    both = zip(hits.primitive.tolist(), hits.instance.tolist(), is_hit.tolist())
    assert names == [f"{triangle}@{instance}" if hit else "miss" for triangle, instance, hit in both]
    bits = [[int(word, 16) for word in words[4:]] for words in lines if words != ["miss"]]
    values = np.stack([hits.t, hits.t_num, hits.t_denom], axis=1)[is_hit]
    np.testing.assert_array_equal(np.array(bits, np.uint32), values.view(np.uint32))


RAYS: Any = np.zeros(2, raypath.UNIT_RAY)
SCENE: Any = raypath.UnitScene(b"", 0)
ONES: Any = np.ones((2, 3), np.float32)

WRONG: list[tuple[Callable[[Any], Any], str]] = [
    (lambda unit: raypath.Unit(contexts=7), r"contexts: '7', expected 8 to 256"),
    (lambda unit: raypath.Unit(stack="deep"), r"stack: 'deep', expected 2, 4, 8"),  # type: ignore[arg-type]
    (lambda unit: raypath.Unit("half"), r"no datapath with format .* expected format fp32"),
    (lambda unit: raypath.Unit(config="contexts = 9\nstack = 3"), r"config:2: stack: '3'"),
    (lambda unit: raypath.Unit(instances=2), r"instances: '2', expected true or false"),  # type: ignore[arg-type]
    (
        lambda unit: unit.scene(TRIANGLE, instances=PLACES),
        r"instances: the unit has none, expected a unit with instances",
    ),
    (lambda unit: TWO_LEVELS.scene(TRIANGLE, instances=PLACES[:0]), r"0 instances, expected at least 1"),
    (lambda unit: TWO_LEVELS.scene(TRIANGLE, instances=0 * PLACES), r"instance 0: the matrix has no inverse"),
    (
        lambda unit: TWO_LEVELS.scene(TRIANGLE, instances=PLACES * [[[1], [1], [1e13]]]),
        r"instance 0: zz = 1.*, expected a number",
    ),
    (
        lambda unit: TWO_LEVELS.scene(TRIANGLE, instances=PLACES[0]),
        r"instances: found a float64 array of shape \(3, 4\)",
    ),
    (
        lambda unit: TWO_LEVELS.scene(TRIANGLE, instances=PLACES.astype(complex)),
        r"instances: found a complex128 array",
    ),
    (lambda unit: unit.scene([1]), r"triangles: item 0: found int, expected a raypath.Geometry"),
    (
        lambda unit: unit.scene([raypath.Geometry(TRIANGLE, opaque=False)]),
        r"geometries .* the unit has queries none, expected flags",
    ),
    (
        lambda unit: TWO_LEVELS.scene(TRIANGLE, instances=[raypath.Instance(PLACES[0], mask=256)]),
        r"instance 0: mask is 256, expected 0 to 255",
    ),
    (lambda unit: raypath.Geometry(), r"a geometry has triangles or boxes, expected one"),
    (
        lambda unit: unit.scene([raypath.Geometry(boxes=np.zeros((1, 2, 3), np.float32))]),
        r"procedural boxes: the unit has queries none, expected full",
    ),
    (lambda unit: unit.scene(ONES), r"triangles: found .* expected .* \(n, 3, 3\)"),
    (lambda unit: unit.scene(np.zeros((0, 3, 3), np.float32)), r"0 triangles, expected at least 1"),
    (lambda unit: unit.scene(np.full((1, 3, 3), np.nan, np.float32)), r"vertex 0 has x = NaN"),
    (lambda unit: unit.scene(np.zeros((1, 3, 3), np.float32), reach=-1), r"reach: found -1"),
    (lambda unit: SCENE.rays(ONES, ONES[:1]), r"directions: found shape \(1, 3\), expected \(2, 3\)"),
    (lambda unit: unit.trace(SCENE, ONES), r"rays: found .* expected .* raypath.UNIT_RAY"),
    (lambda unit: unit.trace(SCENE, changed("flags", 1024)), r"ray 1: flags is 1024, expected 0 to 1023"),
    (lambda unit: unit.simulate(SCENE, changed("cull_mask", 256)), r"ray 1: cull_mask is 256"),
    (lambda unit: raypath.Unit(address_width=31), r"address_width: '31', expected 32 to 64"),
    (
        lambda unit: unit.trace(SCENE, changed("base", 1)),
        r"ray 1: base is 1, expected 0 to 0 with addresses of 32 bits",
    ),
    (lambda unit: unit.simulate(SCENE, RAYS, latency=0), r"a system with 0 cycles of latency, expected 1 to 1000000"),
    (lambda unit: unit.simulate(SCENE, RAYS, bandwidth=0), r"0 bytes a cycle, expected 1 to 65536"),
    (lambda unit: unit.simulate(SCENE, RAYS, cache=100), r"the cache's size is 100, expected 512 bytes times"),
    (lambda unit: unit.trace(raypath.UnitScene(b"", 32, node="quantised"), RAYS), r"nodes quantised, expected wide4"),
    (
        lambda unit: unit.trace(raypath.UnitScene(b"", 32, queries="flags"), RAYS),
        r"unit with queries flags, found none",
    ),
    (lambda unit: raypath.UnitScene(b"", 32, queries="all"), r"'all', expected none, flags, full"),  # type: ignore[arg-type]
    (lambda unit: raypath.Geometry(TRIANGLE, opaque="no"), r"opaque is 'no', expected True or False"),  # type: ignore[arg-type]
    (lambda unit: unit.query(SCENE, RAYS), r"a query of a unit with queries none, expected full"),
    (
        lambda unit: TWO_LEVELS.scene(TRIANGLE, instances=[raypath.Instance(PLACES[0], scene=SCENE)]),
        r"instance 0 has a scene, expected none",
    ),
    (lambda unit: SCENE.rays(ONES, ONES, t_min=1e39), r"t_min is 1e39, expected a number of binary32"),
    (lambda unit: raypath.UnitScene(b"", 1 << 32), r"root is 4294967296, expected 0 to 4294967295"),
    (lambda unit: SCENE.rays(ONES, ONES, base=-1), r"base is -1, expected 0 to 4294967295"),
    (lambda unit: unit.query(SCENE, RAYS, flags=1 << 40), r"flags is 1099511627776, expected 0"),
    (lambda unit: raypath.UnitModel(unit).run(10, RAYS, np.array([1, 4096])), r"ray_ids: found 4096, expected .* 12"),
    (lambda unit: raypath.UnitModel(unit).step(RAYS), r"ray: found 2 rays, expected 1"),
    (lambda unit: raypath.UnitModel(unit).step(RAYS[0], 4096), r"id 4096, expected at most 12 bits"),
    (lambda unit: raypath.UnitModel(unit).step(response=(0, bytes(32))), r"a beat with the tag 0, expected that of"),
    (lambda unit: requesting(unit).step(response=(0, bytes(31))), r"a beat of 31 bytes, expected 32"),
]


def changed(field: str, value: int) -> Any:
    """Two rays, the second of which has this value in a field."""
    rays = RAYS.copy()
    rays[field][1] = value
    return rays


def requesting(unit: raypath.Unit) -> raypath.UnitModel:
    """A model whose context 0 waits for a block."""
    model = raypath.UnitModel(unit)
    rays = raypath.UnitScene(b"", 32).rays(ONES, ONES)
    model.step(rays[0])
    while model.outputs.request is None:
        model.skip(1000)
    assert model.outputs.request == (0, 0)
    model.step()
    return model


@pytest.mark.parametrize(("call", "message"), WRONG, ids=[message[:40] for _, message in WRONG])
def test_value_errors(unit: raypath.Unit, call: Callable[[Any], Any], message: str) -> None:
    """Each call raises ``ValueError`` with the message."""
    with pytest.raises(ValueError, match=message):
        call(unit)


def test_flags_that_do_not_exist() -> None:
    """A keyword that is not a flag, as Python's own functions."""
    with pytest.raises(TypeError, match=r"'context' is not a flag of a unit, expected contexts, stack, .*, control"):
        raypath.Unit(context=4)  # type: ignore[call-arg]
