"""The pictures of ``examples/queries``: by the functional model, and by the Verilated RTL, equal to the pixel."""

import os
import subprocess
import sys
from pathlib import Path

EXAMPLE = Path(__file__).parents[3] / "examples/queries"


def test_the_rtl_draws_the_pictures_of_the_model(tmp_path: Path) -> None:
    """Hits, and the verdicts of shaders about late and reordered candidates, are the model's."""
    subprocess.run([sys.executable, EXAMPLE / "draw.py", tmp_path, "20x15"], check=True, capture_output=True)
    # cocotb is installed beside the interpreter of the system, as its users have it.
    system = Path(sys.base_prefix) / "bin/python3"
    path = os.pathsep.join(part for part in os.environ["PATH"].split(os.pathsep) if not part.startswith(sys.prefix))
    environment = {name: value for name, value in os.environ.items() if name != "VIRTUAL_ENV"} | {"PATH": path}
    command = [system, EXAMPLE / "run.py", tmp_path]
    found = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout + found.stderr
    for name in ("leaves", "spheres"):
        assert f"{name}-rtl.png is {name}.png" in found.stdout
    assert (tmp_path / "leaves.png").read_bytes() != (tmp_path / "spheres.png").read_bytes()
