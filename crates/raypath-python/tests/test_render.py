"""Rendering and tracing against a brute-force oracle in float64, and the documented timing."""

from typing import Any

import numpy as np
import pytest
from helpers import Mesh, f32, nearest

import raypath


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    """Triangles at random places and angles, none of which shares a vertex with another."""
    random = np.random.default_rng(3)
    vertices = random.uniform(-1, 1, (100, 1, 3)) + random.uniform(-0.3, 0.3, (100, 3, 3))
    return vertices.reshape(-1, 3).astype(np.float32), np.arange(300, dtype=np.uint32).reshape(-1, 3)


ONE = raypath.Scene(f32([[-1, -1, 0], [1, -1, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))


def test_trace(mesh: Mesh) -> None:
    """The closest hit of each ray, except where rounding decides."""
    random = np.random.default_rng(4)
    origins = random.uniform(-4, 4, (2000, 3)).astype(np.float32)
    directions = (random.uniform(-1, 1, (2000, 3)) - origins).astype(np.float32)
    found = raypath.trace(raypath.Scene(*mesh), raypath.rays(origins, directions))
    triangle, t, doubt = nearest(mesh, origins, directions)
    clear = doubt > 1e-4
    assert clear.mean() > 0.8
    assert 0.2 < (triangle >= 0).mean() < 0.9
    np.testing.assert_array_equal(found.triangle[clear], triangle[clear])
    np.testing.assert_allclose(found.t[clear], t[clear], rtol=1e-3)
    assert not found.back_face.any()
    assert found.timing is None
    assert len(found) == 2000


def test_two_sided() -> None:
    """A triangle is hit from behind only if both sides are."""
    rays = raypath.rays(f32([[0, 0, 4], [0, 0, -4]]), f32([[0, 0, -1], [0, 0, 1]]))
    assert raypath.trace(ONE, rays).triangle.tolist() == [0, -1]
    found = raypath.trace(ONE, rays, two_sided=True)
    assert (found.triangle.tolist(), found.back_face.tolist(), found.t.tolist()) == ([0, 0], [False, True], [4, 4])


def test_picture(mesh: Mesh) -> None:
    """The hits of a picture are those of its rays, traced one by one; each pixel that differs from the sky is hit."""
    width, height = 48, 32

    def seen(mesh: Mesh) -> raypath.Rendering:
        return raypath.render(raypath.Scene(*mesh), eye=(0, 0, 5), fov=40, size=(width, height))

    picture = seen(mesh)
    half = np.tan(np.radians(20))
    x = (np.arange(width) + 0.5 - width / 2) * 2 * half / height
    y = (height / 2 - np.arange(height) - 0.5) * 2 * half / height
    directions = np.stack([*np.meshgrid(x, y), -np.ones((height, width))], axis=-1).reshape(-1, 3)
    directions = (directions / np.linalg.norm(directions, axis=1, keepdims=True)).astype(np.float32)
    origins = np.tile(f32([0, 0, 5]), (len(directions), 1))
    triangle, _, doubt = nearest(mesh, origins, directions)
    hits = picture.rays[0]["hits"]
    assert picture.rays[0]["rays"] == width * height
    assert abs(hits - (triangle >= 0).sum()) <= (doubt < 1e-4).sum()
    nothing = raypath.Scene(f32([[0, 0, 0], [1e-6, 0, 0], [0, 1e-6, 0]]), mesh[1][:1])
    sky = raypath.render(nothing, eye=(0, 0, 5), fov=40, size=(width, height))
    assert picture.image.shape == (height, width, 3)
    is_hit = (picture.image != sky.image).any(axis=2).ravel()
    clear = doubt > 1e-4
    np.testing.assert_array_equal(is_hit[clear], triangle[clear] >= 0)
    assert picture.jobs.shape == (height, width)
    assert picture.jobs.sum() == sum(picture.rays[0][kind] for kind in ("quadbox", "triangle", "behind"))
    assert picture._repr_png_().startswith(b"\x89PNG\r\n")


def test_secondary_rays(mesh: Mesh) -> None:
    """A shadow ray starts at hits that face the sun, N occlusion rays at each; a seed gives the same picture again."""
    scene = raypath.Scene(*mesh)
    pictures = [raypath.render(scene, size=(20, 20), shadows=True, ao=3, seed=5) for _ in range(2)]
    rays = {row["kind"]: row for row in pictures[0].rays}
    assert 20 < rays["shadow"]["rays"] < rays["primary"]["hits"]
    assert rays["occlusion"]["rays"] == 3 * rays["primary"]["hits"]
    np.testing.assert_array_equal(pictures[0].image, pictures[1].image)


def test_timing_of_single_rays() -> None:
    """One ray in flight: a node, a leaf of one triangle, each a fetch and a job that takes latency and one cycle."""
    rays = raypath.rays(np.tile(f32([0, 0, 4]), (10, 1)), np.tile(f32([0, 0, -1]), (10, 1)))
    for preset, latency in [("paper", 12), ("fast", 46)]:
        options: Any = {"rays_in_flight": 1, "memory_latency": 50, "timed": 10}
        found = raypath.trace(ONE, rays, datapath=raypath.Datapath(preset), **options)
        assert found.timing is not None
        assert (found.timing["agents"], found.timing["quadbox"], found.timing["triangle"]) == (10, 10, 10)
        assert found.timing["cycles"] == 10 * 2 * (50 + latency + 1)
        assert found.timing["mean_latency"] == latency


def test_timing_of_many_rays(mesh: Mesh) -> None:
    """With many agents, throughput approaches a job a cycle, and every cycle has one use."""
    scene = raypath.Scene(*mesh)
    few, many = (raypath.render(scene, size=(64, 64), rays_in_flight=n, timed=5000).timing for n in (1, 1024))
    assert few is not None
    assert many is not None
    assert few["jobs"] == many["jobs"]
    assert few["jobs_per_cycle"] < 0.02
    assert many["jobs_per_cycle"] > 0.9
    starved = many["starved_memory"] + many["starved_outcomes"] + many["starved_both"]
    assert many["accepted"] + many["refused"] + starved == many["cycles"]
