"""Arrays of jobs against NumPy in float64, for jobs whose answer does not depend on rounding."""

import numpy as np
import pytest
from helpers import f32
from numpy.typing import NDArray

import raypath

JOBS = 20_000
Points = NDArray[np.float32]


@pytest.fixture
def random() -> np.random.Generator:
    """Random numbers, the same in each run."""
    return np.random.default_rng(18)


def random_rays(random: np.random.Generator, count: int) -> tuple[Points, Points, NDArray[np.void]]:
    """Origins, directions of any length, and their rays. The rays point at the unit cube."""
    origins = random.uniform(-3, 3, (count, 3)).astype(np.float32)
    directions = (random.uniform(-1, 1, (count, 3)) - origins).astype(np.float32)
    return origins, directions, raypath.rays(origins, directions)


def test_rays(random: np.random.Generator) -> None:
    """The derived fields of a ray."""
    origins, directions, rays = random_rays(random, JOBS)
    extents = random.uniform(0, 9, JOBS).astype(np.float32)
    np.testing.assert_array_equal(raypath.rays(origins, directions, extents)["extent"], extents)
    np.testing.assert_array_equal(raypath.rays(origins, directions, 2.5)["extent"], np.float32(2.5))
    np.testing.assert_array_equal(rays["extent"], np.inf)
    np.testing.assert_array_equal(rays["origin"], origins)
    np.testing.assert_array_equal(rays["direction"], directions)
    np.testing.assert_array_equal(rays["inverse"], np.float32(1) / directions)
    kz = np.argmax(np.abs(directions), axis=1)
    along = np.take_along_axis(directions, kz[:, None], axis=1)[:, 0]
    turned = along < 0
    np.testing.assert_array_equal(rays["kz"], kz)
    np.testing.assert_array_equal(rays["kx"], np.where(turned, (kz + 2) % 3, (kz + 1) % 3))
    np.testing.assert_array_equal(rays["ky"], np.where(turned, (kz + 1) % 3, (kz + 2) % 3))
    across = [np.take_along_axis(directions, rays[k][:, None].astype(np.int64), axis=1)[:, 0] for k in ("kx", "ky")]
    expected = np.stack([across[0] / along, across[1] / along, np.float32(1) / along], axis=1)
    np.testing.assert_array_equal(rays["shear"], expected)


def test_quadbox(datapath: raypath.Datapath, random: np.random.Generator) -> None:
    """The slab method."""
    origins, directions, _ = random_rays(random, JOBS)
    extents = random.uniform(0, 2, JOBS).astype(np.float32)
    boxes = np.sort(random.uniform(-1.5, 1.5, (JOBS, 4, 2, 3)), axis=2).astype(np.float32)
    hits = datapath.quadbox(raypath.rays(origins, directions, extents), boxes)

    planes = (boxes.astype(np.float64) - origins[:, None, None]) / directions[:, None, None]
    near, far = planes.min(axis=2).max(axis=2).clip(min=0), planes.max(axis=2).min(axis=2)
    far = np.minimum(far, extents[:, None])
    is_hit = near <= far
    order = np.argsort(np.where(is_hit, near, np.inf), axis=1, kind="stable")
    distances = np.take_along_axis(np.where(is_hit, near, np.inf), order, axis=1)
    # A rounding error decides if near and far, or two distances that are not 0, are closer than this.
    with np.errstate(invalid="ignore"):
        gaps = np.diff(distances, axis=1)
    is_close = (np.abs(near - far) < 1e-5).any(axis=1) | ((gaps > 0) & (gaps < 1e-5)).any(axis=1)
    clear = ~is_close
    assert clear.mean() > 0.99
    assert 0.1 < is_hit.mean() < 0.9
    np.testing.assert_array_equal(hits.is_intersect[clear], np.take_along_axis(is_hit, order, axis=1)[clear])
    np.testing.assert_array_equal(hits.box_index[clear], order[clear])
    np.testing.assert_allclose(hits.tmin[clear], distances[clear], rtol=1e-5, atol=1e-6)


