//! Engines that carry jobs through the datapath: the functional model, the cycle-exact one, and the netlist itself.

use crate::traffic::Traffic;
use raypath_hdl::{InputPort, OutputPort, Simulator};
use raypath_model::{CycleModel, Functional, Shape};
use raypath_ops::{Job, JobKind, Outcome, Rules};
use raypath_rtl::{Config, Datapath};
use std::borrow::Borrow;
use std::collections::{HashMap, HashSet};

/// A datapath as seen from outside, cycle by cycle.
pub trait Engine {
    /// Puts a job on the input ports, where it stays until the next.
    fn present(&mut self, job: &Job);
    /// One clock cycle, in which `input_valid_i` and `output_ready_i` have these values.
    fn cycle(&mut self, input_valid: bool, output_ready: bool) -> Shown;
    /// A cycle in which `rst_ni` is 0.
    fn reset(&mut self);
}

/// What the ports showed in a cycle, before its clock edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    /// `input_ready_o`.
    pub input_ready: bool,
    /// The outcome, where `output_valid_o` was 1.
    pub output: Option<Outcome>,
}

/// What a run took.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Run {
    /// Clock cycles; 0 where the engine knows no time.
    pub cycles: u64,
    /// Jobs that came out.
    pub jobs: usize,
}

/// Feeds `jobs` to an engine under `traffic`, each presented once, and shows each outcome as it leaves, with its job's
/// position, until `on_outcome` answers false. Gives up when nothing has left for a long time: then fewer jobs come out
/// than went in.
pub fn drive<J: Borrow<Job>>(
    engine: &mut dyn Engine,
    jobs: impl Iterator<Item = J>,
    traffic: &mut Traffic,
    mut on_outcome: impl FnMut(usize, Outcome) -> bool,
) -> Run {
    /// More idle cycles than any traffic makes by chance.
    const PATIENCE: u64 = 100_000;
    let mut jobs = jobs.peekable();
    let mut run = Run::default();
    let mut accepted = 0;
    let mut last_progress = 0;
    if let Some(job) = jobs.peek() {
        engine.present(job.borrow());
    }
    while (jobs.peek().is_some() || run.jobs < accepted) && run.cycles - last_progress < PATIENCE {
        let (offers, output_ready) = traffic.next_cycle();
        let input_valid = offers && jobs.peek().is_some();
        let shown = engine.cycle(input_valid, output_ready);
        run.cycles += 1;
        if input_valid && shown.input_ready {
            accepted += 1;
            last_progress = run.cycles;
            jobs.next();
            if let Some(job) = jobs.peek() {
                engine.present(job.borrow());
            }
        }
        if let Some(outcome) = shown.output.filter(|_| output_ready) {
            run.jobs += 1;
            last_progress = run.cycles;
            if !on_outcome(run.jobs - 1, outcome) {
                break;
            }
        }
    }
    run
}

/// Answers jobs without time, until `on_outcome` answers false.
pub fn evaluate<'j>(
    rules: Rules,
    jobs: impl Iterator<Item = &'j Job>,
    mut on_outcome: impl FnMut(usize, Outcome) -> bool,
) -> Run {
    let mut model = Functional::new(rules);
    let mut run = Run::default();
    for job in jobs {
        run.jobs += 1;
        if !on_outcome(run.jobs - 1, model.run(job)) {
            break;
        }
    }
    run
}

/// The cycle-exact model as an engine.
#[derive(Debug, Clone)]
pub struct CycleEngine {
    model: CycleModel,
    presented: Option<Job>,
}

impl CycleEngine {
    /// An empty pipeline.
    pub fn new(rules: Rules) -> Self {
        Self { model: CycleModel::new(Functional::new(rules), &Shape::default()), presented: None }
    }
}

impl Engine for CycleEngine {
    fn present(&mut self, job: &Job) {
        self.presented = Some(*job);
    }

    fn cycle(&mut self, input_valid: bool, output_ready: bool) -> Shown {
        let kind = self.presented.map_or(JobKind::Triangle, |job| job.kind());
        let shown = Shown { input_ready: self.model.input_ready(kind), output: self.model.output().copied() };
        self.model.cycle(self.presented.as_ref().filter(|_| input_valid), output_ready);
        shown
    }

