"""The parts of a run, each by itself: plans, the store, workers that differ."""

from __future__ import annotations

import dataclasses
import subprocess
from pathlib import Path

import pytest

from raypath.cluster import plan
from raypath.cluster.cli import main
from raypath.cluster.driver import Driver
from raypath.cluster.errors import ClusterError
from raypath.cluster.plan import Plan
from raypath.cluster.shard import ShardError, compute, private_cache
from raypath.cluster.store import DamagedResultError, Result, Store


def planned(program: Path, command: str, *words: str, shards: int = 3) -> Plan:
    return plan.plan(command, list(words), shards, 1, program, True)


def test_each_item_is_divided(program: Path, tmp_path: Path) -> None:
    found = planned(program, "verify", "--jobs=7", "models", "--out", str(tmp_path), "watertight", "--preset", "credit")
    # The items are in the order in which raypath runs them.
    assert [part.name for part in found.parts] == ["watertight", "models"]
    assert [shard.command for shard in found.parts[0].shards] == [
        f"raypath verify watertight --jobs=7 --preset credit --shard {number}/3" for number in (1, 2, 3)
    ]
    assert len({shard.key for shard in found.shards}) == 6
    whole = ["--jobs=7", "models", "--out", str(tmp_path), "watertight", "--preset", "credit", "--merge", "parts"]
    assert found.merge(list(found.parts), Path("parts"))[1:] == ["verify", *whole]
    rest = ["--jobs=7", "--out", str(tmp_path), "--preset", "credit", "--merge", "parts"]
    assert found.merge([found.parts[0]], Path("parts"))[1:] == ["verify", "watertight", *rest]
    listed = subprocess.run([program, "verify", "--list"], check=True, capture_output=True, text=True).stdout
    assert len(planned(program, "verify").parts) == listed.count("\n  claim ")


def test_options_of_the_whole_result_are_not_those_of_shards(program: Path) -> None:
    keys = [
        {shard.key for shard in planned(program, "render", *words).shards}
        for words in [(), ("--out", "a.png"), ("--out=b.png", "--no-timing"), ("--ao", "1"), ("--hits", "a.txt")]
    ]
    assert keys[0] == keys[1] == keys[2]
    assert not (keys[0] & keys[3])
    assert not (keys[0] & keys[4])
    assert keys[4] == {shard.key for shard in planned(program, "render", "--hits", "b.txt").shards}


def test_wrong_arguments_are_errors(program: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for words, expected in [
        (["render", "--shard", "1/2"], "--shard: this option is for one machine"),
        (["verify", "nothing"], "invalid value 'nothing'"),
        (["verify", "sums", "--scheduler", "nowhere://"], "--scheduler nowhere://: "),
        (["verify", "sums", "--scheduler", "tls://127.0.0.1:1"], "expected tls://HOST:PORT and --tls, both or neither"),
        (["verify", "sums", "--tls", "a", "b", "c"], "--scheduler local: expected tls://HOST:PORT and --tls"),
    ]:
        assert main([words[0], "--program", str(program), *words[1:]]) == 2
        assert expected in capsys.readouterr().err
    assert main(["verify", "--program", "/nowhere"]) == 2
    assert "--program /nowhere: expected a program" in capsys.readouterr().err


def test_workers_that_differ_compute_nothing(program: Path, tmp_path: Path) -> None:
    mesh = tmp_path / "mesh.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    shard = planned(program, "render", str(mesh), "--size", "4x4").shards[0]
    assert compute(shard).exit_code == 0
    with pytest.raises(ClusterError, match=r"the program with SHA-256 .* expected 00"):
        compute(dataclasses.replace(shard, program_digest="00"))
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 9 0\nf 1 2 3\n")
    with pytest.raises(ClusterError, match=r"mesh.obj: a file with SHA-256"):
        compute(shard)
    mesh.unlink()
    with pytest.raises(ClusterError, match=r"mesh.obj: cannot read on .*: No such file"):
        compute(shard)
    with pytest.raises(ShardError, match=r"exit code 2\n(.|\n)*--ao"):
        compute(planned(program, "render", "--ao", "x").shards[0])


def test_a_scheduler_that_stays_away_is_an_error(program: Path, tmp_path: Path) -> None:
    def connect() -> None:
        raise ConnectionError("no machine answers")

    driver = Driver(planned(program, "search").shards, Store(tmp_path), connect, 0)
    with pytest.raises(
        ClusterError, match=r"no machine answers; expected a scheduler within 0 s\. 0 of 3 results are in"
    ):
        driver.run()


def test_a_store_gives_back_what_it_has(tmp_path: Path) -> None:
    store = Store(tmp_path / "store")
    result = Result(1, 0.5, "a host", "wrong\n", b"\n\x1f\x8b\n")
    assert store.get("ab12") is None
    store.put("ab12", {"shard": "1/2"}, result)
    assert store.get("ab12") == result
    # Another result under this name is damage too.
    store.path("cd34").parent.mkdir()
    store.path("ab12").rename(store.path("cd34"))
    with pytest.raises(DamagedResultError, match=r"the result of ab12"):
        store.get("cd34")
    blocked = Store(tmp_path / "file")
    blocked.folder.write_text("")
    with pytest.raises(ClusterError, match=r"file/results/ab/ab12: cannot write: Not a directory"):
        blocked.put("ab12", {}, result)


def test_a_cache_that_others_may_write_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    folder = private_cache()
    assert folder.parent == tmp_path
    assert folder.stat().st_mode & 0o777 == 0o700
    assert private_cache() == folder
    folder.chmod(0o770)
    with pytest.raises(ClusterError, match=r"mode 770, expected a folder of user .* with mode 700"):
        private_cache()
    folder.rmdir()
    folder.symlink_to(tmp_path)
    with pytest.raises(ClusterError, match="expected a folder"):
        private_cache()
