"""Faults, with real processes: nothing is lost, and nothing is counted twice."""

from __future__ import annotations

import os
import signal
import subprocess
from collections import Counter
from pathlib import Path
from typing import Callable

import pytest
from cluster_processes import Dask, Wrapped, cluster, files, is_running, results, wait_until, without_times

Run = Callable[..., tuple[int, str, str]]
Start = Callable[..., "subprocess.Popen[str]"]

SUMS = ("verify", "sums", "--jobs", "2000")
DIVIDED = ("--shards", "4")


@pytest.fixture
def one(program: Path, run: Run, tmp_path: Path) -> str:
    """What one machine prints."""
    code, out, _ = run([str(program), *SUMS], tmp_path / "one")
    assert code == 0
    return without_times(out)


def test_a_worker_is_killed_in_the_middle_of_a_shard(
    program: Path, start: Start, dask: Dask, one: str, tmp_path: Path
) -> None:
    slow = Wrapped(tmp_path, program, before='[ "$shard" = 2/4 ] && [ ! -e killed ] && sleep 60')
    # The second time the shard runs as usual.
    slow.path.write_text(slow.path.read_text().replace("-e killed", f"-e {tmp_path}/killed"))
    dask.start()
    driver = start(cluster(slow.path, *SUMS, *DIVIDED, "--scheduler", dask.address), tmp_path / "many")
    wait_until("shard 2/4 runs", lambda: "2/4" in [shard for shard, *_ in slow.log("begin")])
    [(process, worker)] = [rest for shard, *rest in slow.log("begin") if shard == "2/4"]
    (tmp_path / "killed").touch()
    os.kill(int(worker), signal.SIGKILL)
    out, err = driver.communicate(timeout=60)
    assert (driver.returncode, without_times(out)) == (0, one), err
    assert "4 of 4 shards: 4 computed, 0 from the store, 0 wrong, 0 failed" in err
    assert Counter(shard for shard, *_ in slow.log("begin"))["2/4"] == 2
    assert not is_running(process), "the killed worker has left a process"


def test_the_scheduler_is_restarted(program: Path, start: Start, dask: Dask, one: str, tmp_path: Path) -> None:
    slow = Wrapped(tmp_path, program, before=f'[ "$shard" = 3/4 ] && [ ! -e {tmp_path}/restarted ] && sleep 60')
    dask.start()
    driver = start(cluster(slow.path, *SUMS, *DIVIDED, "--scheduler", dask.address), tmp_path / "many")
    wait_until("shard 3/4 runs", lambda: "3/4" in [shard for shard, *_ in slow.log("begin")])
    wait_until("two results are stored", lambda: len(results(tmp_path / "many")) >= 2)
    (tmp_path / "restarted").touch()
    dask.scheduler.kill()
    dask.scheduler.wait()
    dask.start()
    out, err = driver.communicate(timeout=60)
    assert (driver.returncode, without_times(out)) == (0, one), err
    assert "4 of 4 shards: 4 computed, 0 from the store, 0 wrong, 0 failed" in err
    begun = Counter(shard for shard, *_ in slow.log("begin"))
    # What was stored is not computed again; 4/4 had not begun.
    assert begun == {"1/4": 1, "2/4": 1, "3/4": 2, "4/4": 1}


def test_a_wrong_shard_is_reported_once_and_the_rest_goes_on(
    program: Path, run: Run, address: str, tmp_path: Path
) -> None:
    # The wrapped program makes a failure of the claim: in the part, in the output and in the exit code.
    spoil = r"""[ "$shard" = 2/3 ] && code=1 && echo '  wrong    sum 7: 1, expected 2' &&
sed -i 's/\\"shown\\":\[\],\\"failures\\":0/\\"shown\\":[[7,\\"sum 7: 1, expected 2\\"]],\\"failures\\":1/' part.json"""
    wrong = Wrapped(tmp_path, program, after=spoil)
    command = cluster(wrong.path, "verify", "sums", "boxes", "--jobs", "600", "--shards", "3", "--scheduler", address)
    code, out, err = run(command, tmp_path / "many")
    assert code == 1, err
    assert "6 of 6 shards: 6 computed, 0 from the store, 2 wrong, 0 failed" in err
    for item in ("sums", "boxes"):
        repeat = f"raypath verify {item} --jobs 600 --shard 2/3"
        assert err.count(f"wrong: {repeat}") == err.count(f"  to repeat it: {repeat}") == 1
    assert out.count("  wrong    sum 7: 1, expected 2\n") == out.count("  result   WRONG\n") == 2
    # The results are stored, and the report is the same.
    code, again, err = run(command, tmp_path / "many")
    assert (code, without_times(again)) == (1, without_times(out))
    assert "0 computed, 6 from the store, 2 wrong, 0 failed" in err


def test_a_shard_that_crashes_is_reported_and_tried_again_next_time(
    program: Path, run: Run, address: str, one: str, tmp_path: Path
) -> None:
    crash = tmp_path / "crash"
    crash.touch()
    crashing = Wrapped(tmp_path, program, before=f'[ "$shard" = 2/4 ] && [ -e {crash} ] && kill -SEGV $$')
    command = cluster(crashing.path, *SUMS, *DIVIDED, "--scheduler", address)
    code, out, err = run(command, tmp_path / "many")
    assert (code, out) == (2, "")
    assert err.count("failed: raypath verify sums --jobs 2000 --shard 2/4:\nraypath was killed by signal 11") == 1
    assert "3 computed, 0 from the store, 0 wrong, 1 failed" in err
    assert "error: failed shards: 1; there is no result of sums" in err
    crash.unlink()
    code, out, err = run(command, tmp_path / "many")
    assert (code, without_times(out)) == (0, one), err
    assert "1 computed, 3 from the store, 0 wrong, 0 failed" in err


