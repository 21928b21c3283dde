"""Builds the output of `raypath generate --unit` with Verilator, and runs a cocotb module on it."""

import os
import pathlib
import sys
import warnings

try:  # cocotb 2
    from cocotb_tools.runner import get_results, get_runner
except ImportError:  # cocotb 1.9
    warnings.filterwarnings("ignore", "Python runners")
    from cocotb.runner import get_results, get_runner

TOP = "raypath_unit_axi"
HERE = pathlib.Path(__file__).parent.resolve()


def run(folder, module, *paths):
    """Runs the tests of `module`, which is in one of the folders `paths`, or here. They find the folder in
    RAYPATH_UNIT."""
    listed = [*(folder / f"{TOP}.f").read_text().split(), "raypath_properties.sv"]
    sys.path[:0] = [str(path) for path in (*paths, HERE)]
    os.environ["PYTHONPATH"] = os.pathsep.join(sys.path)
    os.environ["RAYPATH_UNIT"] = str(folder)
    # Most of the time of a run is Python's: C++ without optimisation compiles in a fraction of the time.
    os.environ["MAKEFLAGS"] = "OPT_FAST=-O0 OPT_SLOW=-O0 OPT_GLOBAL=-O0 VM_PARALLEL_BUILDS=0"
    runner = get_runner("verilator")
    arguments = ["-O3", "-fno-inline", "--assert", "--x-assign", "0", "--output-split", "1000000000", "--no-public-flat-rw",
                 str(HERE / "ports.vlt")]
    runner.build(sources=[folder / name for name in listed], hdl_toplevel=TOP, build_args=arguments,
                 build_dir=folder / "cocotb", timescale=("1ns", "1ps"))
    _, failed = get_results(runner.test(hdl_toplevel=TOP, test_module=module, build_dir=folder / "cocotb"))
    if failed:
        sys.exit(f"{failed} tests failed")
