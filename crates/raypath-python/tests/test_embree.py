"""The traversal unit against Embree: exact arithmetic decides each ray that the two answer differently.

embreex has single rays and the flag `robust`, with which Embree tests edges with a tolerance; these scenes have it. It
has no instances: Embree gets placed triangles, rounded once."""

import gzip
import itertools
import math
import os
import subprocess
import sys
from collections import Counter
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import raypath

EMBREE = pytest.importorskip("embreex.rtcore_scene", reason="embreex, of requirements.txt, cannot be imported")
EMBREE_MESH = pytest.importorskip("embreex.mesh_construction")
RAYS = 1000 * int(os.environ.get("RAYPATH_EMBREE_TIMES", "1"))
U = 2.0**-24
FILES = {"suzanne": "suzanne.ply", "teapot": "teapot.obj", "truck": "truck.obj", "built-in": ""}
MADE = ["grid", "fans", "needles", "coincident", "coplanar", "degenerate", "mirrored", "non-uniform"]
SHEARED = [[9, 1, 0, 0], [0, 0.2, 0, 3], [1, 0, 1.3, 0]]
PLACES = {
    "mirrored": [[[-1, 0, 0, 3], [0, 1, 0, 0], [0, 0, 1, 0]], [[0, 3, 0, 0], [1, 0, 0, 2], [0, 0, -1 / 3, 1]]],
    "non-uniform": [[[0.1, 0.7, 0, -2], [0, 5, 1, 0], [0.3, 0, 2, 1]], SHEARED, SHEARED],
}
exact, whole = np.frompyfunc(lambda x: Fraction(float(x)), 1, 1), np.frompyfunc(int, 1, 1)


@pytest.mark.parametrize("name", [*FILES, *MADE])
def test_differences(name: str, root: Path, tmp_path: Path) -> None:
    """The unit is never further from exact geometry than the bounds, and hits the first of equal triangles."""
    case = Case(mesh(root, tmp_path, FILES[name]) if name in FILES else made(name), PLACES.get(name))
    origins, directions, _ = aimed(case.placed, RAYS)
    firsts: dict[bytes, int] = {}
    first = np.array([firsts.setdefault(bytes(triangle), index) for index, triangle in enumerate(case.placed)])
    for edges in ("shared", "once"):
        index, t = case.unit(origins, directions, edges)
        np.testing.assert_array_equal(index, np.where(index < 0, -1, first[index]))
        theirs = case.embree(origins, directions)
        classes, wrong = case.differences(origins, directions, (index, t), theirs)
        print(f"\n{name}, edges {edges}: {RAYS} rays, {(index >= 0).sum()} hit, {dict(classes)}")
        # With edges shared, see test_seen_edge_on.
        assert not [line for line in wrong if edges == "once" or not line.startswith("thin")], "\n".join(wrong[:5])


@pytest.mark.parametrize("edges", [pytest.param("shared", marks=pytest.mark.xfail(strict=True)), "once"])
def test_seen_edge_on(edges: Any) -> None:
    """The ray is in the plane of the triangle, and passes it at 9. Two edge functions are differences of products that
    are equal after rounding, the third is not 0, and edges shared makes that a hit if no box keeps the ray away."""
    leaf = np.array([[3, 5, 1], [7, -6, -4], [-1, 4, 2]], np.float32).tobytes() + bytes(92)
    scene = raypath.UnitScene(leaf, 1)
    rays = scene.rays(np.array([[-10, 1, 4]], np.float32), np.array([[0, 3, 1]], np.float32))
    assert raypath.Unit("compact", edges=edges).trace(scene, rays).status == [raypath.UnitStatus.MISS]