def test_damaged_results_are_computed_again(program: Path, run: Run, address: str, one: str, tmp_path: Path) -> None:
    command = cluster(program, *SUMS, *DIVIDED, "--scheduler", address)
    assert run(command, tmp_path / "many")[0] == 0
    flipped, shortened, emptied, kept = results(tmp_path / "many")
    before = {path: path.read_bytes() for path in (flipped, shortened, emptied, kept)}
    flipped.write_bytes(before[flipped][:-9] + bytes([before[flipped][-9] ^ 1]) + before[flipped][-8:])
    shortened.write_bytes(before[shortened][:200])
    emptied.write_bytes(b"")
    code, out, err = run(command, tmp_path / "many")
    assert (code, without_times(out)) == (0, one), err
    assert "3 computed, 1 from the store, 0 wrong, 0 failed" in err
    for path in (flipped, shortened, emptied):
        name = path.relative_to(tmp_path / "many")
        assert err.count(f"{name}: the content does not have the digest in its first line") == 1
    code, out, err = run(command, tmp_path / "many")
    assert (code, without_times(out)) == (0, one), err
    assert "0 computed, 4 from the store" in err


def on_a_small_disk(command: list[str], size: str, folder: str) -> list[str]:
    """The command with a file system of this size at a folder, which it alone sees; it prints what is left there."""
    script = f'mkdir -p {folder} && mount -t tmpfs -o size={size} tmpfs {folder} && "$@"; code=$?; '
    script += f"find {folder} -type f -exec wc -c {{}} +; exit $code"
    return ["unshare", "--map-root-user", "--mount", "sh", "-c", script, "sh", *command]


@pytest.fixture
def needs_mounts() -> None:
    """Skips where the system allows no mounts of one's own."""
    mount = ["unshare", "--map-root-user", "--mount", "mount", "-t", "tmpfs", "tmpfs", "/mnt"]
    if subprocess.run(mount, capture_output=True, check=False).returncode != 0:
        pytest.skip("unshare: this system allows no mounts")


@pytest.mark.usefixtures("needs_mounts")
def test_the_disk_of_the_store_is_full(program: Path, run: Run, address: str, tmp_path: Path) -> None:
    # Some results of this render fit, and not all.
    render = ("render", "--size", "128x128", "--no-timing", "--shards", "8", "--scheduler", address)
    code, out, err = run(on_a_small_disk(cluster(program, *render), "20k", "build/cluster"), tmp_path / "many")
    assert code == 2, err
    assert "build/cluster/results/" in err
    assert "cannot write: No space left on device" in err
    left = [line.split() for line in out.splitlines() if "build/cluster" in line]
    assert len(left) > 0, out
    assert all(int(size) > 1000 and not Path(name).name.startswith(".") for size, name in left), out
    assert not (tmp_path / "many/build/image.png").exists()


@pytest.mark.usefixtures("needs_mounts")
def test_the_disk_of_a_worker_is_full(program: Path, run: Run, tmp_path: Path) -> None:
    scratch = tmp_path / "scratch"
    render = ("render", "--size", "128x128", "--no-timing", "--shards", "1", "--workers", "1")
    command = ["env", f"TMPDIR={scratch}", *cluster(program, *render)]
    code, _, err = run(on_a_small_disk(command, "100k", str(scratch)), tmp_path / "many")
    assert code == 2, err
    assert "part.json: cannot write: No space left on device" in err
    assert results(tmp_path / "many") == []


def test_ctrl_c_leaves_nothing_broken(program: Path, run: Run, start: Start, one: str, tmp_path: Path) -> None:
    slow = Wrapped(tmp_path, program, before=f'[ "$shard" = 3/4 ] && [ ! -e {tmp_path}/stopped ] && sleep 60')
    command = cluster(slow.path, *SUMS, *DIVIDED, "--workers", "1")
    driver = start(command, tmp_path / "many")
    wait_until("shard 3/4 runs", lambda: "3/4" in [shard for shard, *_ in slow.log("begin")])
    wait_until("two results are stored", lambda: len(results(tmp_path / "many")) >= 2)
    # As a terminal does: the signal goes to all processes.
    os.killpg(driver.pid, signal.SIGINT)
    _, err = driver.communicate(timeout=60)
    assert driver.returncode == 130, err
    assert "stopped; results so far are in build/cluster" in err
    assert "Traceback" not in err
    [(process, _)] = [rest for shard, *rest in slow.log("begin") if shard == "3/4"]
    wait_until("the shard has ended", lambda: not is_running(process))
    (tmp_path / "stopped").touch()
    stored = len(results(tmp_path / "many"))
    code, out, err = run(command, tmp_path / "many")
    assert (code, without_times(out)) == (0, one), err
    assert f"{4 - stored} computed, {stored} from the store" in err


def test_a_cancelled_shard_ends_on_a_worker_that_stays(program: Path, start: Start, dask: Dask, tmp_path: Path) -> None:
    slow = Wrapped(tmp_path, program, before="sleep 60")
    dask.start()
    driver = start(cluster(slow.path, *SUMS, *DIVIDED, "--scheduler", dask.address), tmp_path / "many")
    wait_until("a shard runs", lambda: len(slow.log("begin")) > 0)
    driver.send_signal(signal.SIGINT)
    driver.communicate(timeout=60)
    assert driver.returncode == 130
    wait_until("the shard has ended", lambda: not is_running(slow.log("begin")[0][1]))
    assert len(slow.log("begin")) == 1
    assert files(tmp_path / "many") == {}
