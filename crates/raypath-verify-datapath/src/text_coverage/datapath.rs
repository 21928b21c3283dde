//! A datapath, with the jobs and handshakes of campaigns.

use super::design::{Design, Run, episodes_of};
use crate::campaign::Episode;
use crate::subjects::Subject;
use raypath_hdl::Module;
use raypath_model::{OperationId, Shape, WordModel, Words};
use raypath_sim::engine::{CycleEngine, Engine, PortEncoding, Shown, observe, shape};
use raypath_sim::frames::Expected;
use raypath_sim::traffic::Traffic;
use raypath_verify::Error;
use std::collections::HashMap;
use std::sync::Arc;

/// The episodes of a run.
const EPISODES: u64 = 8;

/// A datapath.
pub struct DatapathDesign {
    encoding: PortEncoding,
    model: WordModel,
    top: Arc<Module>,
    shape: Shape,
}

impl DatapathDesign {
    pub fn new(subject: &Subject) -> Result<Self, Error> {
        let datapath = subject.datapath().elaborate()?;
        let (top, shape) = (datapath.top().clone(), shape(subject.config, &datapath));
        Ok(Self { encoding: PortEncoding::of(subject.config), model: subject.datapath().model(), top, shape })
    }
}

impl Design for DatapathDesign {
    fn top(&self) -> &Arc<Module> {
        &self.top
    }

    fn omissions(&self) -> Vec<String> {
        let operations = self.model.kinds();
        if operations.len() > 1 { operations.iter().map(|it| format!("jobs of {it}")).collect() } else { Vec::new() }
    }

    /// Episodes of a campaign of this seed, one after another, without the jobs of one operation. Opcodes that are not
    /// configured, which campaigns never offer, replace those of the last episode once more.
    fn run(&self, seed: u64, number: u64, omitted: Option<usize>) -> Result<Run, String> {
        let (model, top) = (&self.model, &self.top);
        let omitted = omitted.map(|place| model.kinds()[place]);
        let mut recorder = Recorder::new(model, top, &self.shape, self.encoding);
        let mut last = 0;
        for number in episodes_of(number, EPISODES) {
            last = recorder.frames.len();
            let mut trace = Episode::new(model, seed, number).trace();
            trace.jobs.retain(|job| Some(job.kind()) != omitted);
            recorder.reset();
            observe(&mut recorder, trace.jobs.iter(), &mut Traffic::recorded(trace.cycles), |_| true);
        }
        if omitted.is_none() {
            recorder.offer_other_opcodes(last, model, top);
        }
        let Recorder { frames, expected, .. } = recorder;
        let top = top.clone();
        let fault = move |cycle: usize, words: &[u64]| expected.get(cycle)?.as_ref()?.fault(&top, words);
        Ok(Run { frames, fault: Box::new(fault) })
    }
}

/// The cycle-exact model, as an engine whose inputs and outputs are recorded.
struct Recorder {
    engine: CycleEngine,
    encoding: PortEncoding,
    /// The position in a frame of each input.
    positions: HashMap<String, usize>,
    /// The frame of the next cycle.
    inputs: Vec<u64>,
    frames: Vec<Vec<u64>>,
    /// What the outputs must be: `None` in a reset, and for jobs whose opcode is not configured.
    expected: Vec<Option<Expected>>,
}

impl Recorder {
    fn new(model: &WordModel, top: &Module, shape: &Shape, encoding: PortEncoding) -> Self {
        let positions: HashMap<String, usize> = top.inputs().iter().map(|port| port.name.clone()).zip(1..).collect();
        let inputs = vec![0; positions.len() + 1];
        let engine = CycleEngine::new(model.clone(), shape);
        Self { engine, encoding, positions, inputs, frames: Vec::new(), expected: Vec::new() }
    }

    fn set(&mut self, port: &str, word: u64) {
        if let Some(&position) = self.positions.get(port) {
            self.inputs[position] = word;
        }
    }

    fn push(&mut self, expected: Option<Expected>) {
        self.frames.push(self.inputs.clone());
        self.expected.push(expected);
    }

    /// Repeats the cycles from this one on with other opcodes.
    fn offer_other_opcodes(&mut self, first: usize, model: &WordModel, top: &Module) {
        let configured: Vec<u64> = model.kinds().into_iter().map(OperationId::opcode).collect();
        let width = top.port_width("opcode_i").unwrap_or(0);
        let others: Vec<u64> = (0..1 << width).filter(|opcode| !configured.contains(opcode)).collect();
        if others.is_empty() {
            return;
        }
        let last = self.frames.len();
        let position = self.positions["opcode_i"];
        for cycle in first..last {
            let mut frame = self.frames[cycle].clone();
            frame[position] = others[cycle % others.len()];
            self.frames.push(frame);
            self.expected.push(None);
        }
    }
}

impl Engine for Recorder {
    fn present(&mut self, job: &Words) {
        self.engine.present(job);
        self.set("opcode_i", job.kind().opcode());
        for port in job.ports() {
            self.set(&format!("{}_i", port.name), self.encoding.to_port(port.kind, port.bits));
        }
    }

    fn cycle(&mut self, input_valid: bool, output_ready: bool) -> Shown {
        self.inputs[0] = 1;
        self.set("input_valid_i", input_valid.into());
        self.set("output_ready_i", output_ready.into());
        let shown = self.engine.cycle(input_valid, output_ready);
        let Shown { input_ready, output } = shown.clone();
        self.push(Some(Expected { input_ready, output, encoding: self.encoding }));
        shown
    }

    fn reset(&mut self) {
        self.inputs[0] = 0;
        self.engine.reset();
        self.push(None);
    }
}