@pytest.mark.parametrize("name", ["grid", "non-uniform"])
def test_control(name: str) -> None:
    """Wrong distances, wrong triangles and misses are found, and are not blamed on the unit if they are Embree's."""
    case = Case(made(name), PLACES.get(name))
    origins, directions, is_interior = aimed(case.placed, 400)
    index, t = case.unit(origins, directions)
    near = np.abs(origins).max(axis=1) < 2 * np.abs(case.placed).max()
    chosen = near & is_interior & (index == case.embree(origins, directions)[0])
    rays, index, t = (origins[chosen], directions[chosen]), index[chosen], t[chosen]
    for bad in (
        (index, t * 1.01),
        ((index + len(case.placed) // 7) % len(case.placed), t),
        (index * 0 - 1, t + np.inf),
    ):
        assert len(case.differences(*rays, bad, (index, t))[1]) > 0.9 * chosen.sum() > 20
        assert not case.differences(*rays, (index, t), bad)[1]


class Case:
    """Triangles, once or at places. Answers are arrays: instance * triangles + primitive or -1, and the distance."""

    def __init__(self, triangles: Any, places: Any) -> None:
        self.triangles, self.is_placed = triangles, places is not None
        self.places = np.array(places if self.is_placed else [np.eye(3, 4)], np.float64)
        corners = np.einsum("mij,nkj->mnki", self.places[..., :3], triangles) + self.places[:, None, None, :, 3]
        self.placed = corners.astype(np.float32).reshape(-1, 3, 3)
        _, vertices = np.unique((triangles + np.float32(0)).view("V12"), return_inverse=True)
        self.vertices = vertices.reshape(-1, 3)

    def unit(self, origins: Any, directions: Any, edges: Any = "shared") -> tuple[Any, Any]:
        unit, reach = raypath.Unit("compact", instances=self.is_placed, edges=edges), 2 * np.abs(origins).max() + 99
        more: dict[str, Any] = {"instances": self.places, "reach": float(reach)} if self.is_placed else {}
        scene = unit.scene(self.triangles, **more)
        hits = unit.trace(scene, scene.rays(origins, directions))
        instance = hits.instance.astype(np.int64) if self.is_placed else 0
        return np.where(hits.status == 1, instance * len(self.triangles) + hits.primitive, -1), hits.t

    def embree(self, origins: Any, directions: Any) -> tuple[Any, Any]:
        scene = EMBREE.EmbreeScene(robust=True)
        EMBREE_MESH.TriangleMesh(scene, self.placed)
        found = scene.run(origins, directions, output=True)
        return found["primID"], np.where(found["primID"] < 0, np.inf, found["tfar"])

    def differences(self, origins: Any, directions: Any, ours: Any, theirs: Any) -> tuple[Counter[str], list[str]]:
        """The number of differences by class, and a line for each wrong answer of the unit."""
        classes, wrong = Counter[str](), []
        is_same = (ours[0] == theirs[0]) & np.isclose(ours[1], theirs[1], rtol=16 * U, atol=0)
        for ray in np.flatnonzero(~is_same).tolist():
            answers = [(int(index[ray]), float(t[ray])) for index, t in (ours, theirs)]
            views = [self.view(origins[ray], directions[ray], index) if index >= 0 else None for index, _ in answers]
            reason, other = (disproof(view, views, t) for view, (_, t) in zip(views, answers))
            if reason:
                numbers = [[float(x).hex() for x in vector[ray]] for vector in (origins, directions)]
                wrong.append(f"{reason}, ray {ray}: {numbers}, ours and Embree's: {answers}")
            # Of two answers within the bounds that differ, the nearer is thin, or its border is within the bounds.
            seen = sorted((view.t[0], view.tau[0], view.thin[0]) for view in views if view)
            is_equal = len(seen) == 2 and seen[1][0] - seen[0][0] <= seen[0][1] + seen[1][1]
            within = "equal distances" if is_equal else "thin" if seen[0][2] else "border"
            classes[f"unit: {reason[:8]}" if reason else f"Embree: {other[:8]}" if other else within] += 1
        return classes, wrong

    def view(self, origin: Any, direction: Any, index: int) -> Any:
        """A triangle, and those that share vertices with it, as the exact ray sees them in the space of the object:
        integers in units of 1 / scale, then their quotients. Bounds are those of docs/reference/error-bounds.md."""
        place, face = divmod(index, len(self.triangles))
        near = np.flatnonzero((self.vertices[..., None] == self.vertices[face]).any(axis=(1, 2)))
        faces = [face, *near[near != face]]
        x, y, z, shift = exact(self.places[place]).T
        turn = np.stack([np.cross(y, z), np.cross(z, x), np.cross(x, y)])
        turn = turn / (x @ turn[0])
        o, d = turn @ (exact(origin) - shift), turn @ exact(direction)
        scale = math.lcm(2**149, *(number.denominator for number in (*o, *d)))
        r, d = whole(exact(self.triangles[faces]) * scale) - whole(o * scale), whole(d * scale)
        k = max(range(3), key=lambda axis: abs(d[axis]))
        across = r[..., [k - 2, k - 1]] * d[k] - r[..., [k]] * d[[k - 2, k - 1]]
        b, c = np.roll(across, -1, axis=1), np.roll(across, -2, axis=1)
        weights = b[..., 0] * c[..., 1] - b[..., 1] * c[..., 0]
        area, sums = weights.sum(axis=1), (weights * r[..., k]).sum(axis=1)
        side = np.sign(area).astype(int)
        depth, p, size = wide(r[..., k] / d[k]), wide(across / (d[k] * scale)), wide(abs(r).max(axis=(1, 2)) / scale)
        t = np.array([s / (a * d[k]) if a else z.mean() for s, a, z in zip(sums, area, depth)])
        # The transform rounds each product five times, and the vertices of Embree are rounded once, with room for both.
        far = np.abs(origin) + np.abs(depth).max() * np.abs(direction) + 2 * np.abs(wide(shift))
        e = 7 * U * self.is_placed * np.abs(wide(turn)) @ far
        rho = 12 * U * size + 2 * e.sum()
        double, errors = np.maximum(np.abs(wide(area / (d[k] * scale) ** 2)), 1e-200), 24 * U * size**2
        share = np.minimum(11 * errors / np.maximum(double - 12 * errors, 1e-200), 1)
        tilt = np.abs(np.cross(*wide(np.diff(self.triangles[faces], axis=1)).swapaxes(0, 1))) @ e / double
        tau = share * abs(depth - t[:, None]).max(axis=1) + 9 * U * abs(depth).max(axis=1) + tilt / abs(d[k] / scale)
        edge = np.roll(p, -1, axis=1) - p
        squares = np.maximum((edge**2).sum(axis=2), 1e-200)
        gaps = np.linalg.norm(p - np.clip((p * edge).sum(axis=2) / squares, -1, 0)[..., None] * edge, axis=2)
        is_inside, longest = (weights * side[:, None] >= 0).all(axis=1) & (side != 0), np.sqrt(squares.max(axis=1))
        thin = double <= 4 * rho * longest + 4 * rho**2 + 3 * U * (longest + 2 * rho) ** 2
        vertices = self.vertices[faces].tolist()
        return SimpleNamespace(
            t=t, tau=tau, gaps=gaps, rho=rho, thin=thin, side=side, inside=is_inside, vertices=vertices
        )


def disproof(own: Any, views: Any, t: float) -> str:
    """Why this answer is further from exact geometry than the bounds, if it is."""
    if own and not own.inside[0] and own.gaps[0].min() > 2 * own.rho[0]:
        return f"{'thin' if own.thin[0] else 'beside'}: {own.gaps[0].min()} from the ray, bound {2 * own.rho[0]}"
    if own and abs(own.t[0] - t) > own.tau[0]:
        return f"distance: {t}, exactly {own.t[0]}, bound {own.tau[0]}"
    for view, side in itertools.product(filter(None, views), (-1, 1)):
        # Section 5: faces that cover the ray, together or one alone, with a rim that is further away than rho.
        front = (view.side == side) & ~view.thin & (view.t > view.tau) & (view.t + view.tau < t)
        covers = np.flatnonzero(front & view.inside)
        for faces in [np.flatnonzero(front), *covers[:, None]] if len(covers) else []:
            edges = [(view.vertices[face][j], view.vertices[face][j - 2]) for face in faces for j in range(3)]
            rim = [edges.count(edge) != edges.count(edge[::-1]) for edge in edges]
            if view.gaps[faces].reshape(-1)[rim].min(initial=np.inf) > view.rho[faces].max():
                return f"through: a surface at {view.t[covers].min()} is missed"
    return ""


def wide(numbers: Any) -> Any:
    return numbers.astype(np.float64)


def mesh(root: Path, folder: Path, name: str) -> Any:
    """The triangles of a file, or of the built-in scene, from the bytes that the command writes."""
    if name:
        packed = root / f"crates/raypath-render/tests/data/{name}.gz"
        (folder / name).write_bytes(gzip.decompress(packed.read_bytes()))
    subprocess.run([sys.executable, "-m", "raypath", "scene", *name.split(), "--out", "scene"], cwd=folder, check=True)
    blocks, triangles = np.fromfile(folder / "scene", np.uint32).reshape(-1, 32), []
    words = np.array([32])
    while len(words):
        for k in range(8):
            leaf = blocks[words[(words % 64 > k) & (words % 64 <= 8)] // 128 + k // 3]
            triangles.append(np.column_stack([leaf[:, 28 + k % 3], leaf[:, 9 * (k % 3) :][:, :9]]))
        words = blocks[words[words % 64 == 32] // 128, 24:28].reshape(-1)
    found = np.concatenate(triangles)
    return found[np.argsort(found[:, 0]), 1:].view(np.float32).reshape(-1, 3, 3)


def made(name: str) -> Any:
    random = np.random.default_rng(7)
    if name in ("grid", *PLACES):
        points = np.stack([*np.mgrid[:20.0, :20.0], random.uniform(0, 2, (20, 20))], axis=2)
        a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
        return np.array([[a, b, c], [a, c, d]], np.float32).transpose(0, 2, 3, 1, 4).reshape(-1, 3, 3)
    if name in ("fans", "needles"):  # around a centre, or from it to points of a small arc
        angles = np.arange(9) * (np.pi / 4 if name == "fans" else 2.0**-10) % (2 * np.pi)
        turns, _ = np.linalg.qr(random.normal(size=(60, 3, 3)))
        around = np.stack([np.cos(angles), np.sin(angles), np.cos(3 * angles) / 3], axis=1) @ turns
        centres = random.uniform(-4, 4, (60, 1, 3))
        rim = (around + centres).astype(np.float32)
        return np.stack([0 * rim[:, 1:] + centres.astype(np.float32), rim[:, :-1], rim[:, 1:]], axis=2).reshape(
            -1, 3, 3
        )
    triangles = random.integers(-8, 9, (200, 3, 3)).astype(np.float32)
    if name == "coincident":
        triangles = triangles[random.integers(0, 60, 200)]
        triangles[::5] = triangles[::5, ::-1]
    elif name == "coplanar":
        triangles[:100, :, 2], triangles[100:, :, 2] = 9, 24 - triangles[100:, :, :2].sum(axis=2)
    else:
        triangles[::4, 2], triangles[1::9, 1] = triangles[::4, :2].mean(axis=1), triangles[1::9, 0]
    return triangles


def aimed(triangles: Any, count: int) -> tuple[Any, Any, Any]:
    """Rays at a quarter of interiors, half of edges and a quarter of vertices, from 2^-6 to 2^10 times the size of the
    scene away, a third of them along small integers; whether they are at interiors."""
    random = np.random.default_rng(11)
    corners = triangles[random.integers(0, len(triangles), count)].astype(np.float64)
    kind = np.arange(count) % 4
    weights = random.dirichlet([1, 1, 1], count) * np.array([[1, 1, 1], [1, 1, 0], [1, 1, 0], [1, 0, 0]])[kind]
    weights = random.permuted(weights / weights.sum(axis=1, keepdims=True), axis=1)
    points = (weights[..., None] * corners).sum(axis=1)
    towards, integers = random.normal(size=(count, 3)), random.integers(-3, 4, (count, 3))
    lattice = (random.random((count, 1)) < 1 / 3) & integers.any(axis=1, keepdims=True)
    towards = np.where(lattice, integers, towards)
    origins = (points - towards * np.ptp(triangles) * 2.0 ** random.integers(-6, 11, (count, 1))).astype(np.float32)
    return origins, np.where(lattice, towards, points - origins).astype(np.float32), kind == 0
