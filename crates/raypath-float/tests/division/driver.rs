//! A clocked unit in simulation, with a source and a sink.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_float::{DivSqrt, Format};
use raypath_hdl::{InputPort, Module, OutputPort, Simulator};
use std::collections::VecDeque;
use std::sync::Arc;

/// The bits of a tag.
pub const TAG_WIDTH: u32 = 12;

/// The operands of a job, in IEEE 754's layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Job {
    pub a: u64,
    pub b: u64,
    pub is_root: bool,
}

/// When source and sink are active, as shares of the cycles in 16ths.
#[derive(Debug, Clone, Copy)]
pub struct Traffic {
    pub source: u32,
    pub sink: u32,
    pub seed: u64,
}

/// Source and sink active in every cycle.
pub const ALWAYS: Traffic = Traffic { source: 16, sink: 16, seed: 0 };

/// A result, and the cycles in which its operands were accepted, it was first valid, and it was taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outcome {
    pub word: u64,
    pub accepted: u64,
    pub valid: u64,
    pub taken: u64,
}

pub struct Unit {
    pub function: DivSqrt,
    pub format: Format,
    simulator: Simulator,
    inputs: Vec<(String, InputPort)>,
    outputs: [OutputPort; 4],
}

impl Unit {
    pub fn new(function: DivSqrt, format: Format, module: &Arc<Module>) -> Self {
        let simulator = Simulator::new(module).expect("the unit has no loop");
        let port = |name: &String| (name.clone(), simulator.input(name).expect("an input"));
        let inputs = module.inputs().iter().map(|input| port(&input.name)).collect();
        let outputs =
            ["ready_o", "valid_o", "result_o", "tag_o"].map(|name| simulator.output(name).expect("an output"));
        Self { function, format, simulator, inputs, outputs }
    }

    pub fn pipelined(function: DivSqrt, format: Format, latency: u32) -> Self {
        Self::new(function, format, &function.pipelined(format, latency, TAG_WIDTH).expect("a latency"))
    }

    pub fn iterative(function: DivSqrt, format: Format, digits: u32) -> Self {
        Self::new(function, format, &function.iterative(format, digits, TAG_WIDTH).expect("digits"))
    }

    /// The expected word, canonical.
    pub fn expected(&self, job: Job) -> u64 {
        let (format, one) = (self.format, self.format.from_f64(1.0));
        format.encode(match self.function {
            DivSqrt::Reciprocal => format.div(one, job.b),
            DivSqrt::Quotient => format.div(job.a, job.b),
            DivSqrt::QuotientOrRoot if !job.is_root => format.div(job.a, job.b),
            DivSqrt::Root | DivSqrt::QuotientOrRoot => format.sqrt(job.a),
        })
    }

    /// Runs the jobs, in order, and compares the results. `word` recodes an operand.
    pub fn check(&mut self, jobs: &[Job], word: impl FnMut(u64) -> u64, traffic: Traffic) -> Vec<Outcome> {
        let outcomes = self.run(jobs, word, traffic);
        assert_eq!(outcomes.len(), jobs.len());
        for (job, outcome) in jobs.iter().zip(&outcomes) {
            let (found, expected) = (outcome.word, self.expected(*job));
            assert_eq!(found, expected, "{} of {job:x?}: {found:#x}", self.simulator.module().name());
        }
        outcomes
    }

    fn run(&mut self, jobs: &[Job], mut word: impl FnMut(u64) -> u64, traffic: Traffic) -> Vec<Outcome> {
        let mut random = ChaCha8Rng::seed_from_u64(traffic.seed);
        let mut active = |share: u32| share == 16 || random.random_range(0..16) < share;
        let (mut waiting, mut outcomes) = (VecDeque::new(), Vec::new());
        let (mut sent, mut offered, mut first_valid, mut cycle) = (0, false, None, 0_u64);
        while outcomes.len() < jobs.len() {
            offered = offered || sent < jobs.len() && active(traffic.source);
            let ready = active(traffic.sink);
            let job = if offered { jobs[sent] } else { Job { a: cycle, b: !cycle, is_root: cycle % 2 == 0 } };
            for (name, port) in &self.inputs {
                let value = match name.as_str() {
                    "valid_i" => offered.into(),
                    "ready_i" => ready.into(),
                    "a_i" => word(job.a),
                    "b_i" => word(job.b),
                    "is_root_i" => job.is_root.into(),
                    "tag_i" => sent as u64,
                    other => panic!("input {other}"),
                };
                self.simulator.set(*port, value);
            }
            self.simulator.cycle();
            let [takes, valid, result, tag] = self.outputs.map(|output| self.simulator.get(output));
            if valid == 1 {
                first_valid = first_valid.or(Some(cycle));
                if ready {
                    let accepted: u64 = waiting.pop_front().expect("a result only of a job");
                    assert_eq!(tag, outcomes.len() as u64 % (1 << TAG_WIDTH));
                    let valid = first_valid.take().expect("it is valid");
                    outcomes.push(Outcome { word: result, accepted, valid, taken: cycle });
                }
            }
            if offered && takes == 1 {
                waiting.push_back(cycle);
                (sent, offered) = (sent + 1, false);
            }
            cycle += 1;
            assert!(cycle < 1000 * (jobs.len() as u64 + 100), "no progress");
        }
        outcomes
    }
}
