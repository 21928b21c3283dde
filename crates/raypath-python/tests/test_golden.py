"""The recorded outcomes of the original hardware, bit for bit (``docs/reference/transactions.md`` has the columns)."""

import gzip
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import raypath

Words = NDArray[np.uint32]


@pytest.fixture(scope="module")
def chisel() -> raypath.Datapath:
    """A datapath with the rules of the original hardware."""
    return raypath.Datapath(rules="chisel")


def recorded(root: Path, operation: str) -> Words:
    """The fields of each line, without ``seq`` and ``cat``."""
    with gzip.open(root / f"crates/raypath/tests/data/golden/{operation}.txt.gz", "rt") as lines:
        return np.array([[int(word, 16) for word in line.split()[2:]] for line in lines], np.uint32)


def numbers(words: Words) -> NDArray[np.float32]:
    """Bit patterns as numbers, in contiguous memory."""
    return np.ascontiguousarray(words).view(np.float32)


def rays_of(words: Words) -> NDArray[np.void]:
    """The first 16 fields as rays, which were recorded in another order: axes before shear."""
    rays = np.zeros(len(words), raypath.RAY)
    fields = {"origin": 0, "direction": 3, "inverse": 6, "shear": 13}
    for field, first in fields.items():
        rays[field] = numbers(words[:, first : first + 3])
    rays["extent"] = numbers(words[:, 9])
    for place, field in enumerate(["kx", "ky", "kz"]):
        rays[field] = words[:, 10 + place]
    return rays


def assert_same(found: NDArray[np.float32], expected: Words) -> None:
    """Compares bits. A NaN may have been recorded with any payload, and is found with the canonical one."""
    is_nan = np.isnan(numbers(expected))
    np.testing.assert_array_equal(found.view(np.uint32), np.where(is_nan, 0x7FC00000, expected))


def test_quadbox(root: Path, chisel: raypath.Datapath) -> None:
    """Arrays of boxes."""
    words = recorded(root, "quadbox")
    assert len(words) > 4000
    hits = chisel.quadbox(rays_of(words), numbers(words[:, 16:40]).reshape(-1, 4, 2, 3))
    assert_same(hits.tmin, words[:, 40:44])
    np.testing.assert_array_equal(hits.is_intersect, words[:, 44:48] == 1)
    np.testing.assert_array_equal(hits.box_index, words[:, 48:52])


def test_triangle(root: Path, chisel: raypath.Datapath) -> None:
    """Arrays of triangles."""
    words = recorded(root, "triangle")
    assert len(words) > 5000
    hits = chisel.triangle(rays_of(words), numbers(words[:, 16:25]).reshape(-1, 3, 3))
    assert_same(hits.t_num, words[:, 25])
    assert_same(hits.t_denom, words[:, 26])
    np.testing.assert_array_equal(hits.triangle_hit, words[:, 27] == 1)


@pytest.mark.parametrize(("operation", "lanes", "sums"), [("euclidean", 16, 1), ("angular", 8, 2)])
def test_distances(root: Path, chisel: raypath.Datapath, operation: str, lanes: int, sums: int) -> None:
    """Beats through ports, whose sums continue from line to line."""
    words = recorded(root, operation)
    assert len(words) > 5000
    vectors = {
        f"euclidean_{name}_{lane}": numbers(words[:, 2 + lanes * place + lane])
        for place, name in enumerate("ab")
        for lane in range(lanes)
    }
    found = chisel.run(operation, euclidean_reset_accum=words[:, 0], euclidean_mask=words[:, 1], **vectors)
    ports = [port["name"] for port in chisel.ports() if (port["operation"], port["direction"]) == (operation, "output")]
    for place, port in enumerate(ports[:sums]):
        assert_same(found[port], words[:, 2 + 2 * lanes + place])
    np.testing.assert_array_equal(found[ports[-1]], words[:, 0] == 1)


def test_pipeline(root: Path, chisel: raypath.Datapath) -> None:
    """The same jobs, one in each cycle, in turn with another operation, through the cycle-exact model."""
    boxes, beats = recorded(root, "quadbox")[:500], recorded(root, "euclidean")[:500]
    rays, bounds = rays_of(boxes), numbers(boxes[:, 16:40]).reshape(-1, 4, 2, 3)
    pipeline = raypath.Pipeline(chisel)
    found: dict[int, raypath.Outcome] = {}
    for cycle in range(1000 + chisel.latency):
        job, number = divmod(cycle, 2)
        if job < 500 and number == 0:
            assert pipeline.offer(raypath.Job.quadbox(rays[job], bounds[job]), cycle)
        elif job < 500:
            a, b = numbers(beats[job, 2:18]), numbers(beats[job, 18:34])
            mask, reset = int(beats[job, 1]), bool(beats[job, 0])
            assert pipeline.offer(raypath.Job.euclidean(a, b, mask=mask, reset=reset), cycle)
        outcome = pipeline.step()
        if outcome is not None:
            assert outcome.tag == cycle - chisel.latency
            found[outcome.tag] = outcome
    assert len(found) == 1000
    tmin = np.array([found[2 * job].values["tmin"] for job in range(500)], np.float32)
    assert_same(tmin, boxes[:, 40:44])
    sums = np.array([found[2 * job + 1].values["accumulator"] for job in range(500)], np.float32)
    assert_same(sums, beats[:, 34])
