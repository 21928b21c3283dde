//! How often the bits of a design change, in the netlist from which its text is printed.
//!
//! The netlist's simulator counts them: a program of Verilator that does so has 40 MB of C++ for the default datapath.

use super::constants::places;
use raypath_hdl::{Module, Probe, Simulator};
use raypath_tools::{CoverageKind, CoveragePoint};
use raypath_verify::Error;
use std::collections::BTreeMap;
use std::sync::Arc;

/// In each run the bits of all signals with a name in the text, with the number of their changes in all instances of
/// their module. A run has the words of `rst_ni` and of all inputs in each cycle; all bits begin with 0.
///
/// # Errors
/// A module that cannot be simulated.
pub fn toggles(top: &Arc<Module>, runs: &[Vec<Vec<u64>>]) -> Result<Vec<Vec<CoveragePoint>>, Error> {
    let mut simulator = Simulator::observing(top, |_| true)?;
    let places = places(top);
    let modules: BTreeMap<&str, &str> =
        places.iter().flat_map(|(module, paths)| paths.iter().map(|path| (path.as_str(), module.as_str()))).collect();
    let mut signals: Vec<Signal> = Vec::new();
    for (name, width, probe) in simulator.probes() {
        let (path, own) = name.split_at(name.rfind('.').map_or(0, |dot| dot + 1));
        // The words of a memory are in no module, and names of constants, localparams in the text, begin with capitals.
        if let Some(module) = modules.get(path).filter(|_| !own.starts_with(char::is_uppercase)) {
            signals.push(Signal { module, name: own.to_string(), probe, held: 0, changes: vec![0; width as usize] });
        }
    }
    let mut found = Vec::new();
    for run in runs {
        simulator.restart();
        signals.iter_mut().for_each(Signal::restart);
        for (reset, words) in run.iter().filter_map(|frame| frame.split_first()) {
            simulator.set_reset(*reset == 0);
            simulator.set_all(words.iter().copied());
            simulator.cycle();
            signals.iter_mut().for_each(|signal| signal.look(simulator.peek(signal.probe)));
        }
        found.push(points(&signals));
    }
    Ok(found)
}

fn points(signals: &[Signal<'_>]) -> Vec<CoveragePoint> {
    let mut bits: BTreeMap<(&str, String), u64> = BTreeMap::new();
    for Signal { module, name, changes, .. } in signals {
        for (bit, count) in changes.iter().enumerate() {
            let name = if changes.len() == 1 { name.clone() } else { format!("{name}[{bit}]") };
            *bits.entry((module, name)).or_default() += count;
        }
    }
    let point = |((module, name), hits): ((&str, String), u64)| CoveragePoint {
        kind: CoverageKind::Toggle,
        module: module.to_string(),
        line: 0,
        name,
        hits,
    };
    bits.into_iter().map(point).collect()
}

struct Signal<'d> {
    module: &'d str,
    name: String,
    probe: Probe,
    held: u64,
    /// Of each bit.
    changes: Vec<u64>,
}

impl Signal<'_> {
    fn restart(&mut self) {
        self.held = 0;
        self.changes.fill(0);
    }

    fn look(&mut self, value: u64) {
        let mut changed = self.held ^ value;
        self.held = value;
        while changed != 0 {
            self.changes[changed.trailing_zeros() as usize] += 1;
            changed &= changed - 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raypath_hdl::Builder;

    /// Two instances of a register, one of which never loads.
    #[test]
    fn changes_of_all_instances_are_added() {
        let m = Builder::new("held");
        let held = m.register("held_q", 2).reset_to(0);
        held.next_when(m.input("load_i", 1), m.input("value_i", 2));
        m.output("held_o", held.wire());
        let held = m.finish().expect("a module");
        let m = Builder::new("both");
        let value = m.input("value_i", 2);
        for (name, load) in [("a", m.constant(1, 1)), ("b", m.constant(1, 0))] {
            let held = m.instance(&format!("u_{name}"), &held, &[("load_i", load), ("value_i", value)]);
            m.output(&format!("{name}_o"), held[0]);
        }
        let top = m.finish().expect("a module");
        // Two cycles of a reset, and a value that follows its port by a cycle.
        let frames: Vec<Vec<u64>> = (0..12).map(|cycle| vec![u64::from(cycle > 1), cycle % 2]).collect();
        for points in toggles(&top, &[frames.clone(), frames]).expect("a netlist") {
            let hits = |name: &str| points.iter().find(|it| it.module == "held" && it.name == name).map(|it| it.hits);
            assert_eq!((hits("held_q[0]"), hits("held_q[1]")), (Some(8), Some(0)), "{points:?}");
        }
    }
}
