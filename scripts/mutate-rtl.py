#!/usr/bin/env python3
# SPDX-License-Identifier: MIT OR Apache-2.0
"""Puts faults into the hand-written modules and shows which ones their properties do not refute.

mutate-rtl.py [COUNT [SEED [MODULE...]]]: COUNT (24) faults of one token in each module; prints each survivor.
It needs the Python package pyosys, and yosys-abc. A survivor is equivalent, not decided in a minute, or about what no property says: check it
with the lockstep test of the cache, examples/device/run.sh or examples/device/trace.py.
"""

import pathlib
import random
import re
import subprocess
import sys
import tempfile

CRATES = pathlib.Path(__file__).resolve().parents[1] / "crates"
RTL = CRATES / "raypath-traversal/src/system/rtl"
PROPERTIES = CRATES / "raypath-verify-traversal/src/system"
BELOW = [CRATES / "raypath-hdl/src/verilog/raypath_ram_1r1w.sv",
         CRATES / "raypath-traversal/src/hardware/raypath_queue.sv"]
# The cycles in which a fault must be refuted.
CYCLES = {"arbiter": 24, "guard": 20, "cache": 18, "rings": 12}
# What a token becomes; a function of its match, where the token has parts.
TOKENS = [(r" & ", " | "), (r" \| ", " & "), (r"~(?=[\w(])", ""), (r"(?<=[=(&|] )(?=\w+_q\b)", "~"), (r" == ", " != "),
          (r" != ", " == "), (r" \+ ", " - "), (r" - ", " + "), (r" < ", " <= "), (r" >= ", " > "), (r" && ", " || "),
          (r"(?<=<= )'0", "'1"), (r"1'b0", "1'b1"), (r"1'b1", "1'b0"), (r" \? ", " & 1'b0 ? "),
          (r"(?<='d)\d+(?=\b)", lambda match: str(int(match.group()) ^ 1)), (r"\bif \(", "if (!"),
          (r"(?<=[ ;])\w+_q(\[[^\n]*?\])? +<= [^;?]*?;", ";")]
GRAPH = """read_verilog -sv -formal problem.sv
hierarchy -check -top TOP
proc
flatten
memory
delete -port o:*
opt_clean
setundef -undriven -anyseq
async2sync
chformal -lower
opt_clean
techmap
opt
setundef -undriven -anyseq
dffunmap
opt_clean
aigmap
opt_clean
write_aiger -zinit -B problem.aig
"""
RUN = ("import sys\nfrom pyosys import libyosys\ndesign = libyosys.Design()\n"
       "for line in open('script'):\n    libyosys.run_pass(line.strip(), design)\n")


def mutants(text):
    """All texts with one fault, each with a description; parameters and checks of them stay."""
    begin = text.index(");\n", text.index("rst_ni"))
    for pattern, replacement in TOKENS:
        for match in re.finditer(pattern, text[begin:]):
            new = replacement(match) if callable(replacement) else replacement
            at, end = begin + match.start(), begin + match.end()
            line_begin, line_end = text.rfind("\n", 0, at) + 1, text.find("\n", end)
            if not re.search(r"localparam|\$error|logic |unused|^\s*//|for \(|if \(\w+ [!=]= \d+\) begin", text[line_begin:line_end]):
                line = f"{text[line_begin:at]}[{text[at:end]} => {new}]{text[end:line_end]}"
                yield f"{text.count(chr(10), 0, at) + 1}: {' '.join(line.split())}", text[:at] + new + text[end:]


def check(name, text):
    """Whether the properties are refuted: yes, no, or an error of Yosys, which refuses a fault such as a loop."""
    properties = (PROPERTIES / f"{name}.sv").read_text().split("  // Lemmas.")[0].rsplit("endmodule", 1)[0]
    below = "".join(path.read_text() for path in BELOW)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "problem.sv").write_text(f"{below}{text}{properties}  initial assume (!rst_ni);\nendmodule\n")
        (folder / "script").write_text(GRAPH.replace("TOP", f"raypath_{name}_properties"))
        run = {"cwd": folder, "capture_output": True, "text": True}
        if subprocess.run([sys.executable, "-c", RUN], **run).returncode:
            return "refused"
        commands = f"read_aiger problem.aig; fold; strash; orpos; scleanup; trim; bmc3 -F {CYCLES[name]} -T 60; print_status"
        status = subprocess.run(["yosys-abc", "-q", commands], **run).stdout
    return "refuted" if "Status = 0" in status else "survives"


def main(count=24, seed=1, *names):
    for name in names or CYCLES:
        text = (RTL / f"raypath_{name}.sv").read_text()
        if check(name, text) != "survives":
            sys.exit(f"mutate-rtl.py: found a refuted property of raypath_{name} without a fault, expected none")
        every = list(mutants(text))
        found = {"refuted": 0, "refused": 0, "survives": 0}
        for description, faulty in random.Random(int(seed)).sample(every, min(int(count), len(every))):
            result = check(name, faulty)
            found[result] += 1
            if result == "survives":
                print(f"raypath_{name}.sv:{description}", flush=True)
        print(f"raypath_{name}: {found} of {len(every)} faults", flush=True)


main(*sys.argv[1:])
