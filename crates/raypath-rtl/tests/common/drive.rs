//! Jobs through the netlist of a datapath.

use raypath_hdl::Simulator;
use raypath_rtl::DatapathNetlist;
use std::collections::BTreeMap;

/// The values of ports, by name without direction.
pub type Ports = BTreeMap<String, u64>;

/// Sends jobs through a netlist, with a source and a sink that never pause. Returns the values of all output ports for
/// each job, and the cycle that shows the first.
pub fn drive(datapath: &DatapathNetlist, jobs: &[Ports]) -> (Vec<Ports>, u32) {
    let top = datapath.top();
    let mut simulator = Simulator::new(top).expect("a netlist");
    let mut held = Ports::from([("output_ready".to_string(), 1)]);
    let (mut sent, mut answers, mut first) = (0, Vec::new(), 0);
    for cycle in 0..40 * (jobs.len() as u32 + 50) {
        let job = jobs.get(sent);
        held.extend(job.cloned().into_iter().flatten());
        held.insert("input_valid".to_string(), job.is_some().into());
        simulator.set_all(top.inputs().iter().map(|port| held.get(port.stem()).copied().unwrap_or(0)));
        simulator.cycle();
        let names = top.outputs().iter().map(|port| port.stem().to_string());
        let mut shown: Ports = names.zip(simulator.outputs().iter().copied()).collect();
        let (ready, valid) = (shown.remove("input_ready"), shown.remove("output_valid"));
        if valid == Some(1) {
            first = if answers.is_empty() { cycle } else { first };
            answers.push(shown);
        }
        sent += usize::from(job.is_some() && ready == Some(1));
        if answers.len() == jobs.len() {
            return (answers, first);
        }
    }
    panic!("{} of {} jobs came out", answers.len(), jobs.len());
}
