"""The files and the text of a run on many machines are those of one machine."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import Callable

import pytest
from cluster_processes import cluster, files, without_times

Run = Callable[..., tuple[int, str, str]]

PICTURE = ("render", "--size", "40x31", "--ao", "1", "--shadows", "--heatmap", "heat.png", "--hits", "hits.txt")
COMMANDS = [
    ("verify", "campaign", "models", "boxes", "testfloat", "--jobs", "300", "--seed", "5"),
    # The simulation follows the merge.
    (*PICTURE, "--timed", "200", "--sweep", "sweep.svg"),
    # Fewer rows than shards.
    ("render", "--size", "3x2", "--no-timing"),
    ("search", "--out", "found.ivecs", "--metric", "angular", "-k", "3"),
]


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: " ".join(command[:3]))
def test_the_bytes_are_those_of_one_machine(
    command: tuple[str, ...], program: Path, run: Run, address: str, tmp_path: Path
) -> None:
    code, expected, err = run([str(program), *command], tmp_path / "one")
    assert code == 0, err
    words = cluster(program, *command, "--shards", "3", "--scheduler", address)
    code, out, err = run(words, tmp_path / "many")
    assert (code, without_times(out)) == (0, without_times(expected)), err
    assert files(tmp_path / "many") == files(tmp_path / "one")


def test_each_worker_finds_the_installed_program(run: Run, address: str, tmp_path: Path) -> None:
    command = ("verify", "sums", "--jobs", "20")
    code, expected, err = run([sys.executable, "-m", "raypath", *command], tmp_path / "one")
    assert code == 0, err
    words = [sys.executable, "-m", "raypath.cluster", *command, "--shards", "2", "--scheduler", address]
    code, out, err = run(words, tmp_path / "many")
    assert (code, without_times(out)) == (0, without_times(expected)), err


def test_files_are_found_by_their_content(program: Path, run: Run, address: str, tmp_path: Path) -> None:
    """Options of the whole result, and places of files, are no reason to compute a shard again; their content is."""
    folder = tmp_path / "many"
    folder.mkdir()
    mesh = folder / "mesh.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    render = ("--size", "8x8", "--no-timing", "--shards", "2", "--scheduler", address)
    for out, stored in (("a.png", 0), ("b.png", 2)):
        code, _, err = run(cluster(program, "render", "mesh.obj", *render, "--out", out), folder)
        assert code == 0, err
        assert f"{2 - stored} computed, {stored} from the store" in err
    assert (folder / "a.png").read_bytes() == (folder / "b.png").read_bytes()
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n")
    code, _, err = run(cluster(program, "render", "mesh.obj", *render, "--out", "c.png"), folder)
    assert code == 0, err
    assert "2 computed, 0 from the store" in err


@pytest.mark.long
@pytest.mark.parametrize("items", [("testfloat",), ("mutation", "--jobs", "40"), ("control", "unit-proofs")])
def test_long_items_have_the_bytes_of_one_machine(
    items: tuple[str, ...], program: Path, run: Run, address: str, tmp_path: Path
) -> None:
    test_the_bytes_are_those_of_one_machine(("verify", *items), program, run, address, tmp_path)


@pytest.mark.long
@pytest.mark.skipif(shutil.which("yosys") is None or shutil.which("sta") is None, reason="needs Yosys and OpenSTA")
def test_a_sweep_has_the_bytes_of_one_machine(program: Path, run: Run, address: str, tmp_path: Path) -> None:
    test_the_bytes_are_those_of_one_machine(
        ("explore", "--preset", "half", "--preset", "compact", "--json", "--cache", str(tmp_path / "cache")),
        program,
        run,
        address,
        tmp_path,
    )
