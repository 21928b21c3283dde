//! The package and the wrapper.

use crate::Datapath;
use crate::package::fields::Field;
use crate::package::structures::{JOB_TYPE, OPCODE_TYPE, OUTCOME_TYPE, Structures};
use crate::package::text::{columns, head, packed};

/// The package: opcodes and structures.
pub fn package(datapath: &Datapath, structures: &Structures, banner: &[String]) -> String {
    let name = datapath.top().name();
    let doc = [
        format!(
            "What goes into {name}_wrapper and what comes out. The fields are the ports of the module {name}, by the"
        ),
        "words of their names; numbers stand in them as at the ports.".to_string(),
    ];
    let mut text = head("//", banner, &doc) + &format!("\npackage {name}_pkg;\n");
    text += &opcodes(datapath);
    for structure in structures.iter() {
        let fields: Vec<_> = structure.fields.iter().map(|(kind, name)| (kind.clone(), format!("{name};"))).collect();
        text += &format!(
            "\n  typedef struct packed {{\n{}\n  }} {};\n",
            columns("    ", &fields).join("\n"),
            structure.name
        );
    }
    text + &format!("\nendpackage : {name}_pkg\n")
}

/// The opcodes as an enumeration.
fn opcodes(datapath: &Datapath) -> String {
    let width = datapath.top().port_width("opcode_i").unwrap_or(1);
    let labels = datapath.opcodes();
    let rows: Vec<_> = labels.iter().map(|label| (label.name.clone(), format!("= {width}'d{}", label.value))).collect();
    format!("\n  typedef enum {} {{\n{}\n  }} {OPCODE_TYPE};\n", packed(width), columns("    ", &rows).join(",\n"))
}

/// The wrapper: nothing but wires.
pub fn module(datapath: &Datapath, job: &[Field], outcome: &[Field], banner: &[String]) -> String {
    let top = datapath.top();
    let name = top.name();
    let doc = [
        format!(
            "The module {name} with job and outcome as structures; nothing is added. Latency {}.",
            datapath.latency()
        ),
        "A job enters where input_valid_i and input_ready_o are 1; an outcome leaves where output_valid_o and"
            .to_string(),
        "output_ready_i are 1, and stays as it is until then.".to_string(),
    ];
    let ports = columns(
        "  ",
        &[
            port("input  logic", "clk_i,"),
            port("input  logic", "rst_ni,"),
            port("input  logic", "input_valid_i,"),
            port("output logic", "input_ready_o,"),
            port(&format!("input  {name}_pkg::{JOB_TYPE}"), "job_i,"),
            port("output logic", "output_valid_o,"),
            port("input  logic", "output_ready_i,"),
            port(&format!("output {name}_pkg::{OUTCOME_TYPE}"), "outcome_o"),
        ],
    );
    let own = ["clk_i", "rst_ni", "input_valid_i", "input_ready_o", "output_valid_o", "output_ready_i"];
    let mut wires: Vec<(String, String)> = own.map(|name| (name.to_string(), name.to_string())).into();
    connect(job, "job_i", &mut wires);
    connect(outcome, "outcome_o", &mut wires);
    let rows: Vec<_> = wires.iter().map(|(port, wire)| (format!(".{port}"), format!("({wire})"))).collect();
    format!(
        "{}\nmodule {name}_wrapper (\n{}\n);\n\n  {name} u_{name} (\n{}\n  );\n\nendmodule : {name}_wrapper\n",
        head("//", banner, &doc),
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