def test_triangle(datapath: raypath.Datapath, random: np.random.Generator) -> None:
    """The test of Möller and Trumbore, for front faces."""
    origins, directions, rays = random_rays(random, JOBS)
    triangles = random.uniform(-1, 1, (JOBS, 3, 3)).astype(np.float32)
    hits = datapath.triangle(rays, triangles)

    a, b, c = triangles.astype(np.float64).swapaxes(0, 1)
    direction, offset = directions.astype(np.float64), origins.astype(np.float64) - a
    normal, across = np.cross(b - a, c - a), np.cross(offset, direction)
    determinant = -np.einsum("ij,ij->i", direction, normal)
    u = np.einsum("ij,ij->i", c - a, across) / determinant
    v = -np.einsum("ij,ij->i", b - a, across) / determinant
    t = np.einsum("ij,ij->i", offset, normal) / determinant
    margin = np.minimum.reduce([u, v, 1 - u - v, t])
    # Vertices run counter-clockwise as seen from where the determinant is above 0.
    is_hit = (margin > 0) & (determinant > 0)
    clear = (np.abs(margin) > 1e-3) & (np.abs(determinant) > 1e-2)
    assert clear.mean() > 0.9
    assert 0.03 < is_hit.mean() < 0.5
    np.testing.assert_array_equal(hits.triangle_hit[clear], is_hit[clear])
    chosen = clear & is_hit
    np.testing.assert_allclose(hits.t_num[chosen] / hits.t_denom[chosen], t[chosen], rtol=1e-3)


@pytest.mark.parametrize("dimensions", [1, 15, 16, 17, 128, 1000])
def test_distances(datapath: raypath.Datapath, random: np.random.Generator, dimensions: int) -> None:
    """Sums in float64, within the error of a sum in float32 in any order."""
    a, b = random.normal(size=(2, 50, dimensions)).astype(np.float32)
    wide_a, wide_b = a.astype(np.float64), b.astype(np.float64)
    # Each of the k terms has at most k + 2 roundings (Higham, Accuracy and Stability of Numerical Algorithms, 3.1).
    unit = (dimensions + 2) * 2.0**-24
    exact = ((wide_a - wide_b) ** 2).sum(axis=1)
    assert (np.abs(datapath.euclidean(a, b) - exact) <= 1.01 * unit * exact).all()
    dot, norm = datapath.angular(a, b)
    assert (np.abs(dot - (wide_a * wide_b).sum(axis=1)) <= 1.01 * unit * np.abs(wide_a * wide_b).sum(axis=1)).all()
    exact = (wide_b**2).sum(axis=1)
    assert (np.abs(norm - exact) <= 1.01 * unit * exact).all()


@pytest.mark.parametrize(("preset", "digits"), [("search", 1e-6), ("half", 2e-3)])
def test_other_datapaths(random: np.random.Generator, preset: str, digits: float) -> None:
    """Other lanes, and another format, whose numbers are rounded to it and back."""
    datapath = raypath.Datapath(preset)
    rays = raypath.rays(f32([[0.125, 0.25, -4]]), f32([[0, 0, 0.3]]))
    hits = datapath.quadbox(rays, f32([[[[-1, -1, z], [1, 1, z + 1]] for z in (3, -9, 1, 2)]]))
    assert hits.box_index.tolist() == [[2, 3, 0, 1]]
    assert hits.is_intersect.tolist() == [[True, True, True, False]]
    np.testing.assert_allclose(hits.tmin[0, :3], np.array([5, 6, 7]) / 0.3, rtol=digits)
    if datapath.lanes:
        a, b = random.normal(size=(2, 10, 100)).astype(np.float32)
        np.testing.assert_allclose(datapath.euclidean(a, b), ((a - b) ** 2).sum(axis=1), rtol=1e-5)


def test_no_jobs(datapath: raypath.Datapath) -> None:
    """Arrays of no jobs have no outcomes."""
    empty = np.zeros((0, 3), np.float32)
    rays = raypath.rays(empty, empty)
    assert datapath.quadbox(rays, np.zeros((0, 4, 2, 3), np.float32)).tmin.shape == (0, 4)
    assert datapath.triangle(rays, np.zeros((0, 3, 3), np.float32)).t_num.shape == (0,)
    assert datapath.euclidean(empty, empty).shape == (0,)
    assert [part.shape for part in datapath.angular(empty, empty)] == [(0,), (0,)]


def test_added_operation() -> None:
    """An added operation by its ports: the discriminant of a ray and a sphere."""
    datapath = raypath.Datapath(with_=["sphere"])
    assert datapath.operations[-1] == "sphere"
    inputs = [
        port["name"] for port in datapath.ports() if (port["operation"], port["direction"]) == ("sphere", "input")
    ]
    values = dict.fromkeys(inputs, 0) | {
        "ray_origin_z": -5.0,
        "ray_dir_z": 1.0,
        "sphere_radius": f32([1, 2, 0.5]),
    }
    values |= {"sphere_centre_x": f32([0, 0, 1]), "ray_extent": np.inf}
    found = datapath.run("sphere", **values)
    assert found["sphere_hit"].tolist() == [True, True, False]
    job = raypath.Job.words(datapath, "sphere", **(values | {"sphere_radius": 2.0, "sphere_centre_x": 0.0}))
    pipeline = raypath.Pipeline(datapath)
    assert pipeline.offer(job)
    pipeline.skip(100)
    outcome = pipeline.step()
    assert outcome is not None
    assert outcome.values == {port: array[1] for port, array in found.items()}
