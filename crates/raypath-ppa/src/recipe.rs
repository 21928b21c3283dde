//! The scripts for Yosys and ABC. All designs are synthesised by the same script, so that they can be compared.

use crate::design::Block;
use crate::library::{ClockGateCell, Library};
use raypath_hdl::verilog::CLOCK_GATE;

/// Names of the files in Yosys's folder.
pub const DESIGN: &str = "design.sv";
pub const LIBRARY: &str = "cells.lib";
pub const SCRIPT: &str = "script.ys";
pub const NAMES: &str = "names.json";
pub const NETLIST: &str = "netlist.json";
pub const STATISTICS: &str = "statistics.txt";
pub const ABC_SCRIPT: &str = "abc.script";
pub const ABC_CONSTRAINTS: &str = "abc.constr";

/// The SystemVerilog that Yosys reads.
///
/// A module that Yosys drops at once precedes each unit. Yosys orders equal gates by the numbers of their names, and
/// reuses the numbers of dropped names first. A whole design drops enough names; a unit alone drops none, and its gates
/// come in another order, for which ABC finds areas that differ by up to 8 %. With the names of the dropped module, a
/// unit alone has the same gates as in a design.
pub fn source(block: &Block, library: &Library) -> String {
    if !block.is_unit {
        let gate = library.clock_gate.as_ref().filter(|_| block.has_clock_gates);
        return gate.map(clock_gate).unwrap_or_default() + &block.text;
    }
    let last = NAMES_TO_REUSE;
    let mut text = format!("module names_to_reuse (input a, output y);\n  wire [{last}:0] w;\n  assign w[0] = a;\n");
    for number in 0..last {
        text += &format!("  assign w[{}] = ~w[{number}];\n", number + 1);
    }
    text + &format!("  assign y = w[{last}];\nendmodule\n\n{}", block.text)
}

/// The module of clock gates with the library's cell inside.
fn clock_gate(ClockGateCell { name, clock, enable, output }: &ClockGateCell) -> String {
    let cell =
        format!("(* blackbox *)\nmodule {name} (input {clock}, input {enable}, output {output});\nendmodule\n\n");
    let ports = "(\n  input  logic clk_i,\n  input  logic enable_i,\n  output logic clk_o\n);\n";
    let inside = format!("  {name} u_cell (.{clock} (clk_i), .{enable} (enable_i), .{output} (clk_o));\n");
    format!("{cell}module {CLOCK_GATE} {ports}{inside}endmodule\n\n")
}

const NAMES_TO_REUSE: usize = 5000;

/// The commands for Yosys. All but units is flattened. Flip-flops have neither enables nor synchronous resets, so that
/// their multiplexers count as gates in every library.
pub fn yosys(block: &Block, library: &Library) -> String {
    let top = &block.module;
    let mut lines = vec![
        format!("read_verilog -sv -DSYNTHESIS {DESIGN}"),
        format!("hierarchy -check -top {top}"),
        format!("synth -top {top} -flatten"),
    ];
    if !block.is_unit {
        // The next command drops names, which tell the register of each flip-flop.
        lines.push(format!("write_json {NAMES}"));
    }
    lines.extend([
        "opt -purge".to_string(),
        "dfflegalize -cell $_DFF_P_ x -cell $_DFF_PN?_ x".to_string(),
        "opt -nodffe -nosdff".to_string(),
        "splitnets".to_string(),
        "rename -wire".to_string(),
        format!("dfflibmap -liberty {LIBRARY}"),
        "opt -nodffe -nosdff".to_string(),
        format!("abc -liberty {LIBRARY} -script {ABC_SCRIPT} -constr {ABC_CONSTRAINTS}"),
        "setundef -zero".to_string(),
        "splitnets".to_string(),
        "opt_clean -purge".to_string(),
    ]);
    if let Some(tie) = &library.tie {
        let ((one, one_pin), (zero, zero_pin)) = (&tie.one, &tie.zero);
        lines.push(format!("hilomap -singleton -hicell {one} {one_pin} -locell {zero} {zero_pin}"));
    }
    lines.extend([format!("tee -o {STATISTICS} stat -top {top} -liberty {LIBRARY}"), format!("write_json {NETLIST}")]);
    lines.join("\n") + "\n"
}

/// The commands for ABC: mapping for area, and for a delay of `period` nanoseconds.
pub fn abc(period: f64) -> String {
    let picoseconds = (period * 1000.0).round();
    [
        "strash",
        "ifraig",
        "scorr",
        "dc2",
        "strash",
        "dch -f",
        &format!("map -B 0.9 -D {picoseconds}"),
        "topo",
        "buffer -c -N 24",
        &format!("upsize -D {picoseconds}"),
        &format!("dnsize -D {picoseconds}"),
        "stime -p",
        "",
    ]
    .join("\n")
}

/// The drivers of inputs and the loads of outputs for ABC.
pub fn constraints(library: &Library) -> String {
    format!("set_driving_cell {}\nset_load {}\n", library.buffer, library.load)
}
