"""Compares searches of the unit with faiss, hnswlib and the same algorithm in plain Python: neighbours, distances, bytes.

    pip install raypath faiss-cpu hnswlib scikit-learn matplotlib
    python scripts/search-recall.py
    python scripts/search-recall.py --plot searches-recall.svg --clock 72.4 --area 1.59

Vectors: 100,000 x 96, made around 1000 centres; 20,000 x 784, the digits of scikit-learn, enlarged, moved and with noise.
"""

from __future__ import annotations

import argparse
import heapq
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import faiss
import hnswlib
import numpy as np
from numpy.typing import NDArray
from sklearn.datasets import load_digits

import raypath

QUERIES = 100
NEIGHBOURS = 10
CONNECTIONS = 16
CANDIDATES = (32, 64, 128)

Floats = NDArray[np.float32]


def made() -> tuple[Floats, Floats]:
    """Vectors around centres, and queries."""
    random = np.random.default_rng(7)
    centres = random.normal(size=(1000, 96))

    def vectors(count: int) -> Floats:
        near = centres[random.integers(0, 1000, count)]
        return (near + 0.35 * random.normal(size=near.shape)).astype(np.float32)

    return vectors(100_000), vectors(QUERIES)


def digits() -> tuple[Floats, Floats]:
    """Digits of 28 x 28 pixels, and queries."""
    random, small = np.random.default_rng(3), load_digits().images

    def vectors(count: int) -> Floats:
        pictures = random.normal(size=(count, 28, 28))
        for picture in pictures:
            x, y = random.integers(0, 5, 2)
            picture[y : y + 24, x : x + 24] += np.kron(small[random.integers(len(small))], np.ones((3, 3)))
        return pictures.reshape(count, 784).astype(np.float32)

    return vectors(20_000), vectors(QUERIES)


def best_first(graph: Any, vectors: NDArray[np.float64], lists: list[list[int]], query: Floats, m: int) -> list[int]:
    """The m best vectors of a search that expands the nearest of the m best so far."""

    def near(indices: list[int]) -> list[tuple[float, int]]:
        return list(zip(((vectors[indices] - query.astype(np.float64)) ** 2).sum(axis=1).tolist(), indices))

    seen, best, expanded = {graph.entry}, near([graph.entry]), set()
    while (waiting := next((index for _, index in best if index not in expanded), None)) is not None:
        expanded.add(waiting)
        if fresh := [index for index in lists[waiting] if index not in seen]:
            seen.update(fresh)
            best = heapq.nsmallest(m, best + near(fresh))
    return [index for _, index in best]


def indices(base: Floats, folder: Path) -> Iterator[tuple[str, Path, Any]]:
    """An index of each package: its name, its file, and what searches with so many candidates."""
    of_hnswlib = hnswlib.Index("l2", base.shape[1])
    of_hnswlib.init_index(len(base), M=CONNECTIONS, ef_construction=200, random_seed=1)
    of_hnswlib.add_items(base)
    of_hnswlib.save_index(str(folder / "hnswlib.bin"))

    def by_hnswlib(queries: Floats, m: int) -> NDArray[Any]:
        of_hnswlib.set_ef(m)
        return of_hnswlib.knn_query(queries, NEIGHBOURS)[0]

    yield "hnswlib", folder / "hnswlib.bin", by_hnswlib
    of_faiss = faiss.IndexHNSWFlat(base.shape[1], CONNECTIONS)
    of_faiss.hnsw.efConstruction = 200
    of_faiss.add(base)
    faiss.write_index(of_faiss, str(folder / "faiss.index"))

    def by_faiss(queries: Floats, m: int) -> NDArray[Any]:
        of_faiss.hnsw.efSearch = m
        return of_faiss.search(queries, NEIGHBOURS)[1]

    yield "faiss", folder / "faiss.index", by_faiss


