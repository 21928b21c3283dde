"""Builds the output of `raypath generate --unit` and traces the rays of a picture: python3 run.py FOLDER.

FOLDER has the files of `generate --unit`, scene.bin, rays.txt and hits.txt. The hits go to rtl-hits.txt there."""

import os
import pathlib
import sys
import warnings

warnings.filterwarnings("ignore", "Python runners")
from cocotb.runner import check_results_file, get_runner

TOP = "raypath_unit_axi"
here = pathlib.Path(__file__).parent.resolve()
folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "build/unit").resolve()
listed = (folder / f"{TOP}.f").read_text().split()

sys.path.insert(0, str(here))
os.environ["PYTHONPATH"] = os.pathsep.join(sys.path)
os.environ["RAYPATH_UNIT"] = str(folder)
# Most of the time of a run is Python's: C++ without optimisation compiles in a fraction of the time.
os.environ["MAKEFLAGS"] = "OPT_FAST=-O0 OPT_SLOW=-O0 OPT_GLOBAL=-O0"
runner = get_runner("verilator")
arguments = ["-O3", "--x-assign", "0", "--output-split", "1000000000", "--no-public-flat-rw", str(here / "ports.vlt")]
runner.build(sources=[folder / name for name in listed], hdl_toplevel=TOP, build_args=arguments,
             build_dir=folder / "cocotb", timescale=("1ns", "1ps"))
results = runner.test(hdl_toplevel=TOP, test_module="test_unit", build_dir=folder / "cocotb")
check_results_file(results)
