//! What Yosys and abc are told: one recipe for every design, so that designs can be compared.

use crate::design::Piece;
use crate::library::Library;

/// Names of the files beside each other while a piece is synthesised.
pub const DESIGN: &str = "design.sv";
pub const LIBRARY: &str = "cells.lib";
pub const SCRIPT: &str = "script.ys";
pub const NAMES: &str = "names.json";
pub const NETLIST: &str = "netlist.json";
pub const STATISTICS: &str = "statistics.txt";
pub const ABC_SCRIPT: &str = "abc.script";
pub const ABC_CONSTRAINTS: &str = "abc.constr";

/// What Yosys reads. Before a unit stands a module that is dropped at once: among equals Yosys goes by the numbers of
/// names, and takes numbers of names that are gone before new ones. In a whole design there are always enough of those,
/// in a unit alone there are none, and its gates come out in another order, for which abc finds areas that differ by up
/// to 8 %. With the names of this module a unit gets the same gates alone as in a design.
pub fn source(piece: &Piece) -> String {
    if !piece.is_unit {
        return piece.text.clone();
    }
    let last = NAMES_TO_REUSE;
    let mut text = format!("module names_to_reuse (input a, output y);\n  wire [{last}:0] w;\n  assign w[0] = a;\n");
    for number in 0..last {
        text += &format!("  assign w[{}] = ~w[{number}];\n", number + 1);
    }
    text + &format!("  assign y = w[{last}];\nendmodule\n\n{}", piece.text)
}

const NAMES_TO_REUSE: usize = 5000;

/// The commands for Yosys. Everything is flattened but units; flip-flops have neither enables nor synchronous resets,
/// so that their multiplexers are counted as gates in every library.
pub fn yosys(piece: &Piece, library: &Library) -> String {
    let top = &piece.module;
    let mut lines = vec![
        format!("read_verilog -sv -DSYNTHESIS {DESIGN}"),
        format!("hierarchy -check -top {top}"),
        format!("synth -top {top} -flatten"),
    ];
    if !piece.is_unit {
        // Names go with the next command; they say which register a flip-flop is.
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
    if let Some(tie) = library.tie() {
        let ((one, one_pin), (zero, zero_pin)) = (&tie.one, &tie.zero);
        lines.push(format!("hilomap -singleton -hicell {one} {one_pin} -locell {zero} {zero_pin}"));
    }
    lines.extend([format!("tee -o {STATISTICS} stat -top {top} -liberty {LIBRARY}"), format!("write_json {NETLIST}")]);
    lines.join("\n") + "\n"
}

/// The commands for abc: mapping for area, and for a delay of `period` nanoseconds.
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

/// What stands around a design for abc.
pub fn constraints(library: &Library) -> String {
    format!("set_driving_cell {}\nset_load {}\n", library.buffer(), library.load())
}
