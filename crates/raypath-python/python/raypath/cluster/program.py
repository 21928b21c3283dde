"""The program ``raypath``: where it is, and what identifies it."""

from __future__ import annotations

import functools
import hashlib
import importlib.util
import os
import shutil
import sys
from pathlib import Path

from raypath.cluster.errors import ClusterError
from raypath.cluster.store import digest_of_file


def find(given: str | None) -> Path:
    """The program: the given one, the one beside this Python, or the one on the search path.

    Raises ``ClusterError`` if there is none.
    """
    beside = Path(sys.executable).with_name("raypath")
    found = given or (str(beside) if beside.is_file() else shutil.which("raypath"))
    if found is None:
        raise ClusterError(f"raypath: not found, expected {beside} or a program on PATH; help: name it by --program")
    path = Path(found).absolute()
    if not (path.is_file() and os.access(path, os.X_OK)):
        raise ClusterError(f"--program {found}: expected a program")
    return path


def digest(path: Path) -> str:
    """The SHA-256 that identifies the program; workers must have the same.

    The program of the wheel is a script, whose first line depends on the environment. It is identified by the
    extension module that it calls.
    """
    found = path.stat()
    return _digest(str(path), found.st_size, found.st_mtime_ns)


@functools.lru_cache(maxsize=64)
def _digest(path: str, size: int, modified: int) -> str:
    """The digest of a program, computed again when its size or time has changed."""
    with open(path, "rb") as file:
        is_script = file.read(2) == b"#!"
    if is_script and Path(path).parent == Path(sys.executable).parent:
        module = importlib.util.find_spec("raypath._raypath")
        if module is not None and module.origin is not None:
            return hashlib.sha256(b"wheel " + digest_of_file(Path(module.origin)).encode()).hexdigest()
    return digest_of_file(Path(path))
