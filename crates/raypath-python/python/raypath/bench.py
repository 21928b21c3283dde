"""Measures arrays of jobs in Python beside the same jobs in Rust: ``python -m raypath.bench [--jobs N]``.

Both use one thread. Python's time is that of one call with NumPy arrays, with the array of results that it makes.
Rust's time is that of ``raypath_model``: ``pack``, ``Batch`` and ``unpack`` in chunks that fit into the cache, into a
new vector. Each is the shortest of several measurements, which alternate.
"""

import argparse
import time
from typing import Any, Callable

import numpy as np
from numpy.typing import NDArray

import raypath
from raypath._raypath import rust_batch_seconds

REPETITIONS = 15

Arguments = tuple[NDArray[Any], NDArray[Any]]


def workload(jobs: int, seed: int = 1) -> dict[str, Arguments]:
    """The arguments of each operation: rays from all sides at boxes and triangles, and vectors of 16 dimensions."""
    random = np.random.default_rng(seed)

    def points(reach: float, *shape: int) -> NDArray[np.float32]:
        return random.uniform(-reach, reach, (*shape, 3)).astype(np.float32)

    origins = points(4, jobs)
    rays = raypath.rays(origins, points(0.7, jobs) - origins)
    boxes = np.sort(points(1, jobs, 4, 2), axis=2)
    vectors = random.uniform(-1, 1, (2, jobs, 16)).astype(np.float32)
    return {"quadbox": (rays, boxes), "triangle": (rays, points(1, jobs, 3)), "euclidean": (vectors[0], vectors[1])}


def seconds(work: Callable[[], object]) -> float:
    """The time that ``work`` takes."""
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def main() -> None:
    """Prints jobs per second and their ratio for each operation."""
    parser = argparse.ArgumentParser(prog="python -m raypath.bench", description=__doc__)
    parser.add_argument("--jobs", type=int, default=1_000_000, help="jobs of an array [default: %(default)s]")
    jobs = parser.parse_args().jobs
    datapath = raypath.Datapath()
    print(f"{'jobs a second':>14} {'Python':>12} {'Rust':>12} {'ratio':>6}")
    for operation, (first, second) in workload(jobs).items():
        call = getattr(datapath, operation)
        python = rust = float("inf")
        for _ in range(REPETITIONS):
            python = min(python, seconds(lambda: call(first, second)))  # noqa: B023, called at once
            rust = min(rust, rust_batch_seconds(operation, first, second, 1))
        print(f"{operation:>14} {jobs / python:12.3e} {jobs / rust:12.3e} {rust / python:6.2f}")


if __name__ == "__main__":
    main()
