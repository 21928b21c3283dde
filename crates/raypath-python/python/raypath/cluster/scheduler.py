"""Clients of Dask schedulers: one on this machine, one by its address, or one whose workers are jobs of Slurm."""

from __future__ import annotations

import asyncio
import contextlib
import importlib
import logging
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable

from raypath.cluster.errors import ClusterError

CONNECT_SECONDS = 10.0

IGNORE_INTERRUPTS = "import signal\nsignal.signal(signal.SIGINT, signal.SIG_IGN)\n"
"""What workers on this machine run first: Ctrl-C is for the driver, which then ends them."""


@dataclass(frozen=True)
class Choice:
    """Where to run.

    ``scheduler`` is "local", "slurm", or an address such as "tcp://10.0.0.1:8786". ``workers`` is the number of
    workers to start, for the first two. ``slurm`` are keyword arguments of ``dask_jobqueue.SLURMCluster``. ``tls`` are
    the files of the authority, the certificate and the key of this client, for an address ``tls://...``.
    """

    scheduler: str
    workers: int
    slurm: dict[str, Any]
    tls: tuple[Path, Path, Path] | None = None


@contextlib.contextmanager
def connection(choice: Choice) -> Iterator[Callable[[], Any]]:
    """A function that makes a client, again and again if connections are lost.

    Its first call starts the workers, if there are workers to start; they end with the context. It raises
    ``ConnectionError`` if the scheduler does not answer, and ``ClusterError`` if a library is missing, the address is
    none, or workers cannot be started.
    """
    started: list[Any] = []

    def connect() -> Any:
        client = library("distributed").Client
        address: Any = choice.scheduler
        if address in ("local", "slurm"):
            if not started:
                started.append(_local(choice.workers) if address == "local" else _slurm(choice))
            address = started[0]
        try:
            return client(address, timeout=CONNECT_SECONDS, set_as_default=False, security=_security(choice))
        except (OSError, asyncio.TimeoutError) as problem:
            raise ConnectionError(f"--scheduler {choice.scheduler}: {problem}") from problem
        except ValueError as problem:
            raise ClusterError(
                f"--scheduler {choice.scheduler}: {problem}; expected an address such as tcp://10.0.0.1:8786, "
                "local or slurm"
            ) from problem

    try:
        yield connect
    finally:
        for cluster in started:
            cluster.close()


def _security(choice: Choice) -> Any:
    """The encryption of a connection; None where the address asks for none."""
    if choice.tls is None:
        return None
    ca, certificate, key = (str(path) for path in choice.tls)
    security = library("distributed").Security
    return security(tls_ca_file=ca, tls_client_cert=certificate, tls_client_key=key, require_encryption=True)


def library(name: str) -> Any:
    """A library that raypath itself does not need. Raises ``ClusterError`` if it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError as problem:
        raise ClusterError(f"{name}: {problem}; help: pip install {name.replace('_', '-')}") from problem


def _local(workers: int) -> Any:
    count = workers or os.cpu_count() or 1
    return library("distributed").LocalCluster(
        n_workers=count,
        threads_per_worker=1,
        processes=True,
        dashboard_address=":0",
        memory_limit=0,
        silence_logs=logging.CRITICAL,
        preload=[IGNORE_INTERRUPTS],
    )


def _slurm(choice: Choice) -> Any:
    jobqueue = library("dask_jobqueue")
    defaults = {"cores": 1, "processes": 1, "memory": "2GiB"}
    try:
        cluster = jobqueue.SLURMCluster(**{**defaults, **choice.slurm})
        cluster.scale(choice.workers or 1)
    except (OSError, RuntimeError, TypeError, ValueError) as problem:
        raise ClusterError(f"Slurm: {problem}") from problem
    return cluster