    fn reset(&mut self) {
        self.model.reset();
    }
}

/// The netlist, simulated, as an engine.
pub struct NetlistEngine {
    simulator: Simulator,
    inputs: HashMap<String, InputPort>,
    outputs: HashMap<String, OutputPort>,
    handshake: Handshake,
    /// What each kind of job shows: the ports that belong to it. All others must be zero.
    owned: [HashSet<String>; JobKind::ALL.len()],
}

struct Handshake {
    input_valid: InputPort,
    output_ready: InputPort,
    opcode: InputPort,
    input_ready: OutputPort,
    output_valid: OutputPort,
    opcode_out: OutputPort,
}

impl NetlistEngine {
    /// Elaborates a configuration and compiles its netlist. `observed` says by hierarchical name which of its signals
    /// will be looked at.
    pub fn new(config: Config, observed: impl Fn(&str) -> bool) -> Result<Self, raypath_rtl::Error> {
        Self::of(&Datapath::new(config)?, observed)
    }

    /// Compiles the netlist of a datapath.
    pub fn of(datapath: &Datapath, observed: impl Fn(&str) -> bool) -> Result<Self, raypath_rtl::Error> {
        let top = datapath.top();
        let simulator = Simulator::observing(top, observed)?;
        let mut inputs = HashMap::new();
        for port in top.inputs() {
            inputs.insert(port.stem().to_string(), simulator.input(&port.name)?);
        }
        let mut outputs = HashMap::new();
        for port in top.outputs() {
            outputs.insert(port.stem().to_string(), simulator.output(&port.name)?);
        }
        let handshake = Handshake {
            input_valid: simulator.input("input_valid_i")?,
            output_ready: simulator.input("output_ready_i")?,
            opcode: simulator.input("opcode_i")?,
            input_ready: simulator.output("input_ready_o")?,
            output_valid: simulator.output("output_valid_o")?,
            opcode_out: simulator.output("opcode_o")?,
        };
        let owned = JobKind::ALL.map(|kind| {
            Outcome::from_ports(kind, |_| 0).ports().into_iter().map(|port| port.name).collect::<HashSet<_>>()
        });
        let mut engine = Self { simulator, inputs, outputs, handshake, owned };
        engine.reset();
        Ok(engine)
    }

    /// The simulator inside, for waveforms.
    pub fn simulator(&self) -> &Simulator {
        &self.simulator
    }

    fn outcome(&self) -> Option<Outcome> {
        let opcode = self.simulator.get(self.handshake.opcode_out);
        let kind = JobKind::ALL.into_iter().find(|kind| kind.opcode() == opcode)?;
        Some(Outcome::from_ports(kind, |name| self.outputs.get(name).map_or(0, |&port| self.simulator.get(port))))
    }

    /// The output ports that should be zero and are not, in the last cycle: those of other modes than the job's.
    pub fn stray_outputs(&self) -> Vec<&str> {
        let opcode = self.simulator.get(self.handshake.opcode_out) as usize;
        let handshake = ["input_ready", "output_valid", "opcode"];
        let strays = self.outputs.iter().filter(|(name, port)| {
            !handshake.contains(&name.as_str())
                && !self.owned[opcode].contains(*name)
                && self.simulator.get(**port) != 0
        });
        strays.map(|(name, _)| name.as_str()).collect()
    }
}

impl Engine for NetlistEngine {
    fn present(&mut self, job: &Job) {
        self.simulator.set(self.handshake.opcode, job.kind().opcode());
        for port in job.ports() {
            if let Some(&input) = self.inputs.get(&port.name) {
                self.simulator.set(input, port.bits);
            }
        }
    }

    fn cycle(&mut self, input_valid: bool, output_ready: bool) -> Shown {
        self.simulator.set(self.handshake.input_valid, input_valid.into());
        self.simulator.set(self.handshake.output_ready, output_ready.into());
        self.simulator.cycle();
        let valid = self.simulator.get(self.handshake.output_valid) == 1;
        let input_ready = self.simulator.get(self.handshake.input_ready) == 1;
        Shown { input_ready, output: if valid { self.outcome() } else { None } }
    }

    fn reset(&mut self) {
        self.simulator.set_reset(true);
        self.simulator.cycle();
        self.simulator.set_reset(false);
    }
}
