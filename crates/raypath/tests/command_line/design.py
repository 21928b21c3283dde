"""Checks the constraints, the component of IP-XACT and the card of a design against its SystemVerilog.

design.py FOLDER MODULE PERIOD: the folder that `raypath generate` wrote, with card.json and the printed text in
generate.txt. The ports come from the text of the module, the meaning of the constraints from Tcl with procedures that
record their calls, and from OpenSTA.
"""

import collections
import json
import pathlib
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

folder, module, period = pathlib.Path(sys.argv[1]), sys.argv[2], float(sys.argv[3])


def ports_of(name):
    text = (folder / f"rtl/{name}.sv").read_text()
    parameters, header = re.search(rf"^module {name} (?:#\((\n.*?)\n\) )?\(\n(.*?)\n\);", text, re.S | re.M).groups()
    found = re.findall(r"^  (input|output) +logic +(?:\[([^:]+):0\] +)?(\w+),?(?: +//.*)?$", header, re.M)
    assert len(found) == sum(not line.strip().startswith("//") for line in header.splitlines())
    # The defaults of parameters, of which widths are sums.
    values = {"clog2": lambda number: (number - 1).bit_length()}
    for parameter in re.sub(r"//.*", "", parameters or "").replace("\n", " ").split(","):
        if assigned := re.search(r"(\w+) += (.*)", parameter):
            value = re.sub(r"\d*'b?(?=\d)", "0b", assigned[2]).replace("$", "")
            value = re.sub(r"(\(.*\)) +\? (.*) : (.*)", r"\2 if \1 else \3", value)
            values[assigned[1]] = eval(value, values)
    return {port: (direction, eval(left or "0", values) + 1) for direction, left, port in found}


def run(program, script, name):
    (folder / name).write_text(script)
    output = subprocess.run([program, name], cwd=folder, text=True, capture_output=True, check=True)
    assert "rror" not in output.stdout + output.stderr, output.stdout + output.stderr
    return output.stdout


ports = ports_of(module)
inputs, outputs = ({port for port, (side, _) in ports.items() if side == kind} for kind in ("input", "output"))
outside = 0.3 * period

# Constraints: each port but the clock has both delays once, and each other command is expected.
RECORD = r"""
proc get_ports {names} { return $names }
proc get_clocks {names} { return $names }
proc unknown {args} { puts [string map {\n " "} $args] }
source %s
"""
gated = (folder / "rtl/raypath_clock_gate.sv").exists()
for kind in ["sdc", "xdc"]:
    calls = run("tclsh", RECORD % f"{module}.{kind}", "record.tcl").splitlines()
    assert calls.pop(0).split() == ["create_clock", "-name", "clk_i", "-period", f"{period:g}", "clk_i"], calls
    if kind == "sdc" and gated:
        assert calls.pop() == "set_clock_gating_check -setup 0 -hold 0 clk_i", calls
    assert calls.pop() == "set_false_path -fall_from rst_ni", calls
    delays = collections.Counter()
    for call in calls:
        command, clock, end, value, names = re.fullmatch(r"(\w+) (-clock clk_i) (-m\w\w) (\S+) {(.*)}", call).groups()
        assert abs(float(value) - (outside if end == "-max" else 0)) < 1e-3, call
        for name in names.split():
            port = name.removesuffix("[*]")
            assert name.endswith("[*]") == (ports[port][1] > 1), name
            delays[command, end, port] += 1
    expected = {("set_input_delay", port) for port in inputs - {"clk_i"}} | {("set_output_delay", port) for port in outputs}
    assert delays == {(command, end, port): 1 for command, port in expected for end in ("-min", "-max")}, kind

# OpenSTA finds the ports of each pattern: a delay for every bit.
declared = [f"{side} [{width - 1}:0] {port};" if width > 1 else f"{side} {port};" for port, (side, width) in ports.items()]
(folder / "ports.v").write_text(f"module {module} ({', '.join(ports)});\n" + "\n".join(declared) + "\nendmodule\n")
sta = f"read_verilog ports.v\nlink_design {module}\nsource {module}.sdc\nwrite_sdc written.sdc\nexit\n"
run("sta", sta, "sta.tcl")
written = (folder / "written.sdc").read_text()
bits = {side: sum(ports[port][1] for port in names) for side, names in [("input", inputs), ("output", outputs)]}
assert len(re.findall(r"set_input_delay .* -max ", written)) == bits["input"] - 1
assert len(re.findall(r"set_output_delay .* -max ", written)) == bits["output"]
assert re.search(r"set_false_path\\?\s+-fall_from \[get_ports {rst_ni}\]", written)

