//! nextpnr's report: the use of the device, the clock, the slowest path cell by cell, and the slowest path to each stage.

use crate::netlist::Netlist;
use crate::report::{Step, Use};
use crate::shell::INSTANCE;
use raypath_tools::ToolError;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What is kept of nextpnr's report.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// The fastest clock after routing, in MHz.
    pub clock_mhz: f64,
    /// The period of that clock, in nanoseconds.
    pub period_ns: f64,
    /// The nanoseconds of it that pass in cells.
    pub logic_ns: f64,
    /// The nanoseconds of it that pass on wires.
    pub routing_ns: f64,
    /// The cells between the registers on the slowest path; a carry chain is one.
    pub levels: usize,
    /// The slowest path, from register to register.
    pub path: Vec<Step>,
    /// Nanoseconds to the slowest end in each stage, without the end's setup.
    pub slowest: BTreeMap<String, f64>,
    /// What is used of the device, by nextpnr's names.
    pub used: BTreeMap<String, Use>,
}

#[derive(Deserialize)]
struct Raw {
    critical_paths: Vec<RawPath>,
    #[serde(default)]
    detailed_net_timings: Vec<RawNet>,
    fmax: BTreeMap<String, RawClock>,
    utilization: BTreeMap<String, Use>,
}

#[derive(Deserialize)]
struct RawPath {
    from: String,
    to: String,
    path: Vec<RawStep>,
}

#[derive(Deserialize)]
struct RawStep {
    delay: f64,
    from: RawPin,
    to: RawPin,
    net: Option<String>,
    /// `clk-to-q`, `routing`, `logic` or `setup`.
    #[serde(rename = "type")]
    kind: String,
}

#[derive(Deserialize)]
struct RawPin {
    cell: String,
    port: String,
}

#[derive(Deserialize)]
struct RawNet {
    event: String,
    endpoints: Vec<RawEnd>,
}

#[derive(Deserialize)]
struct RawEnd {
    cell: String,
    event: String,
    /// The shortest and the longest.
    delay: [f64; 2],
}

#[derive(Deserialize)]
struct RawClock {
    achieved: f64,
}

/// What begins and ends at a clock edge, unlike pins.
const CLOCKED: &str = "posedge ";

/// Parses nextpnr's report.
///
/// # Errors
/// Another form, or no path from a clock edge to the next.
pub(crate) fn parse(json: &str, netlist: &Netlist) -> Result<Timing, ToolError> {
    let unexpected = |found: String| ToolError::unexpected("nextpnr", found, "a report with a clock and its path");
    let raw: Raw = serde_json::from_str(json).map_err(|problem| unexpected(problem.to_string()))?;
    let clock = raw.fmax.values().map(|clock| clock.achieved).reduce(f64::min);
    let path = raw.critical_paths.iter().find(|path| path.from.starts_with(CLOCKED) && path.from == path.to);
    let (Some(clock_mhz), Some(path)) = (clock, path) else { return Err(unexpected("no clock".to_string())) };
    let mut slowest: BTreeMap<String, f64> = BTreeMap::new();
    for net in raw.detailed_net_timings.iter().filter(|net| net.event.starts_with(CLOCKED)) {
        for end in net.endpoints.iter().filter(|end| end.event.starts_with(CLOCKED)) {
            let most = slowest.entry(netlist.stage(&end.cell)).or_default();
            *most = most.max(end.delay[1]);
        }
    }
    let used = raw.utilization.into_iter().filter(|(kind, _)| SHOWN.contains(&kind.as_str())).collect();
    let sum = |wires| path.path.iter().filter(|step| step.net.is_some() == wires).map(|step| step.delay).sum();
    let (path, levels) = steps(&path.path, netlist);
    let period_ns = 1000.0 / clock_mhz;
    Ok(Timing { clock_mhz, period_ns, slowest, path, logic_ns: sum(false), routing_ns: sum(true), levels, used })
}

