"""Many workers in one process, for shards that sleep: ``python -m raypath.cluster.sleepers ADDRESS COUNT``.

Each is a worker of Dask with one thread and a connection of its own. Shards that sleep take no processor time, so that
one machine can hold the workers of a large cluster; what is left to measure is the scheduler, the driver and the store.
"""

from __future__ import annotations

import asyncio
import os
import sys
import time

from raypath.cluster.shard import Shard
from raypath.cluster.store import Result

PART_BYTES = 20_000
"""The size of a result: that of a shard of ``verify campaign``, compressed."""


AT_A_TIME = 25
"""How many workers connect at a time."""


def sleep(shard: Shard) -> Result:
    """Sleeps for the seconds that are the shard's last argument, in place of computing it."""
    seconds = float(shard.arguments[-1])
    time.sleep(seconds)
    return Result(0, seconds, "sleeper", "", bytes(PART_BYTES))


async def _work(address: str, count: int) -> None:
    import dask
    from distributed import Worker

    # Statistics of the process, which each worker would take for itself twice a second.
    quiet = {"distributed.admin.system-monitor.interval": "60s", "distributed.worker.profile.enabled": False}
    dask.config.set(quiet)
    started = []
    for first in range(0, count, AT_A_TIME):
        workers = (
            Worker(address, nthreads=1, name=f"sleeper-{os.getpid()}-{number}", memory_limit=0, dashboard=False)
            for number in range(first, min(count, first + AT_A_TIME))
        )
        started += await asyncio.gather(*workers)
    await asyncio.gather(*(worker.finished() for worker in started))


if __name__ == "__main__":
    asyncio.run(_work(sys.argv[1], int(sys.argv[2])))
