"""The traversal unit: hits against a brute-force oracle in float64, cycle-exact against functional model."""

from collections import deque
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest
from helpers import Mesh, f32, nearest
from numpy.typing import NDArray

import raypath

Float32 = NDArray[np.float32]


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
    for memory, cull, is_back in [(scene, "back", False), (inside_out, "front", True)]:
        hits = unit.trace(memory, memory.rays(origins, directions, cull=cull))  # type: ignore[arg-type]
        np.testing.assert_array_equal(hits.status[clear], hit[clear])
        chosen = clear & hit
        np.testing.assert_array_equal(hits.triangle[chosen], triangle[chosen])
        np.testing.assert_allclose(hits.t[chosen], t[chosen], rtol=1e-3)
        np.testing.assert_array_equal(hits.t[chosen], hits.t_num[chosen] / hits.t_denom[chosen])
        assert (hits.back_face[chosen] == is_back).all()
        corners = mesh[0][mesh[1]].astype(np.float64)[triangle[chosen]][:, :: -1 if is_back else 1]
        weights = np.stack([hits.u, hits.v, 1 - hits.u - hits.v], axis=1)[chosen]
        points = (origins + t[:, None] * directions)[chosen]
        np.testing.assert_allclose((weights[:, :, None] * corners).sum(1), points, atol=1e-3)
        assert (hits.t_denom[chosen] < 0).all() == is_back
        assert not hits.t[hits.status == 0].any()
        assert len(hits) == 2000


def test_fields_of_rays() -> None:
    """Range, faces and any hit, set for single rays, and what the unit refuses. Weights are a feature."""
    unit = raypath.Unit()
    scene = unit.scene(f32([[[-1, -1, z], [1, -1, z], [0, 1, z]] for z in (0, 2)]))
    rays = scene.rays(np.tile(f32([0, 0, 4]), (7, 1)), np.tile(f32([0, 0, -2]), (7, 1)), t_max=10)
    rays["t_min"][1] = 1.5
    rays["t_max"][2] = 0.5
    rays["cull"][3] = 2
    rays["any_hit"][4] = 1
    rays["direction"][5] = 0
    rays["t_min"][6] = -1
    hits = unit.trace(scene, rays)
    assert hits.status.tolist() == [1, 1, 0, 0, 1, 2, 2]
    assert hits.t.tolist()[:4] == [1, 2, 0, 0]
    assert hits.triangle.tolist()[:2] == [1, 0]
    assert not hits.u.any()
    small = raypath.Unit(node="quantised")
    assert small.parameters["node"] == "quantised"
    their_scene = small.scene(f32([[[-1, -1, z], [1, -1, z], [0, 1, z]] for z in (0, 2)]))
    rays_there = rays.copy()
    rays_there["root"] = their_scene.root
    assert small.trace(their_scene, rays_there).t.tolist() == hits.t.tolist()
    beyond = raypath.UnitScene(b"", scene.root)
    assert unit.trace(beyond, rays[:1]).status.tolist() == [3]
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
        model.reset()
    assert model.counts["cycles"] == 0
    assert model.outputs.hit is None


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


def test_parameters(unit: raypath.Unit) -> None:
    """Keywords and TOML set the same parameters."""
    numbers_of = {"contexts": 8, "stack": 2, "memory_width": 256, "id_width": 12, "divider_latency": 11}
    expected = {**numbers_of, "node": "wide4"}
    assert unit.parameters == expected
    lines = ["contexts = 8", "stack = 2", "memory-width = 256", "id-width = 12", "barycentrics = true"]
    toml = raypath.Unit(config='preset = "compact"\n' + "\n".join(lines))
    assert (toml.parameters, repr(toml)) == (expected, repr(unit))


def test_generate(unit: raypath.Unit, tmp_path: Path) -> None:
    """The files of ``raypath generate --unit`` with the parameters of the unit."""
    assert unit.generate(tmp_path) == sum(path.is_file() for path in tmp_path.rglob("*"))
    text = (tmp_path / "rtl/raypath_unit.sv").read_text()
    assert "[255:0] mem_rsp_data_i" in text
    assert (tmp_path / "raypath_unit_axi.f").exists()
    with pytest.raises(OSError, match="/dev/null"):
        unit.generate("/dev/null/x")


RAYS: Any = np.zeros(2, raypath.UNIT_RAY)
SCENE: Any = raypath.UnitScene(b"", 0)
ONES: Any = np.ones((2, 3), np.float32)

WRONG: list[tuple[Callable[[Any], Any], str]] = [
    (lambda unit: raypath.Unit(contexts=7), r"contexts: '7', expected 8 to 256"),
    (lambda unit: raypath.Unit(stack="deep"), r"stack: 'deep', expected 2, 4, 8"),  # type: ignore[arg-type]
    (lambda unit: raypath.Unit("half"), r"no datapath with format .* expected format fp32"),
    (lambda unit: raypath.Unit(config="contexts = 9\nstack = 3"), r"config:2: stack: '3'"),
    (lambda unit: unit.scene(ONES), r"triangles: found .* expected .* \(n, 3, 3\)"),
    (lambda unit: unit.scene(np.zeros((0, 3, 3), np.float32)), r"0 triangles, expected at least 1"),
    (lambda unit: unit.scene(np.full((1, 3, 3), np.nan, np.float32)), r"vertex 0 has x = NaN"),
    (lambda unit: unit.scene(np.zeros((1, 3, 3), np.float32), reach=-1), r"reach: found -1"),
    (lambda unit: SCENE.rays(ONES, ONES[:1]), r"directions: found shape \(1, 3\), expected \(2, 3\)"),
    (lambda unit: SCENE.rays(ONES, ONES, cull="side"), r"cull: found 'side', expected none, back"),
    (lambda unit: unit.trace(SCENE, ONES), r"rays: found .* expected .* raypath.UNIT_RAY"),
    (lambda unit: unit.trace(SCENE, culled(4)), r"ray 1: cull is 4, expected 0 to 3"),
    (lambda unit: unit.simulate(SCENE, culled(5)), r"ray 1: cull is 5"),
    (lambda unit: unit.simulate(SCENE, RAYS, latency=0), r"latency of 0 cycles, expected 1 to 1000000"),
    (lambda unit: unit.simulate(SCENE, RAYS, bandwidth=0), r"0 bytes a cycle, expected 1 to 65536"),
    (lambda unit: unit.simulate(SCENE, RAYS, cache=100), r"a cache of 100 bytes"),
    (lambda unit: raypath.UnitModel(unit).step(RAYS), r"ray: found 2 rays, expected 1"),
    (lambda unit: raypath.UnitModel(unit).step(RAYS[0], 4096), r"id 4096, expected at most 12 bits"),
    (lambda unit: raypath.UnitModel(unit).step(response=(0, bytes(32))), r"a beat with the tag 0, expected that of"),
    (lambda unit: requesting(unit).step(response=(0, bytes(31))), r"a beat of 31 bytes, expected 32"),
]


def culled(cull: int) -> Any:
    """Two rays, the second of which names faces in this way."""
    rays = RAYS.copy()
    rays["cull"][1] = cull
    return rays


def requesting(unit: raypath.Unit) -> raypath.UnitModel:
    """A model whose context 0 waits for a block."""
    model = raypath.UnitModel(unit)
    rays = raypath.UnitScene(b"", 32).rays(ONES, ONES)
    model.step(rays[0])
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
