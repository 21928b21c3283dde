"""``python -m raypath.cluster measure``: the overhead of a shard, the growth with workers, and a simulation.

1. The smallest shard, run by itself and by one worker: the difference is the overhead of a shard.
2. A campaign with 1 and with 2 workers.
3. Shards that sleep, on up to 1,000 workers, beside the time that the first two figures predict.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import logging
import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from raypath.cluster import plan, program
from raypath.cluster.driver import Driver
from raypath.cluster.errors import ClusterError
from raypath.cluster.scheduler import Choice, connection, library
from raypath.cluster.shard import Shard, bound_to_parent, compute
from raypath.cluster.sleepers import sleep
from raypath.cluster.store import Store

PER_PROCESS = 250
"""Sleeping workers in a process."""
START_SECONDS = 600.0
"""How long all sleeping workers may take to start."""


@dataclass
class Run:
    """A run of ``shards`` shards on ``workers`` workers: its time, and the time that ``predicted`` it."""

    what: str
    workers: int
    shards: int
    shard_seconds: float
    seconds: float
    predicted: float

    @property
    def efficiency(self) -> float:
        """The time of the shards by themselves, divided by the time that the workers had."""
        return self.shards * self.shard_seconds / (self.workers * self.seconds)


def add_options(parser: argparse.ArgumentParser) -> None:
    """The options of ``measure``."""
    parser.add_argument("--program", help="the program raypath")
    parser.add_argument("--jobs", type=int, default=2_000_000, help="jobs of the campaign [default: 2000000]")
    parser.add_argument("--shards", type=int, default=32, help="shards of the campaign [default: 32]")
    parser.add_argument(
        "--sleepers", type=int, nargs="*", default=[1, 10, 100, 1000], help="numbers of sleeping workers"
    )
    parser.add_argument("--sleep", type=float, default=10.0, help="seconds of a sleeping shard [default: 10]")
    parser.add_argument("--rounds", type=int, default=4, help="sleeping shards of a worker [default: 4]")
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(options: argparse.Namespace) -> int:
    """Measures, and prints the figures."""
    path = program.find(options.program)
    alone, overhead = _overhead(path)
    _say(f"the smallest shard: {alone:.3f} s by itself, {alone + overhead:.3f} s through Dask: {overhead:.3f} s more")
    runs = []
    campaign = _campaign(path, options.jobs, options.shards)
    shard_seconds = _mean_seconds(campaign)
    for workers in (1, 2):
        seconds = _run_local(campaign, workers)
        predicted = math.ceil(len(campaign) / workers) * (shard_seconds + overhead)
        runs.append(Run("campaign", workers, len(campaign), shard_seconds, seconds, predicted))
        _say(_line(runs[-1]))
    serial = _serial_seconds()
    _say(f"the driver takes a result in {serial:.4f} s, so that it serves {1 / serial:.0f} shards a second")
    for workers in options.sleepers:
        count = workers * options.rounds
        seconds = _run_sleepers(workers, count, options.sleep)
        # All workers are busy in each round, but those of the first begin one after another.
        predicted = max(options.rounds * (options.sleep + overhead) + workers * serial, count * serial)
        runs.append(Run("sleep", workers, count, options.sleep, seconds, predicted))
        _say(_line(runs[-1]))
    if options.json:
        figures = {"alone": alone, "overhead": overhead, "serial": serial}
        print(json.dumps({**figures, "runs": [{**asdict(run), "efficiency": run.efficiency} for run in runs]}))
    return 0


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _line(run: Run) -> str:
    return (
        f"{run.what}: {run.workers} workers, {run.shards} shards of {run.shard_seconds:.2f} s: {run.seconds:.1f} s, "
        f"predicted {run.predicted:.1f} s, efficiency {100 * run.efficiency:.0f} %"
    )


def _campaign(path: Path, jobs: int, shards: int) -> list[Shard]:
    return plan.plan("verify", ["campaign", "--jobs", str(jobs)], shards, 1, path, True).shards


def _mean_seconds(shards: list[Shard]) -> float:
    """The mean time of a shard by itself, over a few."""
    few = shards[:: max(1, len(shards) // 4)]
    return sum(compute(shard).seconds for shard in few) / len(few)


def _overhead(path: Path) -> tuple[float, float]:
    """The time of the smallest shard by itself, and what Dask, the driver and the store add with one worker."""
    count = 40
    shards = plan.plan("verify", ["sums", "--jobs", str(count)], count, 1, path, True).shards
    begin = time.monotonic()
    for shard in shards:
        compute(shard)
    alone = (time.monotonic() - begin) / count
    return alone, _run_local(shards, 1) / count - alone


def _run_local(shards: list[Shard], workers: int) -> float:
    """The time of a run on this machine, without the start of the workers."""
    with tempfile.TemporaryDirectory() as folder, connection(Choice("local", workers, {})) as connect:
        return _seconds(Driver(shards, Store(Path(folder)), connect, 60))


def _seconds(driver: Driver) -> float:
    begin = time.monotonic()
    outcome = driver.run()
    seconds = time.monotonic() - begin
    if outcome.failed:
        raise ClusterError(f"{len(outcome.failed)} shards failed, expected none")
    return seconds


def _sleeping(count: int, seconds: float) -> list[Shard]:
    return [Shard(("sleep", str(seconds)), f"{number + 1}/{count}", (), (), None, "", 1) for number in range(count)]


def _serial_seconds() -> float:
    """The time for a result in scheduler, driver and store, if shards take none: the limit of the rate."""
    count = 1000
    return _run_sleepers(20, count, 0.0) / count


def _run_sleepers(workers: int, count: int, seconds: float) -> float:
    """The time of a run of sleeping shards, without the start of the workers."""
    with _sleepers(workers) as address, connection(Choice(address, 0, {})) as connect:
        client = connect()
        client.wait_for_workers(workers, timeout=START_SECONDS)
        client.close()
        with tempfile.TemporaryDirectory() as folder:
            return _seconds(Driver(_sleeping(count, seconds), Store(Path(folder)), connect, 60, sleep))


@contextlib.contextmanager
def _sleepers(workers: int) -> Iterator[str]:
    """A scheduler, and processes with this number of workers. The value is the scheduler's address."""
    cluster = library("distributed").LocalCluster(
        n_workers=0, processes=False, dashboard_address=":0", protocol="tcp", silence_logs=logging.CRITICAL
    )
    processes = []
    try:
        for first in range(0, workers, PER_PROCESS):
            count = min(PER_PROCESS, workers - first)
            command = [sys.executable, "-m", "raypath.cluster.sleepers", cluster.scheduler_address, str(count)]
            processes.append(subprocess.Popen([*bound_to_parent(), *command], stderr=subprocess.DEVNULL))
        yield cluster.scheduler_address
    finally:
        for process in processes:
            process.kill()
            process.wait()
        cluster.close()