# IP-XACT: the ports of the module; interfaces on ports that exist; files that exist, all of the list.
NAMESPACE = {"x": "http://www.accellera.org/XMLSchema/IPXACT/1685-2014"}
component = ElementTree.parse(folder / f"{module}.xml").getroot()
find = component.findall
text = component.findtext
assert component.tag == f"{{{NAMESPACE['x']}}}component"
assert [text(f"x:{part}", namespaces=NAMESPACE) for part in ("vendor", "library", "name")] == ["user.org", "user", module]
stated = {}
for port in find("x:model/x:ports/x:port", NAMESPACE):
    left = port.findtext("x:wire/x:vectors/x:vector/x:left", "0", NAMESPACE)
    direction = port.findtext("x:wire/x:direction", None, NAMESPACE)
    stated[port.findtext("x:name", None, NAMESPACE)] = (direction + "put", int(left) + 1)
assert stated == ports
interfaces = {}
for interface in find("x:busInterfaces/x:busInterface", NAMESPACE):
    maps = interface.findall(".//x:portMap", NAMESPACE)
    names = [[side.findtext("x:name", None, NAMESPACE) for side in pair] for pair in maps]
    interfaces[interface.findtext("x:name", None, NAMESPACE)] = dict(names)
axi = {port.removeprefix("m_axi_").upper(): port for port in ports if port.startswith("m_axi_")}
assert interfaces.pop("clk") == {"CLK": "clk_i"} and interfaces.pop("rst") == {"RST": "rst_ni"}
assert interfaces == ({"m_axi": {"ACLK": "clk_i", "ARESETn": "rst_ni", **axi}} if axi else {})
files = [name.text for name in find("x:fileSets/x:fileSet/x:file/x:name", NAMESPACE)]
assert all((folder / name).is_file() for name in files), files
assert files == (folder / f"{module}.f").read_text().split() + [f"{module}.sdc", f"{module}.xdc"]

# The card: the ports and units of the text, the time and flip-flops that `generate` measured and printed.
card, printed = json.loads((folder / "card.json").read_text()), (folder / "generate.txt").read_text()
named = {port["name"]: (port["direction"], port["width"]) for port in card["ports"]}
assert named == ports_of(card["module"]) and len(named) == len(card["ports"])


def units_below(name):
    """The units in a module and below it, by the instances in the text. A loop has the parts of a divider between the
    first and the last."""
    found = collections.Counter()
    body = (folder / f"rtl/{name}.sv").read_text().split("\n);", 1)[1]
    for below in re.findall(r"^ +(raypath\w*) (?:#\((?:[^()]|\([^()]*\))*\)\s+)?u_\w+ \(", body, re.M):
        unit = re.fullmatch(r"raypath_fp_(\w+)", below)
        found += collections.Counter({unit[1]: 1}) if unit else units_below(below)
    loop = r"localparam logic \[31:0\] Parts += (\d+);.*for \(genvar k = 0; k < Parts - 1; k\+\+\)"
    if loop := re.search(loop, body, re.S):
        [first] = [unit for unit in found if unit.endswith(f"_part_1_of_{loop[1]}")]
        between = range(2, int(loop[1]))
        found += collections.Counter(first.replace("_1_of_", f"_{part}_of_") for part in between)
    return found


assert card["units"] == units_below(card["module"]), (card["units"], units_below(card["module"]))
assert all(card[field] is None for field in card["absent"]) and None not in card["absent"].values()
assert {field for field, value in card.items() if value is None} == set(card["absent"])
if card["latency_cycles"] is None:
    assert re.search(rf"\| all .*\| {card['register_bits']} +\| {card['memory_bits']} +\|", printed), printed
else:
    measured = re.search(r"Measured at the ports: latency (\d+) cycles, initiation interval (\d+)", printed)
    assert [card["latency_cycles"], card["interval_cycles"]] == [int(number) for number in measured.groups()]
    opcodes = re.search(r"Opcodes: (.*)\.", (folder / "rtl/raypath.sv").read_text())[1]
    assert {f"{figures['opcode']} {name}" for name, figures in card["operations"].items()} == set(opcodes.split(", "))
