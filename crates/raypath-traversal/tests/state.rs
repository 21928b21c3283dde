//! What the documents promise about the unit's outputs: none depends on an input of the same cycle. That after a reset
//! nothing depends on what registers and memories had before, the campaign of the item `unit` checks.

use raypath_hdl::depends_combinationally;
use raypath_ops::EdgeRule;
use raypath_rtl::{Config, Control};
use raypath_traversal::{Queries, StepParameters, UnitFeatures, UnitNetlist, UnitParameters};

fn unit(control: Control) -> UnitNetlist {
    // With all that a unit can have.
    let step = StepParameters {
        features: UnitFeatures {
            barycentrics: true,
            edges: EdgeRule::Once,
            instances: true,
            nested: true,
            queries: Queries::Full,
        },
        ..StepParameters::default()
    };
    let parameters = UnitParameters { contexts: 8, memory_width: 256, step, ..UnitParameters::default() };
    UnitNetlist::new(Config::DEFAULT.control(control), parameters).expect("a unit")
}

#[test]
fn no_output_depends_on_an_input_of_its_cycle() {
    for control in [Control::Skid, Control::Credit] {
        let top = unit(control).top;
        let handshakes = top.inputs().iter().filter(|port| !port.name.contains("_data_"));
        for input in handshakes {
            for output in top.outputs().iter().filter(|port| port.name != "mem_rsp_ready_o") {
                let depends = depends_combinationally(&top, &output.name, &input.name).expect("a netlist");
                assert!(!depends, "{} depends on {}", output.name, input.name);
            }
        }
    }
}
