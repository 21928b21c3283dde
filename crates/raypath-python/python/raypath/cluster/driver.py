"""Lets the workers of a scheduler compute shards, and stores their results.

The driver alone writes to the store, and it alone decides what has been done: a shard is done when its result is in
the store. Schedulers and workers may stop at any time; what they had not delivered is sent again.
"""

from __future__ import annotations

import contextlib
import functools
import queue
import time
from dataclasses import dataclass, field
from typing import Any, Callable

from raypath.cluster.errors import ClusterError
from raypath.cluster.progress import Counts, Progress
from raypath.cluster.shard import Shard, ShardError, compute
from raypath.cluster.store import DamagedResultError, Result, Store

POLL_SECONDS = 0.2
RETRY_SECONDS = 1.0
RESULT_SECONDS = 60.0

GATHERED = 64
"""How many results are fetched at a time."""


@dataclass
class Outcome:
    """What has become of the shards of a run: results by key, and the keys of those that were not computed."""

    results: dict[str, Result] = field(default_factory=dict)
    failed: set[str] = field(default_factory=set)


class Driver:
    """A run of shards. ``connect`` makes a client of the scheduler; it is called again when the connection is lost."""

    def __init__(
        self,
        shards: list[Shard],
        store: Store,
        connect: Callable[[], Any],
        reconnect_seconds: float,
        compute: Callable[[Shard], Result] = compute,
    ) -> None:
        """Prepares a run. A lost scheduler is waited for ``reconnect_seconds``; ``compute`` runs on the workers."""
        self._shards = {shard.key: shard for shard in shards}
        self._store = store
        self._connect = connect
        self._reconnect_seconds = reconnect_seconds
        self._client: Any = None
        self._compute = compute
        self._outcome = Outcome()
        self._counts = Counts(total=len(self._shards))
        self._progress = Progress(self._counts)
        self._waiting = dict(self._shards)
        self._futures: dict[str, Any] = {}
        self._ended: queue.SimpleQueue[tuple[str, Any]] = queue.SimpleQueue()

    def run(self) -> Outcome:
        """Runs all shards whose results are not in the store.

        Raises ``ClusterError`` if the store cannot be written or the scheduler stays away; results that are stored stay
        stored. ``KeyboardInterrupt`` cancels what has been sent.
        """
        self._take_stored()
        if self._waiting:
            self._client = self._connected()
            try:
                self._run()
            finally:
                self._cancel()
        self._progress.show(is_last=True)
        return self._outcome

    def _take_stored(self) -> None:
        for key, shard in self._shards.items():
            try:
                result = self._store.get(key)
            except DamagedResultError as problem:
                self._progress.say(f"{problem}; shard {shard.shard} is computed again")
                continue
            if result is not None:
                self._counts.stored += 1
                self._take(shard, result)

    def _take(self, shard: Shard, result: Result) -> None:
        """Counts a result, and reports claims that do not hold."""
        del self._waiting[shard.key]
        self._outcome.results[shard.key] = result
        if result.exit_code != 0:
            self._counts.wrong += 1
            wrong = [line for line in result.output.splitlines() if line.startswith("  wrong ")]
            text = "\n".join(wrong) or result.output.strip()
            self._progress.say(f"wrong: {shard.command} on {result.host}:\n{text}\n  to repeat it: {shard.command}")

    def _connected(self) -> Any:
        """A client, as soon as the scheduler answers."""
        deadline = time.monotonic() + self._reconnect_seconds
        while True:
            try:
                return self._connect()
            except ConnectionError as problem:
                if time.monotonic() > deadline:
                    raise ClusterError(
                        f"{problem}; expected a scheduler within {self._reconnect_seconds:.0f} s. "
                        f"{len(self._outcome.results)} of {len(self._shards)} results are in {self._store.folder}; "
                        "the same command goes on from there"
                    ) from problem
                time.sleep(RETRY_SECONDS)

    def _run(self) -> None:
        """Sends shards and takes results until none is left."""
        while self._waiting:
            if self._client.status != "running":
                self._reconnect()
            self._send()
            self._receive(self._next_ended())
            if self._progress.is_due():
                self._count_workers()
                self._progress.show()

    def _next_ended(self) -> list[tuple[str, Any]]:
        """The futures that have ended since, after a wait for the first; some of them at a time."""
        ended = []
        with contextlib.suppress(queue.Empty):
            ended.append(self._ended.get(timeout=POLL_SECONDS))
            while len(ended) < GATHERED:
                ended.append(self._ended.get_nowait())
        return ended

    def _reconnect(self) -> None:
        self._progress.say("the connection to the scheduler is lost; connecting again")
        self._futures.clear()
        with contextlib.suppress(Exception):
            self._client.close(timeout=1)
        self._client = self._connected()
        self._progress.say(f"connected; {len(self._waiting)} shards are sent again")

    def _send(self) -> None:
        keys = [key for key in self._waiting if key not in self._futures]
        if keys:
            shards = [self._waiting[key] for key in keys]
            # The key names the result: a scheduler that already computes it does not begin once more. One message for
            # all shards takes a fraction of the time of one for each.
            futures = self._client.map(self._compute, shards, key=[f"raypath-{key}" for key in keys], pure=False)
            for key, future in zip(keys, futures):
                self._futures[key] = future
                future.add_done_callback(functools.partial(self._note, key))

    def _note(self, key: str, future: Any) -> None:
        """Called on a thread of the client when a future has a result, an error, or is cancelled."""
        self._ended.put((key, future))

    def _receive(self, ended: list[tuple[str, Any]]) -> None:
        finished = {}
        for key, future in ended:
            # Futures of earlier connections do not count.
            if key not in self._futures or self._futures[key] is not future:
                continue
            del self._futures[key]
            if future.status == "finished":
                finished[key] = future
            elif future.status == "error":
                self._fail(self._shards[key], future.exception())
            # Else it was cancelled, because the connection was lost: the shard stays waiting, and is sent again.
        for key, result in self._gathered(finished).items():
            self._store.put(key, self._shards[key].inputs, result)
            self._counts.computed += 1
            self._take(self._shards[key], result)
        for future in finished.values():
            future.release()

    def _gathered(self, futures: dict[str, Any]) -> dict[str, Result]:
        """The results of these futures. A result is missing if the worker that held it is gone."""
        try:
            # All at once: a question for each would cost a message to the scheduler and one to a worker.
            return dict(zip(futures, self._client.gather(list(futures.values()))))
        except Exception:
            found = {}
            for key, future in futures.items():
                with contextlib.suppress(Exception):
                    found[key] = future.result(timeout=RESULT_SECONDS)
            return found

    def _fail(self, shard: Shard, problem: BaseException) -> None:
        del self._waiting[shard.key]
        self._outcome.failed.add(shard.key)
        self._counts.failed += 1
        known = isinstance(problem, (ShardError, ClusterError))
        text = str(problem) if known else f"{type(problem).__name__}: {problem}"
        self._progress.say(f"failed: {shard.command}:\n{text.rstrip()}\n  to repeat it: {shard.command}")

    def _count_workers(self) -> None:
        with contextlib.suppress(Exception):
            self._counts.workers = len(self._client.nthreads()) if self._client.status == "running" else 0

    def _cancel(self) -> None:
        """Tells the scheduler to forget what has not been delivered, and leaves."""
        futures = list(self._futures.values())
        self._futures.clear()
        with contextlib.suppress(Exception):
            if futures and self._client.status == "running":
                # Shards that other drivers wait for go on.
                self._client.cancel(futures)
        with contextlib.suppress(Exception):
            self._client.close(timeout=2)
