//! Jobs through the netlist of a datapath.

use raypath_hdl::{InputPort, OutputPort, Simulator};
use raypath_rtl::DatapathNetlist;
use std::collections::BTreeMap;

/// The values of ports, by name without direction.
pub type Ports = BTreeMap<String, u64>;

/// Sends jobs through a netlist, with a source and a sink that never pause. Returns the values of all output ports for
/// each job, and the cycle that shows the first.
pub fn drive(datapath: &DatapathNetlist, jobs: &[Ports]) -> (Vec<Ports>, u32) {
    let top = datapath.top();
    let mut simulator = Simulator::new(top).expect("a netlist");
    let input = |name: &str| simulator.input(name).expect(name);
    let inputs: BTreeMap<&str, InputPort> = top.inputs().iter().map(|port| (port.stem(), input(&port.name))).collect();
    let output = |name: &str| simulator.output(name).expect(name);
    let outputs: Vec<(&str, OutputPort)> = top.outputs().iter().map(|port| (port.stem(), output(&port.name))).collect();
    let (ready, shown) = (output("input_ready_o"), output("output_valid_o"));
    simulator.set(inputs["output_ready"], 1);
    let (mut sent, mut answers, mut first) = (0, Vec::new(), 0);
    for cycle in 0..40 * (jobs.len() as u32 + 50) {
        let job = jobs.get(sent);
        simulator.set(inputs["input_valid"], job.is_some().into());
        for (name, &value) in job.into_iter().flatten() {
            simulator.set(inputs[name.as_str()], value);
        }
        simulator.cycle();
        if simulator.get(shown) == 1 {
            let values = outputs.iter().map(|&(name, wire)| (name.to_string(), simulator.get(wire)));
            first = if answers.is_empty() { cycle } else { first };
            answers
                .push(values.filter(|(name, _)| !["input_ready", "output_valid"].contains(&name.as_str())).collect());
        }
        sent += usize::from(job.is_some() && simulator.get(ready) == 1);
        if answers.len() == jobs.len() {
            return (answers, first);
        }
    }
    panic!("{} of {} jobs came out", answers.len(), jobs.len());
}
