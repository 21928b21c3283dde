"""Fixtures of the cluster tests."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Callable

import pytest
from cluster_processes import DEADLINE, Dask, processes

from raypath.cluster import program as programs


@pytest.fixture(scope="session")
def program() -> Path:
    """The program raypath: that of RAYPATH_PROGRAM, or the installed one."""
    return programs.find(os.environ.get("RAYPATH_PROGRAM"))


@pytest.fixture
def start() -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Starts processes, and ends those that still run after the test."""
    with processes() as start:
        yield start


@pytest.fixture
def run(start: Callable[..., subprocess.Popen[str]]) -> Callable[..., tuple[int, str, str]]:
    """Runs a command to its end: the exit code, and what it printed to the two outputs."""

    def run(command: list[str], folder: Path) -> tuple[int, str, str]:
        process = start(command, folder)
        out, err = process.communicate(timeout=DEADLINE)
        return process.returncode, out, err

    return run


@pytest.fixture
def dask(start: Callable[..., subprocess.Popen[str]], tmp_path: Path) -> Dask:
    """A scheduler of Dask for one test, not started yet."""
    return Dask(start, tmp_path)


@pytest.fixture(scope="session")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of a scheduler with a worker, for tests that leave both as they are."""
    with processes() as start:
        dask = Dask(start, tmp_path_factory.mktemp("dask"))
        dask.start()
        yield dask.address
