//! The activity of every net in SAIF, the Switching Activity Interchange Format (IEEE 1801), for other power tools.

use crate::activity::Activity;
use crate::gates::{Gates, NetId};
use crate::netlist::{Direction, Net, Netlist};
use crate::structural;
use std::collections::BTreeMap;
use std::fmt::Write;

/// The names and numbers of the nets of the top module (None), and of each unit by its number in the top module.
type Scopes = BTreeMap<Option<usize>, Vec<(String, NetId)>>;

/// The text of a SAIF file for the structural netlist. Times are in picoseconds; the measured cycles of all streams
/// follow one another.
pub fn text(
    gates: &Gates,
    top: &Netlist,
    units: &BTreeMap<String, Netlist>,
    activity: &Activity,
    period_ns: f64,
    name_of: &dyn Fn(usize) -> String,
) -> String {
    let period = (period_ns * 1000.0).round() as u64;
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write(&mut text, &scopes(gates, top, units), top, (activity, period), name_of);
    text
}

fn scopes(gates: &Gates, top: &Netlist, units: &BTreeMap<String, Netlist>) -> Scopes {
    let names: BTreeMap<&str, _> =
        units.values().chain([top]).map(|netlist| (netlist.module.as_str(), structural::net_names(netlist))).collect();
    let mut scopes = Scopes::new();
    for (name, _, nets) in gates.ports.iter().filter(|(_, direction, _)| *direction == Direction::Input) {
        for (bit, net) in nets.iter().enumerate() {
            let name = if nets.len() > 1 { format!("{name}[{bit}]") } else { name.clone() };
            scopes.entry(None).or_default().push((name, *net));
        }
    }
    for cell in &gates.cells {
        let (scope, netlist, number) = match cell.inner {
            None => (None, Some(top), cell.top),
            Some(inner) => (Some(cell.top), units.get(&top.cells[cell.top].cell), inner),
        };
        let Some(netlist) = netlist else { continue };
        for ((pin, _), net) in gates.logic(cell).outputs.iter().zip(&cell.outputs) {
            let wire = netlist.cells[number].connections.get(pin).and_then(|nets| nets.first());
            if let Some(wire @ Net::Wire(own)) = wire {
                let known = names.get(netlist.module.as_str()).and_then(|names| names.get(wire));
                let name = known.cloned().unwrap_or_else(|| structural::wire_name(*own));
                scopes.entry(scope).or_default().push((name, *net));
            }
        }
    }
    scopes
}

fn write(
    text: &mut String,
    scopes: &Scopes,
    top: &Netlist,
    (activity, period): (&Activity, u64),
    name_of: &dyn Fn(usize) -> String,
) -> std::fmt::Result {
    writeln!(text, "(SAIFILE\n(SAIFVERSION \"2.0\")\n(DIRECTION \"backward\")\n(DIVIDER / )\n(TIMESCALE 1 ps)")?;
    writeln!(text, "(DURATION {})\n(INSTANCE {}", activity.cycles * period, top.module)?;
    for (scope, nets) in scopes {
        if let Some(unit) = scope {
            writeln!(text, " (INSTANCE {}", name_of(*unit))?;
        }
        writeln!(text, "  (NET")?;
        for (name, net) in nets {
            let (toggles, ones) = (activity.toggles[*net as usize], activity.ones[*net as usize]);
            let (low, high) = ((activity.cycles - ones) * period, ones * period);
            let name = name.replace('[', "\\[").replace(']', "\\]");
            writeln!(text, "   ({name} (T0 {low}) (T1 {high}) (TX 0) (TC {toggles}) (IG 0))")?;
        }
        writeln!(text, "  )")?;
        if scope.is_some() {
            writeln!(text, " )")?;
        }
    }
    writeln!(text, ")\n)")
}
