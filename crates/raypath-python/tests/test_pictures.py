"""The pictures of ``examples/queries``: by the functional model, and by the Verilated RTL, equal to the pixel."""

import os
import subprocess
import sys
import sysconfig
from pathlib import Path

EXAMPLE = Path(__file__).parents[3] / "examples/queries"


def test_the_rtl_draws_the_pictures_of_the_model(tmp_path: Path) -> None:
    """Hits, and the verdicts of shaders about late and reordered candidates, are the model's."""
    subprocess.run([sys.executable, EXAMPLE / "draw.py", tmp_path, "20x15"], check=True, capture_output=True)
    # cocotb 2 and a Verilator that it reads; the other examples are tested with cocotb 1.9 and that of the system.
    verilator = Path(sysconfig.get_path("purelib")) / "verilator"
    path = f"{verilator / 'bin'}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "VERILATOR_ROOT": str(verilator), "PATH": path}
    command = [sys.executable, str(EXAMPLE / "run.py"), str(tmp_path)]
    found = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout + found.stderr
    for name in ("leaves", "spheres"):
        assert f"{name}-rtl.png is {name}.png" in found.stdout
    assert (tmp_path / "leaves.png").read_bytes() != (tmp_path / "spheres.png").read_bytes()
