"""Search against NumPy in float64, and the search of a graph against the algorithm in plain Python."""

import gzip
import heapq
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from numpy.typing import NDArray

import raypath

UNIT = raypath.Unit(search="k=16,m=64,dimensions=64")


@pytest.fixture(scope="module")
def vectors() -> NDArray[np.float32]:
    """A thousand vectors of 24 dimensions, with small integers so that all sums are exact."""
    return np.random.default_rng(5).integers(-9, 9, (1000, 24)).astype(np.float32)


@pytest.mark.parametrize("dtype", [np.float32, np.float16, np.int8])
@pytest.mark.parametrize("metric", ["euclidean", "dot", "cosine"])
def test_unit(vectors: NDArray[np.float32], dtype: type[Any], metric: Literal["euclidean", "dot", "cosine"]) -> None:
    """Neighbours of a scan by the unit, of small integers with exact sums."""
    base: NDArray[Any] = vectors[50:].astype(dtype)
    queries: NDArray[Any] = vectors[:50].astype(dtype)
    scale = 0.5 if dtype is np.int8 else 1.0
    found = UNIT.search(base, queries, k=7, metric=metric, scale=scale)
    wide, wide_base = queries.astype(np.float64), base.astype(np.float64)
    squares = ((wide[:, None] - wide_base) ** 2).sum(axis=2)
    products = wide @ wide_base.T
    cosines = products / np.sqrt((wide**2).sum(axis=1)[:, None] * (wide_base**2).sum(axis=1))
    order, exact = {
        "euclidean": (squares, np.sqrt(squares) * scale),
        "dot": (-products, products * scale**2),
        "cosine": (-cosines, cosines),
    }[metric]
    expected = np.argsort(order, axis=1, kind="stable")[:, :7]
    exact = np.take_along_axis(exact, expected, axis=1)
    np.testing.assert_allclose(found.distances, exact, rtol=1e-6)
    if metric == "cosine":
        # Cosines that differ by less than a rounding may be in either order.
        assert (found.ids == expected).mean() > 0.99
    else:
        np.testing.assert_array_equal(found.ids, expected)
        np.testing.assert_array_equal(found.distances, exact.astype(np.float32))
    blocks = -(-24 * base.itemsize // 64)
    # The norm of the query takes another reading of it.
    read = 950 + (2 if metric == "cosine" else 1)
    assert found.bytes == 50 * 64 * (1 + read * blocks)
    again = UNIT.search(base, queries[:3], k=7, metric=metric, scale=scale, latency=30)
    np.testing.assert_array_equal(again.ids, found.ids[:3])
    assert again.timing is not None
    assert again.timing["cycles"] >= again.beats == again.timing["beats"]


def test_trees(vectors: NDArray[np.float32]) -> None:
    """Points within a radius, and keys in ranges, against NumPy."""
    unit = raypath.Unit(search="k=16,m=16,dimensions=16,trees=1")
    points, queries = vectors[50:, :3].copy(), vectors[:50, :3].copy()
    found = unit.search(points, queries, k=16, index="boxes", radius=3, latency=20)
    distances = np.sqrt(((queries[:, None].astype(np.float64) - points) ** 2).sum(axis=2))
    nearest = np.sort(np.where(distances <= 3, distances, np.nan), axis=1)[:, :16]
    np.testing.assert_array_equal(found.distances, nearest.astype(np.float32))
    near = np.where(found.ids < 0, np.nan, np.take_along_axis(distances, np.maximum(found.ids, 0), axis=1))
    np.testing.assert_array_equal(near.astype(np.float32), found.distances)
    assert found.evaluations < 50 * 950 / 4
    keys = vectors[:, :1].copy()
    ranges = np.array([[-9, -9], [-3.5, -2.5], [8, 20], [3, 2]], np.float32)
    found = unit.search(keys, ranges, k=16, index="keys")
    for row, ids, (low, high) in zip(found.distances, found.ids, ranges, strict=True):
        expected = np.sort(keys[(keys >= low) & (keys <= high)])[:16]
        np.testing.assert_array_equal(row[ids >= 0], expected)
        np.testing.assert_array_equal(keys[ids[ids >= 0], 0], expected)
    for problem, arguments in {
        "radius: found None": {"index": "boxes"},
        "radius: found 1, expected None": {"radius": 1.0},
        "metric cosine in a tree of boxes": {"index": "boxes", "radius": 1.0, "metric": "cosine"},
        "a radius of -1 in a tree": {"index": "boxes", "radius": -1.0},
        "expected None, 'hnsw', 'boxes' or 'keys'": {"index": "tree"},
    }.items():
        with pytest.raises(ValueError, match=problem):
            unit.search(points, queries, k=4, **arguments)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="a unit without trees"):
        UNIT.search(points, queries, k=4, index="boxes", radius=1.0)


