//! Clock gates of a synthesised netlist.

use crate::library::Library;
use crate::netlist::{Net, Netlist};
use std::collections::HashMap;

/// The most flip-flops behind a clock gate: without a clock tree, the gate itself drives their clock pins.
pub const MAX_FAN_OUT: usize = 32;

/// Repeats each clock gate until none has more flip-flops behind it than [`MAX_FAN_OUT`], as a tool for clock trees
/// does. Each gets the name of a register behind it.
pub fn divide(netlist: &mut Netlist, library: &Library) {
    let Some(gate) = &library.clock_gate else { return };
    let gates: Vec<usize> = (0..netlist.cells.len()).filter(|&cell| netlist.cells[cell].cell == gate.name).collect();
    let mut places: HashMap<Net, Vec<(usize, String)>> = gates
        .iter()
        .filter_map(|&cell| Some((*netlist.cells[cell].connections.get(&gate.output)?.first()?, Vec::new())))
        .collect();
    for (index, cell) in netlist.cells.iter().enumerate() {
        for (pin, nets) in cell.connections.iter().filter(|_| cell.cell != gate.name) {
            if let Some(readers) = nets.first().and_then(|net| places.get_mut(net)) {
                readers.push((index, pin.clone()));
            }
        }
    }
    let wires = netlist.cells.iter().flat_map(|cell| cell.connections.values().flatten());
    let ports = netlist.ports.values().flat_map(|port| &port.bits);
    let mut next =
        wires.chain(ports).filter_map(|net| if let Net::Wire(wire) = net { Some(*wire) } else { None }).max();
    for cell in gates {
        let output = netlist.cells[cell].connections.get(&gate.output).and_then(|nets| nets.first()).copied();
        let mut readers = output.and_then(|output| places.remove(&output)).unwrap_or_default();
        // Registers of one word stay together.
        readers.sort_by(|(a, _), (b, _)| netlist.cells[*a].name.cmp(&netlist.cells[*b].name));
        let parts = readers.len().div_ceil(MAX_FAN_OUT).max(1);
        for (part, readers) in readers.chunks(readers.len().div_ceil(parts).max(1)).enumerate() {
            let name = netlist.cells[readers[0].0].name.clone();
            if part == 0 {
                netlist.cells[cell].name = name;
                continue;
            }
            next = next.map(|wire| wire + 1);
            let Some(wire) = next.map(Net::Wire) else { continue };
            let mut copy = netlist.cells[cell].clone();
            copy.name = name;
            copy.connections.insert(gate.output.clone(), vec![wire]);
            netlist.cells.push(copy);
            for (reader, pin) in readers {
                netlist.cells[*reader].connections.insert(pin.clone(), vec![wire]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::netlist::YosysDesign;
    use std::collections::{BTreeMap, BTreeSet};
    use std::path::Path;

    const LIBRARY: &str = r#"library (l) {
        cell (BUF) { area : 2; pin (A) { direction : input; } pin (Y) { direction : output; function : "A"; } }
        cell (NAND2) { area : 4; pin (A) { direction : input; } pin (B) { direction : input; }
            pin (Y) { direction : output; function : "!(A B)"; } }
        cell (DFF) { area : 16; ff (I, J) { next_state : "D"; clocked_on : "C"; } pin (D) { direction : input; }
            pin (C) { direction : input; } pin (Q) { direction : output; function : "I"; } }
        cell (ICG) { area : 6; clock_gating_integrated_cell : "latch_posedge";
            pin (C) { direction : input; clock_gate_clock_pin : true; }
            pin (E) { direction : input; clock_gate_enable_pin : true; }
            pin (G) { direction : output; clock_gate_out_pin : true; } }
    }"#;

    #[test]
    fn gates_are_repeated_for_many_flip_flops() {
        let library = Library::of(LIBRARY.to_string(), Path::new("l.lib")).expect("a library");
        let flip_flop = |number: usize, clock: usize| {
            let q = 100 + number;
            format!(
                "\"r[{number:03}]\": {{\"type\": \"DFF\", \"connections\": {{\"C\": [{clock}], \"D\": [5], \"Q\": [{q}]}}}}"
            )
        };
        let mut cells: Vec<String> = (0..70).map(|number| flip_flop(number, 6)).collect();
        cells.extend((70..73).map(|number| flip_flop(number, 7)));
        for (name, clock) in [("u", 6), ("v", 7)] {
            let pins = format!("{{\"C\": [4], \"E\": [3], \"G\": [{clock}]}}");
            cells.push(format!("\"{name}\": {{\"type\": \"ICG\", \"connections\": {pins}}}"));
        }
        let json = format!("{{\"modules\": {{\"m\": {{\"cells\": {{{}}}}}}}}}", cells.join(","));
        let mut design: YosysDesign = serde_json::from_str(&json).expect("JSON");
        let (mut netlist, _) = design.take("m").expect("a module");
        divide(&mut netlist, &library);

        let mut behind: BTreeMap<Net, Vec<&str>> = BTreeMap::new();
        for cell in netlist.cells.iter().filter(|cell| cell.cell == "DFF") {
            behind.entry(cell.connections["C"][0]).or_default().push(&cell.name);
        }
        let gates: Vec<_> = netlist.cells.iter().filter(|cell| cell.cell == "ICG").collect();
        let clocks: BTreeSet<Net> = gates.iter().map(|gate| gate.connections["G"][0]).collect();
        assert_eq!((gates.len(), clocks.len()), (4, 4));
        assert!(gates.iter().all(|gate| gate.connections["E"] == [Net::Wire(3)]));
        assert!(gates.iter().all(|gate| behind[&gate.connections["G"][0]].contains(&gate.name.as_str())));
        let mut counts: Vec<usize> = behind.values().map(Vec::len).collect();
        counts.sort_unstable();
        assert_eq!(counts, [3, 22, 24, 24]);
    }
}
