//! The slowest paths, by OpenSTA: its script, and the parser of its output.

use crate::library::Library;
use crate::structural::registers;
use raypath_tools::ToolError;

/// Names of the files in OpenSTA's folder.
pub const NETLIST: &str = "netlist.v";
pub const LIBRARY: &str = "cells.lib";
pub const SCRIPT: &str = "script.tcl";
pub const LOG: &str = "sta.log";

/// A path as OpenSTA prints it.
#[derive(Debug, Clone, PartialEq)]
pub struct RawPath {
    /// Pins, with the arrival time at each in nanoseconds: `g3_r17/Q`, `g4_u5/x12/Y`, or a port.
    pub points: Vec<(String, f64)>,
    /// The arrival time at the last pin.
    pub arrival: f64,
    /// The set-up time of the register at the end; 0 at a port.
    pub setup: f64,
}

const MARK: &str = "raypath paths:";

/// The commands for OpenSTA. Ports switch at the clock edge, resets are false paths, the clock and wires are ideal.
/// `ends` are the sets of endpoints: the registers of a group, or the output ports.
pub fn script(top: &str, library: &Library, period: f64, ends: &[Option<usize>]) -> String {
    let mut lines = begin(top, period).to_vec();
    lines.extend([
        format!("set_driving_cell -lib_cell {} [all_inputs]", library.buffer),
        format!("set_load {} [all_outputs]", library.load),
        "set_false_path -from [get_ports rst_ni]".to_string(),
    ]);
    for (number, end) in ends.iter().enumerate() {
        lines.push(format!("puts \"{MARK} {number}\""));
        let to = match end {
            Some(group) => format!("[get_cells {}]", registers(*group)),
            None => "[all_outputs]".to_string(),
        };
        lines.push(format!("report_checks -path_delay max -digits 4 -to {to}"));
    }
    lines.push("exit".to_string());
    lines.join("\n") + "\n"
}

/// The commands that read a design and constrain its ports.
pub fn begin(top: &str, period: f64) -> [String; 7] {
    [
        format!("read_liberty {LIBRARY}"),
        format!("read_verilog {NETLIST}"),
        format!("link_design {top}"),
        "set_cmd_units -time ns -capacitance fF".to_string(),
        format!("create_clock -name clk -period {period} [get_ports clk_i]"),
        "set_input_delay 0 -clock clk [all_inputs]".to_string(),
        "set_output_delay 0 -clock clk [all_outputs]".to_string(),
    ]
}

/// The slowest path to each set of endpoints, as [`script`] requested it; None where there is no path. `ends` is the
/// number of sets.
pub fn paths(output: &str, ends: usize) -> Result<Vec<Option<RawPath>>, ToolError> {
    let last_lines = || {
        let lines: Vec<&str> = output.lines().rev().take(5).map(beginning).collect();
        format!("\"{}\"", lines.into_iter().rev().collect::<Vec<_>>().join("\n"))
    };
    let mut found = Vec::new();
    for (number, part) in output.split(MARK).skip(1).enumerate() {
        let path = part.strip_prefix(&format!(" {number}\n")).and_then(path);
        found.push(path.ok_or_else(|| ToolError::unexpected("sta", last_lines(), "a path"))?);
    }
    if found.len() != ends {
        return Err(ToolError::unexpected("sta", last_lines(), format!("paths to {ends} sets of ends")));
    }
    Ok(found)
}

/// At most 200 characters of a line, for messages.
fn beginning(line: &str) -> &str {
    line.char_indices().nth(200).map_or(line, |(end, _)| &line[..end])
}

/// Parses one report. None if it cannot be parsed, `Some(None)` if it reports no path.
fn path(report: &str) -> Option<Option<RawPath>> {
    if report.contains("No paths found") {
        return Some(None);
    }
    let (mut points, mut arrival, mut setup) = (Vec::new(), None, 0.0);
    for line in report.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            // Pins before the arrival are on the path; those after it are on the clock's path.
            [_, time, "^" | "v", pin, cell] if arrival.is_none() && cell.starts_with('(') => {
                points.push((pin.to_string(), number(time)?));
            }
            [time, "data", "arrival", "time"] if arrival.is_none() => arrival = Some(number(time)?),
            [time, _, "library", "setup", "time"] => setup = -number(time)?,
            _ => {}
        }
    }
    arrival.filter(|_| !points.is_empty()).map(|arrival| Some(RawPath { points, arrival, setup }))
}

/// A finite number.
pub fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|time: &f64| time.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Recorded output: a register to a register through a unit and a gate; a register that is never set; a register to
    /// a port; a port to a register.
    const RECORDED: &str = include_str!("../tests/data/opensta-2.0.17.log");

    fn pins(path: &RawPath) -> Vec<(&str, f64)> {
        path.points.iter().map(|(pin, ns)| (pin.as_str(), *ns)).collect()
    }

    #[test]
    fn recorded_paths() {
        let found = paths(RECORDED, 4).expect("paths");
        let [Some(inner), None, Some(leaving), Some(entering)] = &found[..] else { panic!("{found:?}") };
        let expected =
            [("g0_r0/CLK", 0.0), ("g0_r0/Q", 0.1598), ("g1_u1/x0/Y", 0.2093), ("x2/Y", 0.2485), ("g1_r3/D", 0.2485)];
        assert_eq!((pins(inner), inner.arrival, inner.setup), (expected.to_vec(), 0.2485, 0.1626));
        let expected = [("g2_r4/CLK", 0.0), ("g2_r4/Q", 0.3756), ("c_o", 0.3756)];
        assert_eq!((pins(leaving), leaving.arrival, leaving.setup), (expected.to_vec(), 0.3756, 0.0));
        let expected = [("a_i", 0.0075), ("g0_r0/D", 0.0075)];
        assert_eq!((pins(entering), entering.arrival, entering.setup), (expected.to_vec(), 0.0075, 0.1919));
    }

    #[test]
    fn other_output_is_an_error() {
        // OpenSTA exits with success after errors, so that missing paths are the only sign of one.
        let fails = |output: &str, ends| paths(output, ends).expect_err("an error").to_string();
        assert!(fails("Error: cannot read file cells.lib.\n", 1).contains("cannot read file cells.lib."));
        assert!(fails(RECORDED, 5).contains("expected paths to 5 sets"));
        let cut = RECORDED.split("data arrival").next().unwrap_or_default();
        assert!(fails(cut, 1).contains("expected a path"));
        assert!(fails("raypath paths: 1\nNo paths found.\n", 1).contains("expected a path"));
        for time in ["inf", "NaN", "1e999"] {
            assert!(fails(&RECORDED.replace("0.2485", time), 4).contains("expected a path"), "{time}");
        }
    }
}