def plot(file: str, clock: float, area: float) -> None:
    """Draws recall against distances a second and mm2, of a unit with a memory of 100 cycles, for widths of the memory.

    Points are numbers of candidates, in the index that faiss makes of the first vectors.
    """
    from matplotlib import pyplot

    base, queries = made()
    flat = faiss.IndexFlatL2(base.shape[1])
    flat.add(base)
    exact = flat.search(queries, NEIGHBOURS)[1]
    figure, axes = pyplot.subplots(figsize=(6.4, 4))
    with tempfile.TemporaryDirectory() as folder:
        graph = raypath.read_graph([file for name, file, _ in indices(base, Path(folder)) if name == "faiss"][0])
    for width in (128, 256, 512):
        unit = raypath.Unit(search="k=16,m=256,dimensions=1024", memory_width=width)
        rates, recalls = [], []
        for m in (10, 16, 24, 32, 64, 128):
            found = unit.search(graph, queries, k=NEIGHBOURS, ef=m, latency=100)
            assert found.timing is not None
            rates.append(found.evaluations / found.timing["cycles"] * clock / area)
            recalls.append(sum(len(set(a) & set(b)) for a, b in zip(found.ids.tolist(), exact.tolist())) / exact.size)
            print(f"{width} bits, {m} candidates: recall {recalls[-1]:.3f}, {rates[-1]:.2f} M distances/s/mm2")
        axes.plot(rates, recalls, marker="o", label=f"{width} bits a beat")
        for m, rate, recall in zip((10, 16, 24, 32, 64, 128), rates, recalls):
            axes.annotate(str(m), (rate, recall), textcoords="offset points", xytext=(4, -10), fontsize=7)
    axes.set_xlabel(f"million distances of {base.shape[1]} dimensions a second and mm2")
    axes.set_ylabel(f"recall at {NEIGHBOURS}")
    axes.legend(loc="center")
    figure.tight_layout()
    figure.savefig(file, metadata={"Date": None})


def main() -> None:
    """Prints a line for each set of vectors, package and number of candidates; or draws."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--plot", metavar="FILE.svg")
    parser.add_argument("--clock", type=float, default=72.4, help="MHz")
    parser.add_argument("--area", type=float, default=1.59, help="mm2 of the datapath and of what searches")
    arguments = parser.parse_args()
    if arguments.plot:
        return plot(arguments.plot, arguments.clock, arguments.area)
    unit = raypath.Unit(search="k=16,m=128,dimensions=1024")
    for name, (base, queries) in (("made", made()), ("digits", digits())):
        flat = faiss.IndexFlatL2(base.shape[1])
        flat.add(base)
        exact = flat.search(queries, NEIGHBOURS)[1]
        found = unit.search(base, queries, k=NEIGHBOURS)
        print(f"{name}, {len(base)} x {base.shape[1]}: {(found.ids != exact).sum()} of {exact.size} scanned differ from faiss")

        def recall(ids: NDArray[Any], exact: NDArray[Any] = exact) -> float:
            return sum(len(set(a) & set(b)) for a, b in zip(ids.tolist(), exact.tolist())) / exact.size

        with tempfile.TemporaryDirectory() as folder:
            for package, file, search in indices(base, Path(folder)):
                graph = raypath.read_graph(file)
                vectors, lists = graph.vectors.astype(np.float64), graph.neighbours
                for m in CANDIDATES:
                    found = unit.search(graph, queries, k=NEIGHBOURS, ef=m)
                    rows = [best_first(graph, vectors, lists, query, m)[:NEIGHBOURS] for query in queries]
                    equal = sum(row == ids for row, ids in zip(rows, found.ids.tolist()))
                    print(
                        f"  {package}, {m} candidates: recall {recall(search(queries, m)):.3f}, unit {recall(found.ids):.3f}, "
                        f"{equal} of {QUERIES} rows as in plain Python; {found.evaluations / QUERIES:.0f} distances and "
                        f"{found.bytes / QUERIES:.0f} bytes a query"
                    )


if __name__ == "__main__":
    main()
