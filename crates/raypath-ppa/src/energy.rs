//! The energy of a transition at each pin, by OpenSTA: its script, and the parser of its output.
//!
//! OpenSTA 2.0.17 overwrites the activities of pins by propagated ones, and charges each transition with the energies
//! of a rising and a falling edge together (`Power::findInternalPower`). This module therefore takes what OpenSTA
//! computes from the library, its slews and loads: the internal energy of each edge at each pin, the energy of charging
//! each load, and leakage. The activity is applied to these.

use crate::Error;
use crate::gates::Gates;
use crate::library::Library;
use crate::structural;
use crate::timing::{begin, number};
use raypath_tools::ToolError;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// The version of OpenSTA whose messages this module parses.
pub const VERSION: &str = "OpenSTA 2.0.17";

/// The clock period of the script in nanoseconds. All pins have one transition per period, so that the activities are
/// exact, although OpenSTA prints three digits. No energy depends on it.
const PERIOD: f64 = 10.0;

/// The time that a clock edge takes at each flip-flop, in nanoseconds.
const CLOCK_SLEW: f64 = 0.1;

/// The energies of a cell.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct CellEnergy {
    /// Energy inside the cell for a transition at each input, in femtojoules, as the mean of both edges.
    pub inputs: Vec<f64>,
    /// The same for each output; as the mean over the inputs that may have caused it.
    pub outputs: Vec<f64>,
    /// Energy for charging or discharging the load of each output, in femtojoules.
    pub loads: Vec<f64>,
    /// Leakage in nanowatts.
    pub leakage: f64,
}

/// The energies of all cells of a design.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Energies {
    /// In the order of [`Gates::cells`].
    pub cells: Vec<CellEnergy>,
    /// The supply voltage of the outputs.
    pub volts: f64,
}

/// The commands for OpenSTA: ports, loads and drivers as for timing.
pub fn script(top: &str, library: &Library) -> String {
    let lines = [
        // Not the clock, which has no tree: one buffer would drive all flip-flops, whose energy rises with the slew.
        "foreach port [all_inputs] {".to_string(),
        "  if {[get_property $port full_name] eq \"clk_i\"} { continue }".to_string(),
        format!("  set_driving_cell -lib_cell {} $port", library.buffer),
        "}".to_string(),
        format!("set_input_transition {CLOCK_SLEW} [get_ports clk_i]"),
        format!("set_load {} [all_outputs]", library.load),
        "set_power_activity -global -activity 1 -duty 0.5".to_string(),
        "sta::set_debug power 3".to_string(),
        "set power [sta::design_power [sta::cmd_corner]]".to_string(),
        "sta::set_debug power 0".to_string(),
        format!("puts \"{TOTALS} [lindex $power 1] [lindex $power 2]\""),
        "exit".to_string(),
    ];
    [&begin(top, PERIOD)[..], &lines].concat().join("\n") + "\n"
}

/// Before OpenSTA's sums of switching and leakage power, in watts.
const TOTALS: &str = "raypath power:";

/// The energies of all cells, and the supply voltage, from OpenSTA's output.
///
/// # Errors
/// Output of another form; a cell without energies; sums that differ from OpenSTA's.
pub fn energies(output: &str, gates: &Gates) -> Result<Energies, Error> {
    let unexpected = |found: String, expected: &str| ToolError::unexpected("sta", found, expected);
    let mut reader = Reader::new(gates);
    let mut totals = None;
    for line in output.lines() {
        if let Some(line) = line.strip_prefix("power:") {
            reader.line(line).ok_or_else(|| unexpected(format!("'{}'", line.trim()), "a message about power"))?;
        } else if let Some(line) = line.strip_prefix(TOTALS) {
            totals = line.trim().split_once(' ').and_then(|(a, b)| Some((number(a)?, number(b)?)));
        }
    }
    reader.end_pin();
    let last = output.lines().last().unwrap_or_default().chars().take(200).collect::<String>();
    let (switching, leakage) = totals.ok_or_else(|| unexpected(format!("'{last}'"), "the power of the design"))?;
    if let Some(cell) = reader.seen.iter().position(|seen| !seen) {
        let name = structural_name(gates, cell);
        return Err(unexpected(format!("no power of {name}"), "that of every cell").into());
    }
    let leakages = reader.cells.iter().map(|cell| cell.leakage).sum::<f64>() * 1e-9;
    for (what, theirs, ours) in [("switching", switching, reader.switching), ("leakage", leakage, leakages)] {
        if (ours - theirs).abs() > 0.01 * theirs.abs() {
            return Err(
                unexpected(format!("{what} power of {theirs} W"), &format!("{ours} W, the sum of cells")).into()
            );
        }
    }
    let of_cell = |cell: &CellEnergy| [&cell.inputs[..], &cell.outputs, &cell.loads, &[cell.leakage]].concat();
    if !(reader.cells.iter().flat_map(of_cell).all(f64::is_finite) && reader.volts.is_finite()) {
        return Err(unexpected("an energy beyond all numbers".to_string(), "finite energies").into());
    }
    Ok(Energies { cells: reader.cells, volts: reader.volts })
}

