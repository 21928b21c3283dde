//! Jobs through the netlist of a datapath.

use raypath_hdl::{InputPort, OutputPort, Simulator};
use raypath_rtl::DatapathNetlist;
use std::collections::BTreeMap;

/// The values of ports, by name without direction.
pub type Ports = BTreeMap<String, u64>;

/// Sends jobs through a netlist, with a source and a sink that pause in cycles for which `pauses` returns true. Returns
/// the values of all output ports for each job, and the cycle that shows the first.
pub fn drive(datapath: &DatapathNetlist, jobs: &[Ports], mut pauses: impl FnMut() -> bool) -> (Vec<Ports>, u32) {
    let top = datapath.top();
    let mut simulator = Simulator::new(top).expect("a netlist");
    let input = |name: &str| simulator.input(name).expect(name);
    let inputs: BTreeMap<&str, InputPort> = top.inputs().iter().map(|port| (port.stem(), input(&port.name))).collect();
    let output = |name: &str| simulator.output(name).expect(name);
    let outputs: Vec<(&str, OutputPort)> = top.outputs().iter().map(|port| (port.stem(), output(&port.name))).collect();
    let (ready, shown) = (output("input_ready_o"), output("output_valid_o"));
    let (mut sent, mut answers, mut held, mut first) = (0, Vec::new(), None::<Ports>, 0);
    for cycle in 0..40 * (jobs.len() as u32 + 50) {
        let (offers, takes) = (sent < jobs.len() && !pauses(), !pauses());
        simulator.set(inputs["input_valid"], offers.into());
        simulator.set(inputs["output_ready"], takes.into());
        for (name, &value) in jobs.get(sent).into_iter().flatten() {
            simulator.set(inputs[name.as_str()], value);
        }
        simulator.cycle();
        if simulator.get(shown) == 1 {
            let values = outputs.iter().map(|&(name, wire)| (name.to_string(), simulator.get(wire)));
            let answer: Ports =
                values.filter(|(name, _)| !["input_ready", "output_valid"].contains(&name.as_str())).collect();
            assert!(held.as_ref().is_none_or(|held| *held == answer), "an answer changes before it is taken");
            first = if answers.is_empty() && held.is_none() { cycle } else { first };
            held = Some(answer);
        }
        answers.extend(held.take_if(|_| takes));
        sent += usize::from(offers && simulator.get(ready) == 1);
        if answers.len() == jobs.len() {
            return (answers, first);
        }
    }
    panic!("{} of {} jobs came out", answers.len(), jobs.len());
}
