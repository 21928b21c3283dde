//! A datapath under random traffic with resets, whose inputs are unknown where they have no meaning.

use super::Scenario;
use raypath_hdl::{Module, depends_combinationally};
use raypath_model::{WordModel, Words};
use raypath_rtl::{Config, Datapath};
use raypath_sim::engine::{PortEncoding, shape};
use raypath_sim::frames::{Answers, Cycle, Expected, Stimulus};
use raypath_sim::jobs::any_jobs;
use raypath_sim::traffic::Traffic;
use raypath_tools::{KnownWord, ToolError};
use raypath_verify::Error;
use std::sync::Arc;

/// Cycles before the first reset.
const BEFORE: usize = 3;

/// The scenario of a configuration, with so many jobs.
pub fn scenario(config: Config, jobs: usize, seed: u64) -> Result<Scenario, Error> {
    let (datapath, model) = (Datapath::new(config)?, raypath_sim::Datapath::paper(config).model());
    let (top, shape) = (datapath.top().clone(), shape(config, &datapath));
    let jobs: Vec<Words> = any_jobs(model.clone(), seed).take(jobs).collect();
    // The second reset and the third, of two cycles, are in the middle of traffic.
    let second = shape.latency + 20;
    let third = 2 * second + 7;
    let stimulus = Stimulus {
        shape,
        encoding: PortEncoding::of(config),
        jobs: &jobs,
        answers: Answers::Model(model.clone()),
        traffic: Traffic::random(seed),
        resets: vec![second, third, third + 1],
    };
    let cycles = stimulus.cycles(&top);
    let inputs = Inputs::of(&top, &model)?;
    let unknown = std::iter::repeat_n(inputs.before(), BEFORE);
    let frames: Vec<Vec<KnownWord>> = unknown.chain(cycles.iter().map(|cycle| inputs.known(cycle))).collect();
    let outcomes = cycles.iter().filter(|cycle| cycle.expected.as_ref().is_some_and(|it| it.output.is_some()));
    let outcomes = outcomes.count() as u64;
    let ports = top.clone();
    let check = move |number: usize, words: &[KnownWord]| {
        let cycle = &cycles[number.checked_sub(BEFORE)?];
        wrong(&ports, cycle.expected.as_ref(), words)
    };
    Ok(Scenario { top, frames, check: Box::new(check), outcomes })
}

/// A message about an output that is unknown or wrong. In a reset, which has no expected outputs before the first job,
/// the handshake is that of an empty datapath.
fn wrong(top: &Module, expected: Option<&Expected>, words: &[KnownWord]) -> Option<String> {
    let shows = expected.is_some_and(|expected| expected.output.is_some());
    let handshake = ["input_ready_o", "output_valid_o"];
    for (port, word) in top.outputs().iter().zip(words) {
        let has_meaning = shows || handshake.contains(&port.name.as_str());
        if has_meaning && word.is_none() {
            return Some(format!("{} is unknown", port.name));
        }
        if expected.is_none() && has_meaning && *word != Some(u64::from(port.name == handshake[0])) {
            return Some(format!("{} is {word:?} in a reset", port.name));
        }
    }
    let words: Vec<u64> = words.iter().map(|word| word.unwrap_or(0)).collect();
    expected?.fault(top, &words)
}

/// The positions of inputs in a frame.
struct Inputs {
    words: usize,
    valid: usize,
    output_ready: usize,
    opcode: usize,
    /// Whether ready depends on the opcode in the same cycle, even if no job is offered.
    ready_reads_opcode: bool,
    /// The positions of the ports of each operation, with its opcode.
    operations: Vec<(u64, Vec<usize>)>,
}

impl Inputs {
    fn of(top: &Arc<Module>, model: &WordModel) -> Result<Self, Error> {
        // After the reset.
        let position = |name: &str| Some(1 + top.inputs().iter().position(|port| port.name == name)?);
        let operations = model.kinds().into_iter().map(|kind| {
            // A configuration may lack a port of an operation.
            let own = model.inputs(kind).iter().filter_map(|port| position(&format!("{}_i", port.name))).collect();
            (kind.opcode(), own)
        });
        let handshake = |name: &str| {
            position(name).ok_or_else(|| ToolError::unexpected(top.name(), format!("no port {name}"), "a datapath"))
        };
        Ok(Self {
            words: top.inputs().len() + 1,
            valid: handshake("input_valid_i")?,
            output_ready: handshake("output_ready_i")?,
            opcode: handshake("opcode_i")?,
            ready_reads_opcode: depends_combinationally(top, "input_ready_o", "opcode_i")?,
            operations: operations.collect(),
        })
    }

    /// No reset, and nothing else known.
    fn before(&self) -> Vec<KnownWord> {
        let mut frame = vec![None; self.words];
        frame[0] = Some(1);
        frame
    }

    /// The inputs of a cycle as far as they have a meaning: in a reset only the reset, otherwise the handshakes, and if
    /// a job is offered its opcode and operands.
    fn known(&self, cycle: &Cycle) -> Vec<KnownWord> {
        let inputs = &cycle.inputs;
        let mut known = vec![0];
        if inputs[0] == 1 {
            known.extend([self.valid, self.output_ready]);
            let offers = inputs[self.valid] == 1;
            if offers || self.ready_reads_opcode {
                known.push(self.opcode);
            }
            let operation = self.operations.iter().find(|(opcode, _)| offers && *opcode == inputs[self.opcode]);
            known.extend(operation.into_iter().flat_map(|(_, ports)| ports));
        }
        let mut frame = vec![None; self.words];
        known.into_iter().for_each(|position| frame[position] = Some(inputs[position]));
        frame
    }
}