/// The kinds of resources that reports have.
const SHOWN: [&str; 6] = ["TRELLIS_COMB", "TRELLIS_FF", "TRELLIS_RAMW", "MULT18X18D", "DP16KD", "TRELLIS_IO"];

/// The cells and wires on a path, and the number of cells between the registers. A carry chain is one cell.
fn steps(path: &[RawStep], netlist: &Netlist) -> (Vec<Step>, usize) {
    let mut steps: Vec<Step> = Vec::new();
    let (mut at_ns, mut levels, mut carries) = (0.0, 0, 0);
    // The stage is that of the cell that drives a wire.
    let mut stage = String::new();
    for RawStep { delay, from, to, net, kind } in path {
        at_ns += delay;
        let mut step = Step { ns: *delay, at_ns, ..Step::default() };
        if let Some(net) = net {
            if to.port == "FCI" {
                continue;
            }
            let count = netlist.readers(net).map_or(String::new(), |count| format!(" to {count}"));
            (step.what, step.stage) = (format!("wire{count}"), stage.clone());
            step.signal = if plain(net) == net { inside(net) } else { String::new() };
        } else {
            let cell = netlist.cell(&to.cell);
            let name = match (cell.map_or("cell", |cell| &cell.kind), kind.as_str()) {
                // The multiplexer that is in the slice of a lookup table.
                (_, "logic") if to.port.starts_with("OFX") => "PFUMX".to_string(),
                (name, "logic") => name.to_string(),
                (name, end) => format!("{name} {end}"),
            };
            carries = if from.port == "FCI" { carries + 1 } else { 0 };
            if let (1.., Some(last)) = (carries, steps.last_mut()) {
                (last.ns, last.at_ns, last.what) = (last.ns + delay, at_ns, format!("{name}, {} bits", carries + 1));
                continue;
            }
            levels += usize::from(kind == "logic");
            let place = cell.and_then(|cell| netlist.place(cell));
            stage = netlist.stage(&to.cell);
            step.signal = match place {
                Some(_) if !drives_its_name(&to.cell) => String::new(),
                Some(_) => inside(plain(&to.cell)),
                // The state of a machine that Yosys has encoded anew has neither a line nor a name.
                None if kind == "clk-to-q" && !drives_its_name(&to.cell) => {
                    stage = String::new();
                    "a state".to_string()
                }
                None => format!("near {}", inside(plain(&to.cell))),
            };
            step.text = place.map_or(String::new(), |(module, line)| format!("{module}:{line}"));
            (step.what, step.stage) = (name, stage.clone());
        }
        steps.push(step);
    }
    (steps, levels)
}

/// A name without that of the design's instance in the shell.
fn inside(name: &str) -> String {
    name.strip_prefix(INSTANCE).and_then(|rest| rest.strip_prefix('.')).unwrap_or(name).to_string()
}

/// Whether synthesis has named a cell by a signal that is its output. Others have the name of a signal that is near:
/// that of a register without a name of its own may be its reset's.
fn drives_its_name(cell: &str) -> bool {
    let ending = &cell[plain(cell).len()..];
    let outputs = ["_TRELLIS_FF_Q", "_CCU2C_S0", "_CCU2C_S1", "_CCU2C_COUT", "_MULT18X18D_P", "_DP16KD_DO"];
    outputs.iter().any(|output| ending.strip_prefix(output).is_some_and(|rest| !rest.contains(char::is_uppercase)))
}

