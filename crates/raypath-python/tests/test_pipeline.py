"""The timing of a pipeline, which the documents state: latency, one job a cycle, capacity, back pressure."""

import numpy as np
import pytest
from helpers import f32

import raypath


def job(datapath: raypath.Datapath) -> raypath.Job:
    """A job without values."""
    return raypath.Job.timing(datapath, "triangle")


@pytest.mark.parametrize(("preset", "latency"), [("paper", 12), ("credit", 12), ("fast", 46), ("fastest", 62)])
def test_latency(preset: str, latency: int) -> None:
    """Cycles from acceptance to outcome, in single steps and in one skip."""
    datapath = raypath.Datapath(preset)
    assert datapath.latency == latency
    pipeline = raypath.Pipeline(datapath)
    assert pipeline.offer(job(datapath), 1)
    waited = 0
    while not pipeline.output_valid:
        assert pipeline.step() is None
        waited += 1
    assert waited == latency
    outcome = pipeline.step()
    assert outcome is not None
    assert (outcome.tag, outcome.operation, outcome.values) == (1, "triangle", {})
    assert pipeline.offer(job(datapath), 2)
    assert pipeline.skip(1000) == latency
    assert pipeline.output_valid


def test_throughput(datapath: raypath.Datapath) -> None:
    """One job in every cycle, in order."""
    pipeline = raypath.Pipeline(datapath)
    tags = []
    for cycle in range(100):
        assert pipeline.offer(job(datapath), cycle)
        outcome = pipeline.step()
        tags += [outcome.tag] if outcome else []
    assert tags == list(range(100 - datapath.latency))


@pytest.mark.parametrize(("control", "capacity"), [("skid", 24), ("credit", 13)])
def test_capacity(control: str, capacity: int) -> None:
    """The jobs that fit while the sink is not ready, none of which is lost."""
    datapath = raypath.Datapath(control=control)  # type: ignore[arg-type]
    pipeline = raypath.Pipeline(datapath)
    accepted = 0
    for _ in range(100):
        accepted += pipeline.offer(job(datapath), accepted)
        assert pipeline.step(output_ready=False) is None
    assert accepted == capacity
    assert pipeline.occupancy == capacity
    assert not pipeline.input_ready("quadbox")
    assert pipeline.skip(50) == 0
    tags = []
    while pipeline.occupancy:
        outcome = pipeline.step()
        tags += [outcome.tag] if outcome else []
    assert tags == list(range(capacity))


def test_one_job_a_cycle(datapath: raypath.Datapath) -> None:
    """A second job in a cycle is refused, and enters in the next."""
    pipeline = raypath.Pipeline(datapath)
    assert pipeline.offer(job(datapath), 0)
    assert not pipeline.offer(job(datapath), 1)
    assert not pipeline.input_ready("triangle")
    pipeline.step()
    assert pipeline.offer(job(datapath), 1)
    assert pipeline.occupancy == 2


def test_accumulators(datapath: raypath.Datapath) -> None:
    """Sums continue until a reset, and masked coordinates do not count. A reset of the pipeline clears them."""
    pipeline = raypath.Pipeline(datapath)
    ones, zeros = np.ones(16, np.float32), np.zeros(16, np.float32)
    beats = [
        raypath.Job.euclidean(ones, zeros, reset=False),
        raypath.Job.euclidean(ones, zeros, mask=0b111),
        raypath.Job.euclidean(2 * ones[:3], zeros[:3]),
        raypath.Job.angular(ones[:8], 2 * ones[:8], reset=False),
        raypath.Job.angular(ones[:8], 2 * ones[:8]),
    ]
    assert all(pipeline.offer(beat, tag) and pipeline.step() is None for tag, beat in enumerate(beats))
    outcomes = [outcome.values for _ in range(20) if (outcome := pipeline.step())]
    assert outcomes[:3] == [
        {"accumulator": 16.0, "reset_accum": False},
        {"accumulator": 19.0, "reset_accum": True},
        {"accumulator": 12.0, "reset_accum": True},
    ]
    assert outcomes[4] == {"dot_product": 32.0, "norm": 64.0, "reset_accum": True}

    assert pipeline.offer(beats[0])
    pipeline.reset()
    assert pipeline.occupancy == 0
    assert pipeline.offer(beats[1], 5)
    pipeline.skip(100)
    outcome = pipeline.step()
    assert outcome is not None
    assert (outcome.tag, outcome.values["accumulator"]) == (5, 3.0)


def test_values_of_boxes_and_triangles(datapath: raypath.Datapath) -> None:
    """A job in the pipeline has the outcome of an array."""
    rays = raypath.rays(f32([[0, 0, -5]]), f32([[0, 0, 1]]))
    boxes = f32([[[-1, -1, z], [1, 1, z + 1]] for z in (3, 0, -9, 2)])
    triangle = f32([[-1, -1, 0], [0, 1, 0], [1, -1, 0]])
    pipeline = raypath.Pipeline(datapath)
    for made in (raypath.Job.quadbox(rays[0], boxes), raypath.Job.triangle(rays, triangle)):
        assert pipeline.offer(made)
        pipeline.step()
    found = [outcome.values for _ in range(20) if (outcome := pipeline.step())]
    hits = {"is_intersect": [True, True, True, False], "tmin": [5.0, 7.0, 8.0, np.inf], "box_index": [1, 3, 0, 2]}
    assert found[0] == hits
    arrays = datapath.triangle(rays, triangle[None])
    assert found[1] == {name: getattr(arrays, name)[0] for name in ("triangle_hit", "t_num", "t_denom")}


def test_shared_by_threads_in_turn(datapath: raypath.Datapath) -> None:
    """Pipelines of one datapath do not influence each other."""
    first, second = raypath.Pipeline(datapath), raypath.Pipeline(datapath)
    assert first.offer(job(datapath))
    assert (first.occupancy, second.occupancy) == (1, 0)
