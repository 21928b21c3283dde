"""Builds the output of `raypath generate` and runs the tests: python3 run.py FOLDER. SIM selects the simulator."""

import os
import pathlib
import sys
import warnings

try:  # cocotb 2
    from cocotb_tools.runner import get_results, get_runner
except ImportError:  # cocotb 1.9
    warnings.filterwarnings("ignore", "Python runners")
    from cocotb.runner import get_results, get_runner

here = pathlib.Path(__file__).parent.resolve()
folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "build/original").resolve()
listed = (folder / "raypath.f").read_text().split()
simulator = os.environ.get("SIM", "verilator")
arguments = ["-g2012"]
if simulator == "icarus":
    # Icarus Verilog 11 does not read the types of the package.
    listed = ["raypath_plain.sv"]
if simulator == "verilator":
    # The assertions of the control.
    listed.append("raypath_properties.sv")
    # Most of the time of a run is Python's: C++ without optimisation compiles in a fraction of the time.
    os.environ["MAKEFLAGS"] = "OPT_FAST=-O0 OPT_SLOW=-O0 OPT_GLOBAL=-O0 VM_PARALLEL_BUILDS=0"
    arguments = ["-O3", "-fno-inline", "--assert", "--x-assign", "0", "--output-split", "1000000000", "--no-public-flat-rw",
                 str(here / "ports.vlt")]

sys.path.insert(0, str(here))
os.environ["PYTHONPATH"] = os.pathsep.join(sys.path)
runner = get_runner(simulator)
build = folder / "cocotb" / simulator
runner.build(sources=[folder / name for name in listed], hdl_toplevel="raypath", build_args=arguments, build_dir=build,
             timescale=("1ns", "1ps"))
results = runner.test(hdl_toplevel="raypath", test_module="test_raypath", build_dir=build)
if get_results(results)[1]:
    sys.exit("a test failed")
