"""Encrypted connections: a client without a certificate of the authority is refused."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Callable

from cluster_processes import Dask, cluster


def certificate(folder: Path, name: str) -> list[str]:
    """An authority that signs its own certificate: the paths of authority, certificate and key."""
    folder.mkdir(exist_ok=True)
    key, pem = folder / f"{name}.key", folder / f"{name}.pem"
    subject = ["-subj", f"/CN={name}", "-addext", "subjectAltName=IP:127.0.0.1"]
    options = ["req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-keyout", str(key), "-out", str(pem)]
    subprocess.run(["openssl", *options, *subject], check=True, capture_output=True)
    return [str(pem), str(pem), str(key)]


def test_a_scheduler_with_tls(
    program: Path,
    start: Callable[..., subprocess.Popen[str]],
    run: Callable[..., tuple[int, str, str]],
    tmp_path: Path,
) -> None:
    ours, others = certificate(tmp_path / "tls", "ours"), certificate(tmp_path / "tls", "others")
    dask = Dask(start, tmp_path / "dask", ours)
    dask.start()
    words = ["verify", "sums", "--jobs", "8", "--shards", "1", "--scheduler", dask.address]
    code, out, err = run([*cluster(program, *words), "--tls", *ours], tmp_path / "ours")
    assert code == 0, err
    assert "as claimed" in out
    code, _, err = run([*cluster(program, *words, "--reconnect", "2"), "--tls", *others], tmp_path / "others")
    assert code == 2
    assert f"--scheduler {dask.address}: " in err
