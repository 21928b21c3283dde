"""``examples/device``: the device in Verilator, and its registers, rings and driver under faults."""

import os
import subprocess
import sys
from pathlib import Path

EXAMPLE = Path(__file__).parents[3] / "examples/device"


def test_the_device_traces_rays_as_the_model(tmp_path: Path) -> None:
    """Undisturbed, within a region, with a memory that stops, and after a flush."""
    command = [sys.executable, str(EXAMPLE / "trace.py"), str(tmp_path)]
    found = subprocess.run(command, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout + found.stderr
    assert "400 rays: every hit is the model's" in found.stdout
    assert found.stdout.splitlines()[-1] == "after a flush: all hits are the model's"


def test_registers_and_rings_survive_faults() -> None:
    """The registers are PeakRDL's, and the driver loses no record, whatever memory and software do."""
    command = [str(EXAMPLE / "run.sh"), "300"]
    found = subprocess.run(
        command, env={**os.environ, "PYTHON": sys.executable}, capture_output=True, text=True, check=False
    )
    said = found.stdout + found.stderr
    # The model needs libraypath; the tests of the C API run it.
    assert found.returncode == 0 or found.stderr.startswith("model: not run"), said
    for part in ("registers", "data 128"):
        assert part in found.stdout, said
