//! The wrapper and its package.

use crate::DatapathNetlist;
use crate::package::fields::Field;
use crate::package::structures::{JOB_TYPE, OUTCOME_TYPE, Structures};
use crate::package::text::{columns, licensed};
use raypath_hdl::text::{Package, Structure};
use raypath_hdl::verilog::{head, print_package};

/// The package of the wrapper's structures. Opcodes are in the package of the datapath.
pub fn package(datapath: &DatapathNetlist, structures: &Structures, banner: &[String]) -> String {
    let name = datapath.top().name();
    let structure = |structure: &crate::package::structures::Structure| Structure {
        name: structure.name.clone(),
        doc: None,
        fields: structure.fields.clone(),
    };
    let package = Package {
        name: format!("{name}_wrapper_pkg"),
        doc: vec![
            format!("The inputs and outputs of {name}_wrapper as structures. Their fields are the ports of the module"),
            format!("{name}, grouped by the words of their names. Numbers are encoded as at the ports."),
        ],
        enumerations: Vec::new(),
        structures: structures.iter().map(structure).collect(),
    };
    print_package(&package, &licensed(banner))
}

/// The wrapper. It has no logic.
pub fn module(datapath: &DatapathNetlist, job: &[Field], outcome: &[Field], banner: &[String]) -> String {
    let top = datapath.top();
    let name = top.name();
    let doc = [
        format!("The module {name} with structures as ports, without logic. Latency {}.", datapath.latency()),
        "A job enters if input_valid_i and input_ready_o are 1. An outcome is stable until it leaves, when".to_string(),
        "output_valid_o and output_ready_i are 1.".to_string(),
    ];
    let ports = columns(
        "  ",
        &[
            port("input  logic", "clk_i,"),
            port("input  logic", "rst_ni,"),
            port("input  logic", "input_valid_i,"),
            port("output logic", "input_ready_o,"),
            port(&format!("input  {name}_wrapper_pkg::{JOB_TYPE}"), "job_i,"),
            port("output logic", "output_valid_o,"),
            port("input  logic", "output_ready_i,"),
            port(&format!("output {name}_wrapper_pkg::{OUTCOME_TYPE}"), "outcome_o"),
        ],
    );
    let own = ["clk_i", "rst_ni", "input_valid_i", "input_ready_o", "output_valid_o", "output_ready_i"];
    let mut wires: Vec<(String, String)> = own.map(|name| (name.to_string(), name.to_string())).into();
    connect(job, "job_i", &mut wires);
    connect(outcome, "outcome_o", &mut wires);
    let rows: Vec<_> = wires.iter().map(|(port, wire)| (format!(".{port}"), format!("({wire})"))).collect();
    format!(
        "{}module {name}_wrapper (\n{}\n);\n\n  {name} u_{name} (\n{}\n  );\n\nendmodule : {name}_wrapper\n",
        head(banner, &doc),
        ports.join("\n"),
        columns("    ", &rows).join(",\n"),
    )
}

fn port(kind: &str, name: &str) -> (String, String) {
    (kind.to_string(), name.to_string())
}

/// Every port below `fields`, and the field that it is connected to.
fn connect(fields: &[Field], path: &str, wires: &mut Vec<(String, String)>) {
    for field in fields {
        let path = format!("{path}.{}", field.name());
        match field {
            Field::Port { port, .. } => wires.push((port.clone(), path)),
            Field::Group { fields, .. } => connect(fields, &path, wires),
        }
    }
}
