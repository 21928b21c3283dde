"""Results of shards on disk, named by everything that they depend on.

A result is one file, ``results/KEY[:2]/KEY``: the SHA-256 of the rest of the file in hexadecimal digits and a line
feed; a JSON object and a line feed; the part that ``raypath --part`` wrote, as gzip. A file appears complete or not at
all, and its content is checked whenever it is read.
"""

from __future__ import annotations

import contextlib
import gzip
import hashlib
import json
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from raypath.cluster.errors import ClusterError


@dataclass(frozen=True)
class Result:
    """The result of a shard.

    ``exit_code`` is that of ``raypath``: 0, or 1 if a claim does not hold. ``seconds`` is its time on the worker
    ``host``, and ``output`` what it printed. ``part`` is the file that it wrote, as gzip.
    """

    exit_code: int
    seconds: float
    host: str
    output: str
    part: bytes

    def part_text(self) -> bytes:
        """The part as JSON."""
        return gzip.decompress(self.part)


def digest_of(inputs: dict[str, Any]) -> str:
    """The name of a result: the SHA-256 of its inputs as JSON with sorted keys."""
    text = json.dumps(inputs, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


def digest_of_file(path: Path) -> str:
    """The SHA-256 of a file."""
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        for block in iter(lambda: file.read(1 << 20), b""):
            digest.update(block)
    return digest.hexdigest()


class DamagedResultError(Exception):
    """A stored result whose content does not have its digest."""


class Store:
    """A folder of results. Any number of programs may use it at the same time."""

    def __init__(self, folder: Path) -> None:
        """A store in a folder, which the first result creates."""
        self.folder = folder
        self._results = folder / "results"

    def path(self, key: str) -> Path:
        """The file of the result with this name."""
        return self._results / key[:2] / key

    def get(self, key: str) -> Result | None:
        """The result with this name, or None if there is none.

        Raises ``DamagedResultError`` if its file is damaged, and ``ClusterError`` if it cannot be read.
        """
        path = self.path(key)
        try:
            data = path.read_bytes()
        except FileNotFoundError:
            return None
        except OSError as problem:
            raise ClusterError(f"{path}: cannot read: {problem.strerror}") from problem
        found, _, rest = data.partition(b"\n")
        if hashlib.sha256(rest).hexdigest().encode() != found:
            raise DamagedResultError(f"{path}: the content does not have the digest in its first line")
        head, _, part = rest.partition(b"\n")
        fields = json.loads(head)
        if fields["key"] != key:
            raise DamagedResultError(f"{path}: the result of {fields['key']}, expected that of the file's name")
        return Result(fields["exit_code"], fields["seconds"], fields["host"], fields["output"], part)

    def put(self, key: str, inputs: dict[str, Any], result: Result) -> None:
        """Stores a result. Raises ``ClusterError`` if it cannot be written; then nothing is left of it."""
        path = self.path(key)
        head = {
            "key": key,
            "inputs": inputs,
            "exit_code": result.exit_code,
            "seconds": result.seconds,
            "host": result.host,
            "output": result.output,
        }
        rest = json.dumps(head).encode() + b"\n" + result.part
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            _write(path, hashlib.sha256(rest).hexdigest().encode() + b"\n" + rest)
        except OSError as problem:
            raise ClusterError(f"{path}: cannot write: {problem.strerror}") from problem


def _write(path: Path, data: bytes) -> None:
    """Writes a file that appears complete or not at all, also if the machine stops."""
    descriptor, name = tempfile.mkstemp(prefix=".", suffix=".tmp", dir=path.parent)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(name, path)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(name)
        raise
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)
