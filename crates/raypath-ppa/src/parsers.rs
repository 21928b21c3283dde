//! Everything that this crate parses, as functions of bytes, for `raypath verify parsers` and the fuzz targets. Each
//! returns whether it accepted the bytes, and panics if the result violates an invariant.

use crate::attribution::Attribution;
use crate::design::{RegisterKind, Words};
use crate::energy::{self, CellEnergy};
use crate::gates::Gates;
use crate::library::Library;
use crate::names::RegisterNames;
use crate::netlist::{Direction, Instance, Net, Netlist, Port};
use crate::report::Report;
use crate::structural;
use crate::synthesis::{chip_area, json, netlist};
use crate::timing;
use raypath_tools::decode;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::LazyLock;

/// A cell library in Liberty, plain or gzip.
pub fn library(bytes: &[u8]) -> bool {
    let Ok(library) = Library::read_from(bytes, Path::new("cells.lib")) else { return false };
    assert!(library.nand2_area() > 0.0 && library.nand2_area().is_finite() && library.load.is_finite());
    // The text for Yosys and OpenSTA is parsed as the same library.
    let again = Library::read_from(library.text.as_bytes(), Path::new("again.lib")).expect("its own text");
    assert_eq!((again.digest, again.nand2, again.buffer), (library.digest, library.nand2, library.buffer));
    true
}

/// A synthesised module in Yosys's JSON, and what follows from it: attribution, areas, Verilog for OpenSTA.
pub fn yosys_netlist(bytes: &[u8]) -> bool {
    let registers = registers();
    let names =
        json(bytes).map(|names| RegisterNames::new(names, "raypath", &registers, &Words::new())).unwrap_or_default();
    let Ok(top) = netlist(bytes, "raypath", &names, &CELLS) else { return false };
    let unit = netlist(bytes, "raypath_fp_add", &RegisterNames::default(), &CELLS).ok();
    let units: BTreeMap<String, Netlist> = unit.into_iter().map(|unit| (unit.module.clone(), unit)).collect();
    let groups = ["u_a", "u_b", "raypath"].map(str::to_string);
    let attribution = Attribution::new(&top, &units, &CELLS, &groups, &registers);
    assert_eq!(attribution.areas(&units, &CELLS).len(), groups.len());
    let text = structural::module(&top, |index| structural::cell_name(index, &attribution.roles[index]));
    assert!(text.ends_with("endmodule\n"));
    if let Ok(gates) = Gates::new(&top, &units, &CELLS) {
        assert_eq!(gates.order.len(), gates.cells.len());
    }
    true
}

/// OpenSTA's messages about the power of a small netlist.
pub fn opensta_power(bytes: &[u8]) -> bool {
    let Ok(energies) = energy::energies(&String::from_utf8_lossy(bytes), &GATES) else { return false };
    assert_eq!(energies.cells.len(), GATES.cells.len());
    let of_cell = |cell: &CellEnergy| [&cell.inputs[..], &cell.outputs, &cell.loads, &[cell.leakage]].concat();
    assert!(energies.cells.iter().flat_map(of_cell).all(f64::is_finite) && energies.volts.is_finite());
    true
}

/// The output of Yosys's `stat`.
pub fn yosys_statistics(bytes: &[u8]) -> bool {
    chip_area(&String::from_utf8_lossy(bytes)).is_some()
}

/// The output of OpenSTA.
pub fn opensta_paths(bytes: &[u8]) -> bool {
    let said = String::from_utf8_lossy(bytes);
    let found = (0..5).filter_map(|ends| timing::paths(&said, ends).ok()).flatten().flatten();
    let found: Vec<_> = found.collect();
    for path in &found {
        assert!(path.arrival.is_finite() && path.setup.is_finite() && !path.points.is_empty());
    }
    !found.is_empty()
}

/// A cached result: a netlist or a report, gzip or plain.
pub fn kept_result(bytes: &[u8]) -> bool {
    let netlist = decode::<Netlist>(bytes);
    if let Some(netlist) = &netlist {
        structural::module(netlist, |index| format!("x{index}"));
    }
    let report = decode::<Report>(bytes);
    netlist.is_some() || report.is_some()
}

/// A small cell library.
static CELLS: LazyLock<Library> = LazyLock::new(|| {
    let gate = |name: &str, inputs: &str, function: &str| {
        let pin = |pin: char| format!("pin ({pin}) {{ direction : input; capacitance : 1; }} ");
        let inputs: String = inputs.chars().map(pin).collect();
        format!("cell ({name}) {{ area : 2; {inputs}pin (Y) {{ direction : output; function : \"{function}\"; }} }}\n")
    };
    let gates = gate("INV", "A", "!A") + &gate("BUF", "A", "A") + &gate("NAND2", "AB", "!(A B)");
    let dff = "cell (DFF) { area : 9; ff (I, J) { next_state : \"D\"; } pin (D) { direction : input; } \
               pin (Q) { direction : output; function : \"I\"; } }";
    Library::read_from(format!("library (cells) {{ {gates}{dff} }}").as_bytes(), Path::new("cells.lib"))
        .expect("a library")
});

/// A NAND of two inputs, `x0`.
static GATES: LazyLock<Gates> = LazyLock::new(|| {
    let port = |direction, net| Port { direction, bits: vec![Net::Wire(net)] };
    let ports =
        [("a_i", port(Direction::Input, 1)), ("b_i", port(Direction::Input, 2)), ("y_o", port(Direction::Output, 3))];
    let pins = [("A", 1), ("B", 2), ("Y", 3)].map(|(pin, net)| (pin.to_string(), vec![Net::Wire(net)]));
    let nand = Instance { cell: "NAND2".to_string(), name: String::new(), connections: pins.into() };
    let ports = ports.map(|(name, port)| (name.to_string(), port)).into();
    let netlist = Netlist { module: "raypath".to_string(), ports, cells: vec![nand] };
    Gates::new(&netlist, &BTreeMap::new(), &CELLS).expect("gates")
});

/// The registers that such a netlist may have.
fn registers() -> BTreeMap<String, RegisterKind> {
    let kinds = [("u_a.num_q", 0, false), ("u_a.valid_q", 0, true), ("u_b.num_q", 1, false)];
    kinds.map(|(name, group, is_control)| (name.to_string(), RegisterKind { group, is_control })).into()
}
