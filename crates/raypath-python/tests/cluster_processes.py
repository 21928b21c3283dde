"""Programs, schedulers and workers for the tests, as real processes."""

from __future__ import annotations

import contextlib
import os
import re
import shlex
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Callable

DEADLINE = 60.0
"""Seconds after which a process that should have ended has failed. No test waits for them."""


def wait_until(what: str, condition: Callable[[], bool]) -> None:
    """Waits until the condition holds."""
    deadline = time.monotonic() + DEADLINE
    while not condition():
        assert time.monotonic() < deadline, f"still not true: {what}"
        time.sleep(0.05)


def without_times(text: str) -> str:
    """What the program printed, without what differs from run to run on one machine."""
    text = re.sub(r", in [0-9.]+ s$", "", text, flags=re.MULTILINE)
    text = re.sub(r"^[0-9.]+ s by the functional model: .* jobs/s,", "", text, flags=re.MULTILINE)
    return re.sub(r"^(queries per second, functional model) .*$", r"\1", text, flags=re.MULTILINE)


def files(folder: Path) -> dict[str, bytes]:
    """The files in a folder by their paths, without a store."""
    found = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in found if "cluster" not in path.parts}


def results(folder: Path) -> list[Path]:
    """The stored results of a run in a folder."""
    return sorted(path for path in (folder / "build/cluster").rglob("*") if path.is_file())


class Wrapped:
    """A program that runs raypath, and does what a test adds before and after. It logs each run and its process."""

    def __init__(self, folder: Path, program: Path, before: str = "", after: str = "") -> None:
        self._log = folder / "log.txt"
        self.path = folder / "raypath-wrapped"
        # The program also answers --list, which is no shard.
        self.path.write_text(
            f"""#!/bin/sh
case "$*" in *--part*) ;; *) exec {shlex.quote(str(program))} "$@" ;; esac
shard=$(printf '%s' "$*" | sed 's/.*--shard \\([^ ]*\\).*/\\1/')
echo "begin $shard $$ $PPID" >> {shlex.quote(str(self._log))}
{before}
{shlex.quote(str(program))} "$@"
code=$?
{after}
echo "end $shard $$ $PPID" >> {shlex.quote(str(self._log))}
exit $code
"""
        )
        self.path.chmod(0o755)

    def log(self, event: str) -> list[list[str]]:
        """The shard, the process and the worker's process of each "begin" or "end" so far."""
        lines = self._log.read_text().splitlines() if self._log.exists() else []
        return [line.split()[1:] for line in lines if line.startswith(event)]


def is_running(process: str) -> bool:
    """Whether the process with this number runs."""
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state not in ("Z", "X")


def cluster(program: Path, *words: str) -> list[str]:
    """The command that runs these words on a cluster."""
    return [sys.executable, "-m", "raypath.cluster", words[0], "--program", str(program), *words[1:]]


@contextlib.contextmanager
def processes() -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Starts processes, and ends those that still run at the end."""
    started = []

    def start(command: list[str], folder: Path) -> subprocess.Popen[str]:
        folder.mkdir(exist_ok=True)
        process = subprocess.Popen(
            command,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        started.append(process)
        return process

    yield start
    for process in started:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


class Dask:
    """A scheduler of Dask at a port of its own, and its workers."""

    def __init__(self, start: Callable[..., subprocess.Popen[str]], folder: Path, tls: list[str] | None = None) -> None:
        self._start = start
        self._tls = [f"--tls-{kind}={path}" for kind, path in zip(("ca-file", "cert", "key"), tls or [])]
        self._folder = folder
        with socket.socket() as found:
            found.bind(("127.0.0.1", 0))
            self._port = found.getsockname()[1]
        self.address = f"{'tls' if tls else 'tcp'}://127.0.0.1:{self._port}"
        self.scheduler: subprocess.Popen[str]

    def start(self) -> None:
        """Starts the scheduler and a worker with one thread, which is started again when it ends."""
        protocol = ["--protocol", self.address.partition(":")[0]]
        options = [*protocol, "--host", "127.0.0.1", "--port", str(self._port), "--no-dashboard", *self._tls]
        self.scheduler = self._dask("scheduler", *options)
        options = [*protocol, "--nthreads", "1", "--no-dashboard", "--memory-limit", "0", *self._tls]
        self._dask("worker", self.address, *options)

    def _dask(self, *words: str) -> subprocess.Popen[str]:
        # A process blocks when the pipe of its output is full and has no reader.
        script = f"exec {shlex.join([sys.executable, '-m', 'dask', *words])} > dask-{words[0]}.log 2>&1"
        return self._start(["sh", "-c", script], self._folder)