fn structural_name(gates: &Gates, cell: usize) -> String {
    gates.name(&gates.cells[cell], &|top| format!("cell {top}"))
}

struct Reader<'g> {
    gates: &'g Gates,
    /// The cell at each place in the top module and in its unit.
    places: HashMap<(usize, Option<usize>), usize>,
    cells: Vec<CellEnergy>,
    seen: Vec<bool>,
    /// The cell that the messages are about.
    cell: Option<usize>,
    /// Its pin, whose energies follow.
    pin: Option<Pin>,
    /// Of the pin: the energies of both edges together, a number for each group of the library.
    sum: f64,
    edges: u32,
    /// The energy of charging the load of the pin whose message follows.
    load: f64,
    /// Leakage by conditions, if the library has no other.
    conditional: f64,
    volts: f64,
    /// The sum of OpenSTA's switching power, in watts.
    switching: f64,
}

#[derive(Debug, Clone, Copy)]
enum Pin {
    Input(usize),
    Output(usize),
    /// The state of a flip-flop, or a supply.
    Other,
}

impl<'g> Reader<'g> {
    fn new(gates: &'g Gates) -> Self {
        let places = gates.cells.iter().enumerate().map(|(index, cell)| ((cell.top, cell.inner), index)).collect();
        let none = |cell: &crate::gates::Cell| CellEnergy {
            inputs: vec![0.0; cell.inputs.len()],
            outputs: vec![0.0; cell.outputs.len()],
            loads: vec![0.0; cell.outputs.len()],
            leakage: 0.0,
        };
        let cells = gates.cells.iter().map(none).collect();
        let seen = vec![false; gates.cells.len()];
        Self {
            gates,
            places,
            cells,
            seen,
            cell: None,
            pin: None,
            sum: 0.0,
            edges: 0,
            load: 0.0,
            conditional: 0.0,
            volts: 0.0,
            switching: 0.0,
        }
    }

    /// Reads a message. None if it has another form than expected.
    fn line(&mut self, line: &str) -> Option<()> {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            ["switching", _, "activity", "=", activity, "volt", "=", volts, watts] => {
                self.end_pin();
                self.volts = number(volts)?;
                self.switching += number(watts)?;
                // Of a load, per transition: power over transitions per second.
                self.load = number(watts)? / number(activity)? * 1e15;
            }
            ["internal", path, _] => {
                self.end_pin();
                self.begin_pin(path)?;
            }
            ["^" | "v", "energy", "=", joules, "*", ..] => {
                self.sum += number(joules)? * 1e15;
                self.edges += 1;
            }
            ["leakage", "cell" | "default", _, watts] => self.cells[self.cell?].leakage = number(watts)? * 1e9,
            ["leakage", _, .., watts, "*", share] => {
                self.conditional += number(watts)? * number(share)? * 1e9;
                self.cells[self.cell?].leakage = self.conditional;
            }
            // The load in other units, the head of the columns, and the sums of a group.
            ["cap", ..] | ["when", ..] | [_, "->", ..] => {}
            _ => return None,
        }
        Some(())
    }

    fn begin_pin(&mut self, path: &str) -> Option<()> {
        let (path, pin) = path.rsplit_once('/')?;
        let (top, inner) = match path.split_once('/') {
            Some((top, inner)) => (top, Some(structural::cell_index(inner)?)),
            None => (path, None),
        };
        let cell = *self.places.get(&(structural::cell_index(top)?, inner))?;
        let logic = self.gates.logic(&self.gates.cells[cell]);
        let input = logic.inputs.iter().position(|name| name == pin).map(Pin::Input);
        let output = || logic.outputs.iter().position(|(name, _)| name == pin).map(Pin::Output);
        self.conditional = 0.0;
        self.seen[cell] = true;
        self.cell = Some(cell);
        self.pin = Some(input.or_else(output).unwrap_or(Pin::Other));
        Some(())
    }

    fn end_pin(&mut self) {
        let (sum, edges) = (std::mem::take(&mut self.sum), std::mem::take(&mut self.edges));
        let mean = if edges > 0 { sum / f64::from(edges) } else { 0.0 };
        let (Some(cell), Some(pin)) = (self.cell, self.pin.take()) else { return };
        match pin {
            Pin::Input(input) => self.cells[cell].inputs[input] = mean,
            Pin::Output(output) => {
                self.cells[cell].outputs[output] = mean;
                self.cells[cell].loads[output] = std::mem::take(&mut self.load);
            }
            Pin::Other => {}
        }
    }
}