def best_first(
    vectors: NDArray[np.float64], neighbours: list[list[int]], entry: int, query: NDArray[np.float64], m: int
) -> list[int]:
    """The m best vectors of a search that expands the nearest of the m best so far."""
    seen = {entry}
    best = [(float(((query - vectors[entry]) ** 2).sum()), entry)]
    expanded: set[int] = set()
    while True:
        waiting = [index for _, index in best if index not in expanded]
        if not waiting:
            return [index for _, index in best]
        expanded.add(waiting[0])
        fresh = [index for index in neighbours[waiting[0]] if index not in seen]
        seen.update(fresh)
        near = [(float(((query - vectors[index]) ** 2).sum()), index) for index in fresh]
        best = heapq.nsmallest(m, best + near)


@pytest.mark.parametrize("name", ["hnswlib.bin", "faiss.index"])
def test_saved_graph(name: str, tmp_path: Path) -> None:
    """The unit finds the vectors, and evaluates as many, as the algorithm in plain Python."""
    data = Path(__file__).parents[2] / "raypath-search/tests/data"
    file = tmp_path / name
    file.write_bytes(gzip.decompress((data / f"{name}.gz").read_bytes()))
    graph = raypath.read_graph(file)
    base, neighbours = graph.vectors.astype(np.float64), graph.neighbours
    queries = (graph.vectors[::10] + np.float32(0.25)).astype(np.float32)
    for m in (16, 40):
        found = UNIT.search(graph, queries, k=16, ef=m)
        expected = [best_first(base, neighbours, graph.entry, query, m)[:16] for query in queries.astype(np.float64)]
        np.testing.assert_array_equal(found.ids, expected)
    assert found.evaluations < 190 * len(queries)
    assert len(found.memory) > base.size * 4
    assert found.jobs.shape == (len(queries),)


def test_own_graph(vectors: NDArray[np.float32]) -> None:
    """A graph that is built here finds most neighbours."""
    exact, found = (UNIT.search(vectors, vectors[:50], k=5, index=index, ef=40) for index in (None, "hnsw"))
    assert (exact.ids == found.ids).mean() > 0.9
    assert found.evaluations < exact.evaluations
    few = UNIT.search(vectors, vectors[:1], k=5, bound=0.0)
    assert few.ids.tolist() == [[0, -1, -1, -1, -1]]
    assert np.isnan(few.distances[0, 1:]).all()


def test_model(vectors: NDArray[np.float32]) -> None:
    """The jobs of a search through the cycle-exact model, with a memory of one's own."""
    found = UNIT.search(vectors, vectors[:3] + np.float32(0.25), k=4, metric="dot")
    model, memory, beat = raypath.UnitModel(UNIT), found.memory, UNIT.parameters["memory_width"] // 8
    waiting: list[tuple[int, int]] = []
    beats: list[tuple[int, bytes]] = []
    jobs: list[tuple[int, int]] = list(enumerate(found.jobs.tolist()))
    results: list[dict[str, Any]] = []
    while len(results) < 12:
        outputs = model.step(job=jobs[0] if jobs else None, vector_response=beats.pop(0) if beats else None)
        if jobs and outputs.job_ready:
            jobs.pop(0)
        if outputs.result is not None:
            results.append(outputs.result)
        if outputs.vector_request is not None:
            waiting.append(outputs.vector_request)
        if not beats and waiting:
            address, tag = waiting.pop(0)
            beats = [(tag, memory[at : at + beat]) for at in range(address, address + 64, beat)]
    for result in results:
        assert result["index"] == found.ids[result["job"], result["rank"]]
        assert result["distance"] == found.distances[result["job"], result["rank"]]
        assert (result["last"], result["status"]) == (result["rank"] == 3, 0)
    assert model.step().searches_idle
    with pytest.raises(ValueError, match="expected a multiple of 64"):
        model.step(job=(0, 4))
    with pytest.raises(ValueError, match="a unit without searches"):
        raypath.UnitModel(raypath.Unit()).step(job=(0, 0))