/// The name of the nearest signal of the text: synthesis appends the cells between, such as `_LUT4_Z_D`.
fn plain(name: &str) -> &str {
    let cells = ["_LUT4", "_CCU2C", "_PFUMX", "_L6MUX21", "_TRELLIS", "_MULT18X18D", "_DP16KD", "$"];
    let end = cells.iter().filter_map(|cell| name.find(cell)).min();
    &name[..end.unwrap_or(name.len())]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A report of nextpnr 0.11.1 on two registered products of 18 bits, shortened to one net of each kind.
    const RECORDED: &str = include_str!("../tests/data/nextpnr-0.11.1-report.json");

    /// A report on 12 bits: a state selects operands of a sum. From nextpnr 0.11.1 and pyosys 0.70, shortened to the
    /// slowest path and its cells.
    const PATH: &str = include_str!("../tests/data/nextpnr-0.11.1-path.json");

    /// A netlist with this JSON of modules, whose text has the stages in lines 1 and 14.
    fn netlist(json: &str) -> Netlist {
        let text = "module raypath_stage_1 (\n".to_string() + &"\n".repeat(12) + "module raypath_stage_2 (\n";
        let stages = ["stage_1", "stage_2"].map(|name| (name.to_string(), format!("raypath_{name}")));
        Netlist::parse(json, "raypath_shell", &text, stages.into(), true).expect("a netlist")
    }

    const EMPTY: &str = r#"{"modules": {"raypath_shell": {}}}"#;

    #[test]
    fn recorded_report() {
        let timing = parse(RECORDED, &netlist(EMPTY)).expect("a report");
        assert!((timing.clock_mhz - 142.816).abs() < 0.001, "{}", timing.clock_mhz);
        // Out of the register, on a wire, in the multiplier, on a wire, into the register.
        let ns: Vec<f64> = timing.path.iter().map(|step| (step.ns * 1000.0).round()).collect();
        assert_eq!(ns, [525.0, 1291.0, 3927.0, 1259.0, 0.0]);
        let at = timing.path.last().expect("a step").at_ns;
        assert!((at - 7.002).abs() < 0.001 && (1000.0 / at - timing.clock_mhz).abs() < 0.01, "{at}");
        assert!((timing.routing_ns - 2.55).abs() < 0.001, "{}", timing.routing_ns);
        assert_eq!(timing.used["MULT18X18D"], Use { used: 2, available: 28 });
        assert_eq!(timing.used.len(), SHOWN.len());
        // The names have no datapath. The net from a pin does not count.
        assert_eq!(timing.slowest.keys().collect::<Vec<_>>(), ["shell"]);
        assert!((timing.slowest["shell"] - 7.002).abs() < 0.001, "{:?}", timing.slowest);
    }

    /// Yosys names the state by its reset, and the sum by the input of stage 2. The path leads through stage 1 only.
    #[test]
    fn recorded_path() {
        let json: serde_json::Value = serde_json::from_str(PATH).expect("JSON");
        let timing = parse(&json["report"].to_string(), &netlist(&json["netlist"].to_string())).expect("a report");
        let rows = timing.path.iter().map(|step| {
            let Step { what, stage, signal, text, ns, .. } = step;
            format!("{what}|{stage}|{signal}|{text}|{ns:.2}")
        });
        let expected = [
            "TRELLIS_FF clk-to-q||a state||0.52",
            "wire||||1.99",
            "LUT4|stage_1|near sum||0.24",
            "wire|stage_1|||0.82",
            "CCU2C, 10 bits|stage_1||raypath_stage_1:10|1.17",
            "wire|stage_1|||0.13",
            "TRELLIS_FF setup|stage_1|sum|raypath_stage_1:10|0.00",
        ];
        assert_eq!(rows.collect::<Vec<_>>(), expected);
        // The last lines of nextpnr's own report: "1.93 ns logic, 2.94 ns routing", "205.30 MHz".
        assert!((timing.logic_ns - 1.93).abs() < 0.005 && (timing.routing_ns - 2.94).abs() < 0.005, "{timing:?}");
        assert!((timing.clock_mhz - 205.30).abs() < 0.005 && timing.levels == 2, "{timing:?}");
    }

    #[test]
    fn another_form_is_an_error() {
        for text in ["", "{}", r#"{"critical_paths": [], "fmax": {}, "utilization": {}}"#] {
            assert!(parse(text, &netlist(EMPTY)).is_err(), "{text}");
        }
    }
}
