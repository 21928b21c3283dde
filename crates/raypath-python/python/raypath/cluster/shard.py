"""A shard, and how a worker computes it: the program as a process of its own."""

from __future__ import annotations

import contextlib
import gzip
import os
import shutil
import signal
import socket
import stat
import subprocess
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable

from raypath.cluster import program
from raypath.cluster.errors import ClusterError
from raypath.cluster.store import Result, digest_of, digest_of_file

PART = "part.json"
"""The file that the program writes, in a folder of its own."""

POLL_SECONDS = 0.1
"""How often a worker looks whether its shard is still wanted."""

MAX_OUTPUT = 20_000
"""The characters of the program's output that are kept, from the end."""


@dataclass(frozen=True)
class Shard:
    """A shard of a command.

    ``arguments`` are those of ``raypath`` without the shard, ``shard`` is "2/5", and ``files`` has the SHA-256 of
    each file that the arguments name, by absolute path. ``versions`` are those of external programs that the result
    depends on. ``program`` is None where each worker has to find its own; its digest must be ``program_digest``.
    """

    arguments: tuple[str, ...]
    shard: str
    files: tuple[tuple[str, str], ...]
    versions: tuple[str, ...]
    program: str | None
    program_digest: str
    threads: int

    @property
    def inputs(self) -> dict[str, Any]:
        """Everything that the result depends on."""
        return {
            "format": 1,
            "arguments": list(self.arguments),
            "shard": self.shard,
            "files": dict(self.files),
            "versions": list(self.versions),
            "program": self.program_digest,
        }

    @property
    def key(self) -> str:
        """The name of the result in a store."""
        return digest_of(self.inputs)

    @property
    def command(self) -> str:
        """The command that repeats the shard without its part."""
        return " ".join(["raypath", *self.arguments, "--shard", self.shard])


class ShardError(Exception):
    """A shard that could not be computed, with the reason and the end of the program's output."""


def compute(shard: Shard) -> Result:
    """Computes a shard on the worker that calls this.

    Raises ``ShardError`` if the program fails, and ``ClusterError`` if the worker's program or files differ from those
    of the machine that sent the shard.
    """
    path = program.find(shard.program)
    _expect(str(path), program.digest(path), shard.program_digest, "the program")
    for name, digest in shard.files:
        _expect(name, _digest_of_input(name), digest, "a file")
    arguments = [*shard.arguments, "--shard", shard.shard, "--part", PART]
    if shard.arguments[0] == "explore" and "--cache" not in shard.arguments:
        # Shards on one machine share the syntheses of blocks.
        arguments += ["--cache", str(private_cache())]
    try:
        with tempfile.TemporaryDirectory(prefix="raypath-shard-") as folder:
            return _run([str(path), *arguments], shard, Path(folder), _is_wanted())
    except OSError as problem:
        raise ShardError(f"{problem.filename or 'the shard'}: {problem.strerror}") from problem


def _run(command: list[str], shard: Shard, folder: Path, is_wanted: Callable[[], bool]) -> Result:
    begin = time.monotonic()
    environment = {**os.environ, "RAYON_NUM_THREADS": str(shard.threads)}
    with open(folder / "output.txt", "w+b") as output:
        process = subprocess.Popen(
            [*bound_to_parent(), *command],
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            while True:
                try:
                    code = process.wait(POLL_SECONDS)
                    break
                except subprocess.TimeoutExpired:
                    if not is_wanted():
                        raise ShardError("cancelled") from None
        finally:
            _kill(process)
        output.seek(max(0, output.seek(0, os.SEEK_END) - MAX_OUTPUT))
        text = output.read().decode(errors="replace")
    part = folder / PART
    if code not in (0, 1) or not part.is_file():
        ended = f"was killed by signal {-code}" if code < 0 else f"ended with exit code {code}"
        raise ShardError(f"raypath {ended}\n{text}")
    content = gzip.compress(part.read_bytes(), compresslevel=1, mtime=0)
    return Result(code, time.monotonic() - begin, socket.gethostname(), text, content)


def private_cache() -> Path:
    """The cache of syntheses, which ``explore`` trusts. Raises ``ClusterError`` if others may write to it."""
    folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "raypath-ppa"
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(FileExistsError):
            folder.mkdir(mode=0o700)
        found = folder.lstat()
    except OSError as problem:
        raise ClusterError(f"{folder}: cannot use as a cache: {problem.strerror}") from problem
    mode = stat.S_IMODE(found.st_mode)
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or mode & 0o077:
        raise ClusterError(
            f"{folder}: owner {found.st_uid}, mode {mode:o}, expected a folder of user {os.getuid()} with mode 700"
        )
    return folder


def _kill(process: subprocess.Popen[bytes]) -> None:
    """Ends the process and all that it has started."""
    if process.poll() is None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def bound_to_parent() -> list[str]:
    """The beginning of a command that ends with its parent: a killed worker leaves no process. Linux only."""
    setpriv = shutil.which("setpriv")
    return [setpriv, "--pdeathsig", "KILL", "--"] if setpriv else []


def _expect(name: str, found: str, expected: str, what: str) -> None:
    if found != expected:
        host = socket.gethostname()
        raise ClusterError(f"{name}: {what} with SHA-256 {found} on {host}, expected {expected} as where the run began")


_digests: dict[tuple[str, int, int], str] = {}
_digests_lock = threading.Lock()


def _digest_of_input(name: str) -> str:
    """The digest of a file, computed again when its size or time has changed."""
    try:
        found = os.stat(name)
        state = (name, found.st_size, found.st_mtime_ns)
        with _digests_lock:
            if state not in _digests:
                _digests[state] = digest_of_file(Path(name))
            return _digests[state]
    except OSError as problem:
        host = socket.gethostname()
        raise ClusterError(f"{name}: cannot read on {host}: {problem.strerror}; expected it at the same path") from None


def _is_wanted() -> Callable[[], bool]:
    """Whether the scheduler still wants the task of this thread; always, outside of a worker."""
    from distributed import get_worker

    try:
        worker = get_worker()
    except ValueError:
        return lambda: True
    key = worker.get_current_task()

    def is_wanted() -> bool:
        task = worker.state.tasks.get(key)
        return task is not None and task.state == "executing"

    return is_wanted
