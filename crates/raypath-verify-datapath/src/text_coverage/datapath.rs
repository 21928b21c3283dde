//! A datapath, with the jobs and handshakes of campaigns.

use crate::campaign::Episode;
use crate::datapaths::TestedDatapath;
use raypath_hdl::{Module, verilog};
use raypath_model::{OperationId, Shape, WordModel};
use raypath_sim::engine::{PortEncoding, shape};
use raypath_sim::frames::{Answers, Expected, Stimulus};
use raypath_sim::traffic::Traffic;
use raypath_tools::{Key, digest};
use raypath_verify::Error;
use std::sync::Arc;

/// The episodes of a run.
const EPISODES: u64 = 8;

/// A datapath.
pub struct Design {
    encoding: PortEncoding,
    model: WordModel,
    /// The top module.
    pub top: Arc<Module>,
    shape: Shape,
}

/// The words of `rst_ni` and of all inputs in each cycle, and what the outputs must be: `None` in a first reset, and for
/// jobs whose opcode is not configured.
pub type Cycles = (Vec<Vec<u64>>, Vec<Option<Expected>>);

impl Design {
    pub fn new(subject: &TestedDatapath) -> Result<Self, Error> {
        let datapath = subject.datapath().elaborate()?;
        let (top, shape) = (datapath.top().clone(), shape(subject.config, &datapath));
        Ok(Self { encoding: PortEncoding::of(subject.config), model: subject.datapath().model(), top, shape })
    }

    /// The cycles of an episode of a campaign, without the jobs of one operation.
    fn episode(&self, seed: u64, number: u64, omitted: Option<OperationId>) -> Cycles {
        let mut trace = Episode::new(&self.model, 1, seed, number).trace();
        trace.jobs.retain(|job| Some(job.kind()) != omitted);
        let stimulus = Stimulus {
            shape: self.shape.clone(),
            encoding: self.encoding,
            jobs: &trace.jobs,
            answers: Answers::Model(self.model.clone()),
            // Two cycles of a reset come first.
            resets: (2..).zip(&trace.cycles).filter(|(_, cycle)| cycle.resets).map(|(number, _)| number).collect(),
            traffic: Traffic::recorded(trace.cycles),
        };
        stimulus.cycles(&self.top).into_iter().map(|cycle| (cycle.inputs, cycle.expected)).unzip()
    }

    /// The opcodes that are not configured.
    fn other_opcodes(&self) -> Vec<u64> {
        let configured: Vec<u64> = self.model.kinds().into_iter().map(OperationId::opcode).collect();
        let width = self.top.port_width("opcode_i").unwrap_or(0);
        (0..1 << width).filter(|opcode| !configured.contains(opcode)).collect()
    }

    /// What the stimuli can leave out.
    pub fn omissions(&self) -> Vec<String> {
        let operations = self.model.kinds();
        if operations.len() > 1 { operations.iter().map(|it| format!("jobs of {it}")).collect() } else { Vec::new() }
    }

    /// The name of a result: a digest of the emitted text, the stimuli of these runs, and all else that it depends on.
    pub fn key(&self, runs: u64, seed: u64, others: &str) -> Result<Key, Error> {
        let words = (0..runs).flat_map(|number| self.run(seed, number, None).0).flatten();
        let stimuli = digest(&words.flat_map(u64::to_le_bytes).collect::<Vec<u8>>());
        let sources = verilog::sources(&self.top, &[])?;
        let texts = sources.iter().map(|source| source.text.as_str());
        Ok(Key::new("text-coverage", &texts.chain([stimuli.as_str(), others]).collect::<Vec<_>>()))
    }

    /// Episodes of a campaign of this seed, one after another, without the jobs of one operation. Opcodes that are not
    /// configured, which campaigns never offer, replace those of the last episode once more.
    pub fn run(&self, seed: u64, number: u64, omitted: Option<usize>) -> Cycles {
        let kind = omitted.map(|place| self.model.kinds()[place]);
        let (mut frames, mut expected) = (Vec::new(), Vec::new());
        let mut last = 0;
        for number in number * EPISODES..(number + 1) * EPISODES {
            let (inputs, outputs) = self.episode(seed, number, kind);
            last = frames.len();
            frames.extend(inputs);
            expected.extend(outputs);
        }
        let (others, opcode) = (self.other_opcodes(), self.top.inputs().iter().position(|it| it.name == "opcode_i"));
        if let Some(opcode) = opcode.filter(|_| omitted.is_none() && !others.is_empty()) {
            for cycle in last..frames.len() {
                let mut frame: Vec<u64> = frames[cycle].clone();
                // The reset comes before the ports.
                frame[opcode + 1] = others[cycle % others.len()];
                frames.push(frame);
                expected.push(None);
            }
        }
        (frames, expected)
    }
}
