"""How a command is divided into shards, and the commands that merge their results."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from raypath.cluster import program
from raypath.cluster.errors import ClusterError
from raypath.cluster.shard import Shard
from raypath.cluster.store import digest_of_file

COMMANDS = ("verify", "explore", "search", "render")

RESERVED = ("--shard", "--part", "--merge")
"""Options that the division itself sets."""

TIMING = (
    "--timed",
    "--memory-latency",
    "--clock",
    "--sweep",
    "--report",
    "--konata",
    "--window-jobs",
    "--window-from",
)
"""Options with a value of the simulated timing, which is one for the whole result."""

WHOLE = {
    "verify": ("--out",),
    "explore": ("--out", "--budget", "--batch"),
    "search": ("--out", "--truth"),
    "render": ("--out", "--heatmap", "--rays-in-flight", *TIMING),
}
"""Options with a value that matter to the whole result only: shards do not get them, so that they share results."""

WHOLE_FLAGS = ("--json", "--no-timing")
"""The same, without a value."""

TOOLS = {
    "explore": (("yosys", "-V"), ("sta", "-version")),
    "verify": (("yosys", "-V"),),
}
"""Commands that print versions of the programs that a result depends on."""

DEFAULT_LIBRARY = Path("/usr/share/qflow/tech/osu018/osu018_stdcells.lib")
"""The cell library of ``explore`` without ``--liberty``."""


@dataclass(frozen=True)
class Part:
    """Work that is merged on its own: an item of ``verify``, or a command. ``name`` is that of the item."""

    name: str | None
    shards: tuple[Shard, ...]


@dataclass(frozen=True)
class Plan:
    """A command, its division, and the program that computes and merges it."""

    command: str
    arguments: tuple[str, ...]
    parts: tuple[Part, ...]
    program: Path

    @property
    def shards(self) -> list[Shard]:
        """All shards."""
        return [shard for part in self.parts for shard in part.shards]

    def merge(self, complete: list[Part], folder: Path) -> list[str]:
        """The command that merges the results in a folder. ``complete`` are the parts that have all results."""
        arguments = list(self.arguments)
        if len(complete) < len(self.parts):
            names = [part.name for part in self.parts]
            left = [word for word in arguments if word not in names]
            arguments = [part.name for part in complete if part.name is not None] + left
        return [str(self.program), self.command, *arguments, "--merge", str(folder)]


def plan(
    command: str,
    arguments: list[str],
    shards: int,
    threads: int,
    path: Path,
    is_given: bool,
) -> Plan:
    """Divides a command into ``shards`` shards: each item of ``verify``, or the command.

    ``is_given`` says whether the user named the program, which workers then find at the same path. Raises
    ``ClusterError`` if the command cannot be divided.
    """
    for word in arguments:
        if word.split("=")[0] in RESERVED:
            raise ClusterError(f"{word.split('=')[0]}: this option is for one machine; help: --shards N divides here")
    own = _without_whole(command, arguments)
    items: list[str | None] = [None]
    if command == "verify":
        items = list(_items(path, own))
        own = [word for word in own if word not in items]
    words, files = _with_absolute_paths(own)
    if command == "explore" and "--liberty" not in own and DEFAULT_LIBRARY.is_file():
        files[str(DEFAULT_LIBRARY)] = digest_of_file(DEFAULT_LIBRARY)
    versions = tuple(_version(tool) for tool in TOOLS.get(command, ()))
    digest = program.digest(path)

    def shard(item: str | None, number: int) -> Shard:
        name = [] if item is None else [item]
        return Shard(
            (command, *name, *words),
            f"{number}/{shards}",
            tuple(sorted(files.items())),
            versions,
            str(path) if is_given else None,
            digest,
            threads,
        )

    numbers = range(1, shards + 1)
    parts = tuple(Part(item, tuple(shard(item, number) for number in numbers)) for item in items)
    return Plan(command, tuple(arguments), parts, path)


def _without_whole(command: str, arguments: list[str]) -> list[str]:
    """The arguments without those that matter to the whole result only."""
    left = []
    words = iter(arguments)
    for word in words:
        if word in WHOLE[command]:
            next(words, None)
        elif command == "render" and word == "--hits":
            # Whether there are hits matters, and not where they are written.
            next(words, None)
            left += ["--hits", "hits.txt"]
        elif word.split("=")[0] not in WHOLE[command] and word not in WHOLE_FLAGS:
            left.append(word)
    return left


def _items(path: Path, arguments: list[str]) -> list[str]:
    """The items that ``raypath verify`` would run; it also checks the arguments."""
    listed = subprocess.run([str(path), "verify", *arguments, "--list"], capture_output=True, text=True, check=False)
    if listed.returncode != 0:
        raise ClusterError(listed.stderr.strip())
    return [line for line in listed.stdout.splitlines() if line and not line.startswith(" ")]


def _with_absolute_paths(arguments: list[str]) -> tuple[list[str], dict[str, str]]:
    """The arguments with the paths of existing files made absolute, and the digests of these files."""
    files: dict[str, str] = {}
    words = []
    for word in arguments:
        option, equals, value = word.partition("=") if word.startswith("--") else ("", "", word)
        path = Path(value)
        if value and path.is_file():
            value = str(path.absolute())
            files[value] = digest_of_file(path)
        words.append(f"{option}{equals}{value}" if option else value)
    return words, files


def _version(command: tuple[str, ...]) -> str:
    """What a program prints as its version; that it is missing, if it is."""
    if shutil.which(command[0]) is None:
        return f"{command[0]}: none"
    found = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    return f"{command[0]}: {found.stdout.strip()}"
