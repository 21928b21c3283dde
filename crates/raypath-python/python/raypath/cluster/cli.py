"""The command line of ``python -m raypath.cluster``."""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from raypath.cluster import measure, plan, program
from raypath.cluster.driver import Driver, Outcome
from raypath.cluster.errors import ClusterError
from raypath.cluster.scheduler import Choice, connection
from raypath.cluster.store import Store

EPILOG = """\
All other arguments are those of `raypath COMMAND`, which computes the shards and merges them.
The exit code is that of raypath on one machine: 0, or 1 if a claim does not hold. It is 2 if
something could not run, and 130 after Ctrl-C. The same command then goes on from the store."""


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m raypath.cluster",
        description="Runs a command of raypath on the workers of a Dask scheduler.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="|".join((*plan.COMMANDS, "measure")))
    for name in plan.COMMANDS:
        _add_options(commands.add_parser(name, epilog=EPILOG, allow_abbrev=False))
    measure.add_options(commands.add_parser("measure", allow_abbrev=False))
    return parser


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scheduler", default="local", help="an address, local or slurm [default: local]")
    parser.add_argument(
        "--workers", type=_whole, default=0, help="workers to start, with local or slurm [default: the cores; 1]"
    )
    parser.add_argument("--shards", type=_whole, default=32, help="shards of each item or command [default: 32]")
    parser.add_argument("--threads", type=_whole, default=1, help="threads of a shard [default: 1]")
    parser.add_argument("--store", type=Path, default=Path("build/cluster"), help="the folder of results")
    parser.add_argument("--program", help="the program raypath, at the same path on all workers")
    parser.add_argument(
        "--reconnect", type=float, default=300.0, metavar="SECONDS", help="wait for a lost scheduler [default: 300]"
    )
    parser.add_argument(
        "--tls",
        type=Path,
        nargs=3,
        metavar=("CA", "CERT", "KEY"),
        help="PEM files of the authority, of this client's certificate and of its key, for an address tls://...",
    )
    parser.add_argument(
        "--slurm",
        type=_pair,
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="an argument of dask_jobqueue.SLURMCluster, such as queue=long or walltime=02:00:00",
    )


def _whole(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 1_000_000:
        raise argparse.ArgumentTypeError(f"found '{text}', expected a whole number from 1 to 1000000")
    return int(text)


def _pair(text: str) -> tuple[str, Any]:
    key, equals, value = text.partition("=")
    if not key.isidentifier() or not equals:
        raise argparse.ArgumentTypeError(f"found '{text}', expected KEY=VALUE")
    return key, int(value) if value.isdecimal() else value


def main(words: list[str]) -> int:
    """Runs the command line and returns the exit code."""
    options, arguments = _parser().parse_known_args(words)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        if options.command == "measure":
            if arguments:
                raise ClusterError(f"{arguments[0]}: unexpected argument of measure")
            return measure.run(options)
        return _run(options, arguments)
    except ClusterError as problem:
        print(f"error: {problem}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        kept = (
            ""
            if options.command == "measure"
            else f"; results so far are in {options.store}; the same command goes on from there"
        )
        print(f"stopped{kept}", file=sys.stderr)
        return 130


def _run(options: argparse.Namespace, arguments: list[str]) -> int:
    path = program.find(options.program)
    division = plan.plan(options.command, arguments, options.shards, options.threads, path, options.program is not None)
    store = Store(options.store)
    choice = Choice(options.scheduler, options.workers, dict(options.slurm), _tls(options))
    with connection(choice) as connect:
        outcome = Driver(division.shards, store, connect, options.reconnect).run()
    return _merge(division, outcome, store)


def _tls(options: argparse.Namespace) -> tuple[Path, Path, Path] | None:
    """The files of ``--tls``, which exist. An address ``tls://...`` needs them, and no other takes them."""
    is_encrypted = options.scheduler.startswith("tls://")
    if is_encrypted != (options.tls is not None):
        raise ClusterError(f"--scheduler {options.scheduler}: expected tls://HOST:PORT and --tls, both or neither")
    for path in options.tls or ():
        if not path.is_file():
            raise ClusterError(f"--tls {path}: no such file, expected a PEM file")
    return (options.tls[0], options.tls[1], options.tls[2]) if options.tls else None


def _merge(division: plan.Plan, outcome: Outcome, store: Store) -> int:
    """Merges what is complete, and returns the exit code."""
    complete = [part for part in division.parts if all(shard.key in outcome.results for shard in part.shards)]
    code: int | None = None
    if complete:
        store.folder.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(prefix="merge-", dir=store.folder))
        try:
            for part in complete:
                for number, shard in enumerate(part.shards, start=1):
                    name = f"{part.name or division.command}-{number}.json"
                    (folder / name).write_bytes(outcome.results[shard.key].part_text())
            sys.stdout.flush()
            code = subprocess.run(division.merge(complete, folder), check=False).returncode
        except OSError as problem:
            raise ClusterError(f"{problem.filename or folder}: cannot write: {problem.strerror}") from problem
        finally:
            shutil.rmtree(folder, ignore_errors=True)
    if len(complete) < len(division.parts):
        missing = [part.name or division.command for part in division.parts if part not in complete]
        count = len(outcome.failed)
        text = f"failed shards: {count}; there is no result of {', '.join(missing)}; the same command tries them again"
        print(f"error: {text}", file=sys.stderr)
        is_wrong = any(result.exit_code == 1 for result in outcome.results.values())
        return 1 if code == 1 or is_wrong else 2
    return 2 if code is None else os.EX_SOFTWARE if code < 0 else code
