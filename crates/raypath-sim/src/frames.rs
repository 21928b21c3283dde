//! Stimuli for an open-loop simulation: a model of the pipeline says beforehand when each job will be accepted, and
//! what every port must show in every cycle.

use crate::engine::PortEncoding;
use crate::traffic::{self, Traffic};
use raypath_hdl::Module;
use raypath_model::{Elastic, Model, Shape, WordModel, Words};
use std::collections::HashMap;

/// What one cycle puts on the inputs, and what the outputs must show.
pub struct Cycle {
    /// Values of `rst_ni` and the input ports.
    pub inputs: Vec<u64>,
    /// `None` where the outputs do not matter: while registers are still unknown.
    pub expected: Option<Expected>,
}

/// What the outputs must show in a cycle.
pub struct Expected {
    /// `input_ready_o`.
    pub input_ready: bool,
    /// The outcome, where `output_valid_o` is 1.
    pub output: Option<Words>,
    encoding: PortEncoding,
}

/// When the source, the sink and the reset act.
pub struct Stimulus<'j> {
    /// When the datapath shows what.
    pub shape: Shape,
    /// How numbers stand at its ports.
    pub encoding: PortEncoding,
    /// What goes in, in order.
    pub jobs: &'j [Words],
    /// What should come out.
    pub answers: Answers<'j>,
    /// When the source offers and the sink takes.
    pub traffic: Traffic,
    /// Cycles in which `rst_ni` falls; jobs in flight are lost. None for a run in which every job comes out.
    pub resets: Vec<usize>,
}

/// Where the expected outcomes come from.
pub enum Answers<'j> {
    /// A record, job by job. It knows of no resets.
    Recorded(&'j [Words]),
    /// The functional model.
    Model(WordModel),
}

impl Stimulus<'_> {
    /// Every cycle from power-on until the last job has left.
    pub fn cycles(mut self, top: &Module) -> Vec<Cycle> {
        let places: HashMap<&str, usize> =
            top.inputs().iter().enumerate().map(|(place, port)| (port.name.as_str(), place + 1)).collect();
        let mut inputs = vec![0; places.len() + 1];
        let mut cycles =
            vec![Cycle { inputs: inputs.clone(), expected: None }, Cycle { inputs: inputs.clone(), expected: None }];
        let mut pipeline = Elastic::new(&self.shape);
        let (mut accepted, mut left) = (0, 0);
        while left < self.jobs.len() {
            let reset = self.resets.contains(&cycles.len());
            if reset {
                pipeline.reset();
                self.answers.reset();
                left = accepted;
            }
            let traffic::Cycle { offers, takes: output_ready, .. } = self.traffic.next_cycle();
            let job = self.jobs.get(accepted);
            if let Some(job) = job {
                inputs[places["opcode_i"]] = job.kind().opcode();
                for port in job.ports() {
                    if let Some(&place) = places.get(format!("{}_i", port.name).as_str()) {
                        inputs[place] = self.encoding.to_port(port.kind, port.bits);
                    }
                }
            }
            let offered = job.filter(|_| offers);
            inputs[0] = (!reset).into();
            inputs[places["input_valid_i"]] = offered.is_some().into();
            inputs[places["output_ready_i"]] = output_ready.into();
            // After the last job its opcode is still at the port.
            let input_ready = pipeline.input_ready(inputs[places["opcode_i"]]);
            let expected = Expected { input_ready, output: pipeline.output().cloned(), encoding: self.encoding };
            cycles.push(Cycle { inputs: inputs.clone(), expected: Some(expected) });
            if !reset {
                let entering = offered.filter(|_| input_ready);
                let item = entering.map(|job| (job.kind().opcode(), self.answers.next(accepted, job)));
                let transfer = pipeline.cycle(item, output_ready);
                accepted += usize::from(transfer.accepted);
                left += usize::from(transfer.output.is_some());
            }
        }
        cycles
    }
}

impl Answers<'_> {
    fn next(&mut self, index: usize, job: &Words) -> Words {
        match self {
            Self::Recorded(outcomes) => outcomes[index].clone(),
            Self::Model(model) => model.run(job),
        }
    }

    fn reset(&mut self) {
        if let Self::Model(model) = self {
            model.reset();
        }
    }
}

impl Expected {
    /// What is wrong with the output ports' values, if anything.
    pub fn fault(&self, top: &Module, values: &[u64]) -> Option<String> {
        let ports = self.output.iter().flat_map(Words::ports);
        let mut expected: HashMap<String, u64> =
            ports.map(|port| (format!("{}_o", port.name), self.encoding.to_port(port.kind, port.bits))).collect();
        expected.insert("input_ready_o".to_string(), self.input_ready.into());
        expected.insert("output_valid_o".to_string(), self.output.is_some().into());
        if let Some(outcome) = &self.output {
            expected.insert("opcode_o".to_string(), outcome.kind().opcode());
        }
        top.outputs().iter().zip(values).find_map(|(port, &value)| {
            // Where the output is not valid its data mean nothing; where it is, other modes' outputs are zero.
            let right = match (expected.get(&port.name), &self.output) {
                (Some(&right), _) => right,
                (None, Some(_)) => 0,
                (None, None) => return None,
            };
            (value != right).then(|| format!("{} is {value:x}, expected {right:x}", port.name))
        })
    }
}
