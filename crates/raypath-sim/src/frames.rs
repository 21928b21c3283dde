//! Stimuli for an open-loop simulation. A model of the pipeline predicts when each job is accepted, and the values of
//! all output ports in every cycle.

use crate::engine::PortEncoding;
use crate::traffic::{self, Traffic};
use raypath_hdl::Module;
use raypath_model::{Elastic, Model, Shape, WordModel, Words};
use std::collections::HashMap;

/// The input values of one cycle, and the expected output values.
pub struct Cycle {
    /// The values of `rst_ni` and of the input ports, in order.
    pub inputs: Vec<u64>,
    /// `None` while registers are still unknown.
    pub expected: Option<Expected>,
    /// The job whose outcome is at the output ports.
    pub job: Option<usize>,
}

/// The expected output values of a cycle.
pub struct Expected {
    /// `input_ready_o`.
    pub input_ready: bool,
    /// The outcome, if `output_valid_o` is 1.
    pub output: Option<Words>,
    /// The encoding of numbers at the ports.
    pub encoding: PortEncoding,
}

/// The jobs of a simulation and their timing.
pub struct Stimulus<'j> {
    /// The shape of the pipeline.
    pub shape: Shape,
    /// The encoding of numbers at the ports.
    pub encoding: PortEncoding,
    /// The jobs, in order.
    pub jobs: &'j [Words],
    /// The expected outcomes.
    pub answers: Answers<'j>,
    /// The handshakes of source and sink.
    pub traffic: Traffic,
    /// The numbers of cycles with a reset, in which jobs in flight are lost.
    pub resets: Vec<usize>,
}

/// The source of the expected outcomes.
pub enum Answers<'j> {
    /// Recorded outcomes, one for each job, for a run without resets.
    Recorded(&'j [Words]),
    /// The functional model.
    Model(WordModel),
}

impl Stimulus<'_> {
    /// All cycles from power-on until the last job has left.
    pub fn cycles(mut self, top: &Module) -> Vec<Cycle> {
        let positions: HashMap<&str, usize> =
            (1..).zip(top.inputs()).map(|(at, port)| (port.name.as_str(), at)).collect();
        let mut inputs = vec![0; positions.len() + 1];
        let reset = || Cycle { inputs: vec![0; positions.len() + 1], expected: None, job: None };
        let mut cycles = vec![reset(), reset()];
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
                inputs[positions["opcode_i"]] = job.kind().opcode();
                for port in job.ports() {
                    if let Some(&at) = positions.get(format!("{}_i", port.name).as_str()) {
                        inputs[at] = self.encoding.to_port(port.kind, port.bits);
                    }
                }
            }
            let offered = job.filter(|_| offers);
            inputs[0] = (!reset).into();
            inputs[positions["input_valid_i"]] = offered.is_some().into();
            inputs[positions["output_ready_i"]] = output_ready.into();
            // The opcode of the last job stays at the port.
            let input_ready = pipeline.input_ready(inputs[positions["opcode_i"]]);
            let expected = Expected { input_ready, output: pipeline.output().cloned(), encoding: self.encoding };
            let job = expected.output.is_some().then_some(left);
            cycles.push(Cycle { inputs: inputs.clone(), expected: Some(expected), job });
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
    /// A message about the first wrong output value; `None` if all values are as expected.
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
            // The data are unspecified while the output is not valid. The outputs of other operations are zero.
            let right = match (expected.get(&port.name), &self.output) {
                (Some(&right), _) => right,
                (None, Some(_)) => 0,
                (None, None) => return None,
            };
            (value != right).then(|| format!("{} is {value:x}, expected {right:x}", port.name))
        })
    }
}
