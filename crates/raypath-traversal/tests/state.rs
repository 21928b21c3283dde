//! What the documents promise about the unit's outputs: none depends on an input of the same cycle. That after a reset
//! nothing depends on what registers and memories had before, the campaign of the item `unit` checks.

use raypath_hdl::combinational_inputs;
use raypath_rtl::{Config, Control};
use raypath_traversal::{StepParameters, UnitFeatures, UnitNetlist, UnitParameters};

fn unit(control: Control) -> UnitNetlist {
    // With all that a unit can have.
    let step = StepParameters { features: UnitFeatures::ALL, ..StepParameters::default() };
    let parameters = UnitParameters { contexts: 8, memory_width: 256, step, ..UnitParameters::default() };
    UnitNetlist::new(Config::DEFAULT.control(control), parameters).expect("a unit")
}

#[test]
fn no_output_depends_on_an_input_of_its_cycle() {
    for control in [Control::Skid, Control::Credit] {
        let top = unit(control).top;
        let outputs: Vec<&str> = top.outputs().iter().map(|port| port.name.as_str()).collect();
        assert_eq!(combinational_inputs(&top, &outputs), Ok(Vec::new()));
    }
}
