//! nextpnr's report: the use of the device, the clock, the slowest path, and the slowest path to each stage.

use crate::netlist::stage;
use crate::report::{Step, Use};
use raypath_tools::ToolError;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What is kept of nextpnr's report.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Timing {
    pub clock_mhz: f64,
    /// Nanoseconds to the slowest end in each stage, without the end's setup.
    pub slowest: BTreeMap<String, f64>,
    pub path: Vec<Step>,
    pub routing_ns: f64,
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
}

#[derive(Deserialize)]
struct RawPin {
    cell: String,
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
pub(crate) fn parse(json: &str) -> Result<Timing, ToolError> {
    let unexpected = |found: String| ToolError::unexpected("nextpnr", found, "a report with a clock and its path");
    let raw: Raw = serde_json::from_str(json).map_err(|problem| unexpected(problem.to_string()))?;
    let clock = raw.fmax.values().map(|clock| clock.achieved).reduce(f64::min);
    let path = raw.critical_paths.iter().find(|path| path.from.starts_with(CLOCKED) && path.from == path.to);
    let (Some(clock_mhz), Some(path)) = (clock, path) else { return Err(unexpected("no clock".to_string())) };
    let mut slowest: BTreeMap<String, f64> = BTreeMap::new();
    for net in raw.detailed_net_timings.iter().filter(|net| net.event.starts_with(CLOCKED)) {
        for end in net.endpoints.iter().filter(|end| end.event.starts_with(CLOCKED)) {
            let most = slowest.entry(stage(&end.cell)).or_default();
            *most = most.max(end.delay[1]);
        }
    }
    let used = raw.utilization.into_iter().filter(|(kind, _)| SHOWN.contains(&kind.as_str())).collect();
    let routing_ns = path.path.iter().filter(|step| step.net.is_some()).map(|step| step.delay).sum();
    Ok(Timing { clock_mhz, slowest, path: steps(&path.path), routing_ns, used })
}

/// The kinds of resources that reports have.
const SHOWN: [&str; 6] = ["TRELLIS_COMB", "TRELLIS_FF", "TRELLIS_RAMW", "MULT18X18D", "DP16KD", "TRELLIS_IO"];

/// The signals on a path, each with the time at which it is settled at its last reader on the path.
fn steps(path: &[RawStep]) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    let mut ns = 0.0;
    for (index, step) in path.iter().enumerate() {
        ns += step.delay;
        let is_last = index + 1 == path.len();
        let name = match &step.net {
            Some(net) => plain(net),
            None if index == 0 => plain(&step.from.cell),
            None if is_last => plain(&step.to.cell),
            None => continue,
        };
        match steps.last_mut() {
            Some(last) if last.signal == name => last.ns = ns,
            _ => steps.push(Step { signal: name.to_string(), ns }),
        }
    }
    steps
}

/// The name of the nearest signal of the text: synthesis appends the cells between, such as `_LUT4_Z_D`.
fn plain(name: &str) -> &str {
    let cells = ["_LUT4", "_CCU2C", "_PFUMX", "_L6MUX21", "_TRELLIS", "_MULT18X18D", "_DP16KD", "$CCU2"];
    let end = cells.iter().filter_map(|cell| name.find(cell)).min();
    &name[..end.unwrap_or(name.len())]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A report of nextpnr 0.11.1 on two registered products of 18 bits, shortened to one net of each kind.
    const RECORDED: &str = include_str!("../tests/data/nextpnr-0.11.1-report.json");

    #[test]
    fn recorded_report() {
        let timing = parse(RECORDED).expect("a report");
        assert!((timing.clock_mhz - 142.816).abs() < 0.001, "{}", timing.clock_mhz);
        let signals: Vec<&str> = timing.path.iter().map(|step| step.signal.as_str()).collect();
        assert_eq!(signals, ["u_stage_1.a_q", "u_stage_1.a_q[14]", "u_stage_1.p_q"]);
        // 0.525 out of the register, 1.291 on a wire, 3.927 in the multiplier, 1.259 on a wire.
        let ns = timing.path.last().expect("a step").ns;
        assert!((ns - 7.002).abs() < 0.001 && (1000.0 / ns - timing.clock_mhz).abs() < 0.01, "{ns}");
        assert!((timing.routing_ns - 2.55).abs() < 0.001, "{}", timing.routing_ns);
        assert_eq!(timing.used["MULT18X18D"], Use { used: 2, available: 28 });
        assert_eq!(timing.used.len(), SHOWN.len());
        // The names have no datapath. The net from a pin does not count.
        assert_eq!(timing.slowest.keys().collect::<Vec<_>>(), ["shell"]);
        assert!((timing.slowest["shell"] - 7.002).abs() < 0.001, "{:?}", timing.slowest);
    }

    #[test]
    fn another_form_is_an_error() {
        for text in ["", "{}", r#"{"critical_paths": [], "fmax": {}, "utilization": {}}"#] {
            assert!(parse(text).is_err(), "{text}");
        }
    }
}
