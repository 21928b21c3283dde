"""A campaign as jobs of a real Slurm on this machine."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Callable

import pytest
from cluster_processes import cluster, files, without_times

Run = Callable[..., tuple[int, str, str]]

START = Path(__file__).parents[4] / "scripts/slurm-localhost.sh"


@pytest.mark.long
@pytest.mark.skipif(shutil.which("sbatch") is None, reason="needs slurm-wlm and munge")
def test_slurm_runs_a_campaign(program: Path, run: Run, tmp_path: Path) -> None:
    pytest.importorskip("dask_jobqueue")
    command = ("verify", "campaign", "boxes", "--jobs", "100000")
    code, expected, err = run([str(program), *command], tmp_path / "one")
    assert code == 0, err
    slurm = ("interface=lo", "walltime=00:10:00", f"log_directory={tmp_path / 'logs'}")
    options = [word for pair in slurm for word in ("--slurm", pair)]
    words = cluster(program, *command, "--shards", "8", "--scheduler", "slurm", "--workers", "2", *options)
    code, out, err = run([str(START), *words], tmp_path / "many")
    assert (code, without_times(out)) == (0, without_times(expected)), err
    assert files(tmp_path / "many") == files(tmp_path / "one")
    assert "16 of 16 shards: 16 computed" in err
