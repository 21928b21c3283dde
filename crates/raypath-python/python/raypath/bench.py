"""Measures arrays of jobs in Python beside the same jobs in Rust: ``python -m raypath.bench [--jobs N]``.

All use one thread. Python's time is that of one call with NumPy arrays, with the array of results that it makes. Rust
has three times (``raypath._raypath.rust_seconds``): of batches from jobs to outcomes (``pack``, ``Batch``, ``unpack``),
of ``Batch`` alone for blocks that are packed before, and of ``raypath_embed`` for the same arrays. Each is the shortest
of several measurements.
"""

import argparse
import time
from typing import Any, Callable

import numpy as np
from numpy.typing import NDArray

import raypath
from raypath._raypath import rust_seconds

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


def python_seconds(call: Callable[..., object], arguments: Arguments) -> float:
    """The shortest time of a call in Python."""
    shortest = float("inf")
    for _ in range(REPETITIONS):
        begin = time.perf_counter()
        call(*arguments)
        shortest = min(shortest, time.perf_counter() - begin)
    return shortest


def main() -> None:
    """Prints jobs per second, and the ratio of Python to Rust's batches and to Rust's arrays."""
    parser = argparse.ArgumentParser(prog="python -m raypath.bench", description="Measures arrays of jobs.")
    parser.add_argument("--jobs", type=int, default=1_000_000, help="jobs of an array [default: %(default)s]")
    jobs = parser.parse_args().jobs
    datapath = raypath.Datapath()
    names = ["Python", "Rust batches", "packed blocks", "Rust arrays"]
    print(f"{'jobs a second':14}", *(f"{name:>13}" for name in names), "   Python / batches", "Python / arrays")
    for operation, arguments in workload(jobs).items():
        call = getattr(datapath, operation)
        before = python_seconds(call, arguments)
        batches, blocks, arrays = rust_seconds(operation, *arguments, REPETITIONS)
        python = min(before, python_seconds(call, arguments))
        rates = (jobs / seconds for seconds in (python, batches, blocks, arrays))
        print(f"{operation:14}", *(f"{rate:13.3e}" for rate in rates), end=" ")
        print(f"{batches / python:18.2f} {arrays / python:15.2f}")


if __name__ == "__main__":
    main()
