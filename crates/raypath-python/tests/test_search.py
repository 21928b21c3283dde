"""Search against NumPy in float64."""

import numpy as np
import pytest
from numpy.typing import NDArray

import raypath


@pytest.fixture(scope="module")
def vectors() -> NDArray[np.float32]:
    """A thousand vectors of 24 dimensions, with small integers so that all sums are exact."""
    return np.random.default_rng(5).integers(-9, 9, (1000, 24)).astype(np.float32)


@pytest.mark.parametrize("preset", ["paper", "search"])
def test_euclidean(vectors: NDArray[np.float32], preset: str) -> None:
    """Exact search, with ties by index."""
    queries, base = vectors[:50], vectors[50:]
    found = raypath.search(base, queries, k=7, datapath=raypath.Datapath(preset))
    squares = ((queries[:, None].astype(np.float64) - base) ** 2).sum(axis=2)
    expected = np.argsort(squares, axis=1, kind="stable")[:, :7]
    np.testing.assert_array_equal(found.ids, expected)
    np.testing.assert_array_equal(found.distances, np.sqrt(np.take_along_axis(squares, expected, axis=1)))
    assert (found.evaluations, found.beats) == (50 * 950, 50 * 950 * (2 if preset == "paper" else 1))


def test_angular(vectors: NDArray[np.float32]) -> None:
    """Cosine distance, with the query compared with itself once for its norm."""
    queries, base = vectors[:50], vectors[50:]
    found = raypath.search(base, queries, k=7, metric="angular")
    wide, wide_base = queries.astype(np.float64), base.astype(np.float64)
    norms = np.linalg.norm(wide, axis=1)[:, None] * np.linalg.norm(wide_base, axis=1)
    distances = 1 - wide @ wide_base.T / norms
    np.testing.assert_allclose(found.distances, np.sort(distances, axis=1)[:, :7], atol=1e-12)
    np.testing.assert_allclose(np.take_along_axis(distances, found.ids, axis=1), found.distances, atol=1e-12)
    assert found.evaluations == 50 * 951


def test_graph(vectors: NDArray[np.float32]) -> None:
    """Search through a graph finds most of the neighbours with fewer comparisons, the same with the same seed."""
    queries, base = vectors[:50], vectors[50:]
    exact, found, again = (raypath.search(base, queries, k=5, index=index) for index in (None, "hnsw", "hnsw"))
    recall = np.mean([len(set(a) & set(b)) / 5 for a, b in zip(exact.ids.tolist(), found.ids.tolist())])
    assert recall > 0.9
    assert found.evaluations < exact.evaluations
    np.testing.assert_array_equal(found.ids, again.ids)

