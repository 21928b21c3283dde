//! The functional model of any set of operations.

use crate::operation::AnyOperation;
use raypath_float::Format;
use raypath_model::{Kind, Model, OnPorts};
use raypath_ops::{Binary32, Operation, Port, PortKind, PortValue, from_words, to_words};
use raypath_rtl::{Config, Features, Semantics};
use std::cell::Cell;
use std::fmt;
use std::sync::Arc;

/// What a datapath of any operations answers, job by job. [`CycleModel`](raypath_model::CycleModel) makes it
/// cycle-exact, and [`NetlistEngine`](crate::engine::NetlistEngine) holds the netlist against it.
#[derive(Clone)]
pub struct AnyModel {
    format: Format,
    features: Features,
    /// By opcode.
    operations: Arc<[Known]>,
    /// What the last job of each operation left.
    states: Vec<Vec<u64>>,
}

/// An operation of an [`AnyModel`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct AnyKind {
    opcode: u64,
    name: &'static str,
}

/// A job or an outcome of an [`AnyModel`]: a word for each port, numbers in IEEE 754's layout.
#[derive(Clone, PartialEq)]
pub struct Words {
    kind: AnyKind,
    ports: Ports,
    words: Arc<[u64]>,
}

struct Known {
    kind: AnyKind,
    operation: Arc<dyn AnyOperation>,
    inputs: Ports,
    outputs: Ports,
    /// Of all inputs that the operation may have, which are there.
    has_input: Vec<bool>,
    /// And of all outputs.
    has_output: Vec<bool>,
}

/// What the words of one operation stand at.
type Ports = Arc<[Port]>;

/// The port of a word that jobs take along.
const TAG: &str = "tag";
/// Bits of the exceptions' port.
const FLAGS: u32 = 4;

fn port(name: &str, kind: PortKind, width: u32) -> Port {
    Port { name: name.to_string(), kind, width: Some(width) }
}

impl AnyModel {
    /// The model of these operations, each under its opcode, built as `config` says.
    pub(crate) fn new(operations: &[(u64, Arc<dyn AnyOperation>)], config: Config) -> Self {
        let Semantics { format, features, .. } = config.semantics;
        let taken_along = (features.tag > 0).then(|| port(TAG, PortKind::Word, features.tag));
        let raised = features.exception_flags.then(|| port("exception_flags", PortKind::Word, FLAGS));
        let mut by_opcode: Vec<_> = operations.iter().collect();
        by_opcode.sort_by_key(|(opcode, _)| *opcode);
        let known = by_opcode.into_iter().map(|(opcode, operation)| {
            let kind = AnyKind { opcode: *opcode, name: operation.name() };
            let (inputs, outputs) = (operation.inputs(), operation.outputs());
            let has_input: Vec<bool> = inputs.iter().map(|port| operation.has_input(&port.name)).collect();
            let has_output: Vec<bool> = outputs.iter().map(|port| operation.has_output(&port.name)).collect();
            let inputs = present(inputs, &has_input).chain(taken_along.clone()).collect();
            let outputs = present(outputs, &has_output).chain(raised.clone()).chain(taken_along.clone()).collect();
            Known { kind, operation: operation.clone(), inputs, outputs, has_input, has_output }
        });
        Self { format, features, states: vec![Vec::new(); operations.len()], operations: known.collect() }
    }

    /// The format of its numbers.
    pub fn format(&self) -> Format {
        self.format
    }

    /// The operation with this name.
    pub fn kind(&self, name: &str) -> Option<AnyKind> {
        self.operations.iter().map(|known| known.kind).find(|kind| kind.name == name)
    }

    /// The ports of an operation's jobs; none of an operation that it does not have.
    pub fn inputs(&self, kind: AnyKind) -> &[Port] {
        self.of(kind).map_or(&[], |known| &known.inputs)
    }

    /// A job of an operation; its numbers are rounded where the format is narrower. `None` where the operation is none
    /// of the model's.
    pub fn job_of<O: Operation>(&self, input: &O::Input<Binary32>) -> Option<Words> {
        let kind = self.kind(O::NAME)?;
        let mut words = Vec::new();
        to_words(input, &mut words);
        let mut words = self.present_inputs(kind, words);
        if self.format != Format::BINARY32 {
            let numbers = self.inputs(kind).iter().zip(&mut words).filter(|(port, _)| port.kind == PortKind::Number);
            numbers.for_each(|(_, word)| *word = self.format.from_f32(f32::from_bits(*word as u32)));
        }
        Some(self.job_of_words(kind, &words))
    }

    /// An outcome as the operation's output; ports that are not there are 0. `None` where it is another operation's, or
    /// not in binary32.
    pub fn output_of<O: Operation>(&self, outcome: &Words) -> Option<O::Output<Binary32>> {
        let known =
            self.of(outcome.kind).filter(|_| outcome.kind.name == O::NAME && self.format == Format::BINARY32)?;
        Some(from_words(Binary32, &all(&outcome.words, &known.has_output)))
    }

    /// Of words on all inputs that an operation may have, those on the inputs that are there.
    pub fn present_inputs(&self, kind: AnyKind, words: Vec<u64>) -> Vec<u64> {
        self.of(kind).map_or_else(Vec::new, |known| present(words, &known.has_input).collect())
    }

    /// A job's words on all inputs that its operation may have; 0 on those that are not there.
    pub fn all_inputs(&self, job: &Words) -> Vec<u64> {
        self.of(job.kind).map_or_else(Vec::new, |known| all(&job.words, &known.has_input))
    }

    /// The same of an outcome's words and outputs.
    pub fn all_outputs(&self, outcome: &Words) -> Vec<u64> {
        self.of(outcome.kind).map_or_else(Vec::new, |known| all(&outcome.words, &known.has_output))
    }

    /// The ports of an operation's outcomes; none of an operation that it does not have.
    pub fn outputs(&self, kind: AnyKind) -> &[Port] {
        self.of(kind).map_or(&[], |known| &known.outputs)
    }

    fn of(&self, kind: AnyKind) -> Option<&Known> {
        self.operations.iter().find(|known| known.kind == kind)
    }

    /// A job's words: what is missing is 0, and bits beyond a port's width are ignored.
    fn job_by(&self, kind: AnyKind, word: impl FnMut(usize, &Port) -> u64) -> Words {
        self.words(kind, self.of(kind).map(|known| &known.inputs), word)
    }

    /// An outcome's: NaN is the canonical one besides, as the datapath answers it.
    fn outcome_by(&self, kind: AnyKind, mut word: impl FnMut(usize, &Port) -> u64) -> Words {
        let (infinity, magnitude) = (self.format.infinity(), u64::MAX >> (65 - self.format.ieee_width()));
        self.words(kind, self.of(kind).map(|known| &known.outputs), |place, port| match word(place, port) {
            bits if port.kind == PortKind::Number && bits & magnitude > infinity => self.format.nan(),
            bits => bits,
        })
    }

    fn words(&self, kind: AnyKind, ports: Option<&Ports>, mut word: impl FnMut(usize, &Port) -> u64) -> Words {
        let ports = ports.cloned().unwrap_or_else(|| [].into());
        let mask = |port: &Port| u64::MAX >> (64 - port.width.unwrap_or(self.format.ieee_width()));
        let words = ports.iter().enumerate().map(|(place, port)| word(place, port) & mask(port)).collect();
        Words { kind, ports, words }
    }
}

/// Those that are there.
fn present<T>(all: Vec<T>, are_there: &[bool]) -> impl Iterator<Item = T> {
    all.into_iter().zip(are_there).filter_map(|(one, is_there)| is_there.then_some(one))
}

/// Words in their places among all; 0 where none is.
fn all(present: &[u64], are_there: &[bool]) -> Vec<u64> {
    let mut present = present.iter();
    let word = |&is_there: &bool| if is_there { present.next().copied().unwrap_or(0) } else { 0 };
    are_there.iter().map(word).collect()
}

impl Words {
    /// The words themselves, in the order of the ports.
    pub fn as_words(&self) -> &[u64] {
        &self.words
    }
}

impl Model for AnyModel {
    type Kind = AnyKind;
    type Job = Words;
    type Outcome = Words;

    fn kinds(&self) -> Vec<AnyKind> {
        self.operations.iter().map(|known| known.kind).collect()
    }

    /// Answers a job; one of an operation that the model does not have has an outcome without ports.
    fn run(&mut self, job: &Words) -> Words {
        let mut known = self.operations.iter().zip(&mut self.states);
        let answer = match known.find(|(known, _)| known.kind == job.kind) {
            Some((known, state)) => {
                let raised = self.features.exception_flags.then(Cell::default);
                let job_words = all(&job.words, &known.has_input);
                let answer = known.operation.answer(self.format, &job_words, state, raised.as_ref());
                let own = present(answer, &known.has_output);
                let tag = (self.features.tag > 0).then(|| job.words.last().copied().unwrap_or(0));
                own.chain(raised.map(Cell::into_inner)).chain(tag).collect()
            }
            None => Vec::new(),
        };
        self.outcome_of_words(job.kind, &answer)
    }

    fn reset(&mut self) {
        self.states.iter_mut().for_each(Vec::clear);
    }

    fn job(&self, kind: AnyKind, mut port: impl FnMut(&str) -> u64) -> Words {
        self.job_by(kind, |_, of| port(&of.name))
    }

    fn outcome(&self, kind: AnyKind, mut port: impl FnMut(&str) -> u64) -> Words {
        self.outcome_by(kind, |_, of| port(&of.name))
    }

    fn job_of_words(&self, kind: AnyKind, words: &[u64]) -> Words {
        self.job_by(kind, |place, _| words.get(place).copied().unwrap_or(0))
    }

    fn outcome_of_words(&self, kind: AnyKind, words: &[u64]) -> Words {
        self.outcome_by(kind, |place, _| words.get(place).copied().unwrap_or(0))
    }
}

impl PartialEq for AnyModel {
    /// The same operations in the same state.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.operations, &other.operations) && self.format == other.format && self.states == other.states
    }
}

impl fmt::Debug for AnyModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.operations.iter().map(|known| known.kind.name).collect();
        f.debug_struct("AnyModel").field("operations", &names).field("states", &self.states).finish()
    }
}

impl AnyKind {
    /// The operation's name.
    pub fn name(self) -> &'static str {
        self.name
    }
}

impl Kind for AnyKind {
    fn opcode(self) -> u64 {
        self.opcode
    }
}

impl fmt::Display for AnyKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl OnPorts for Words {
    type Kind = AnyKind;

    fn kind(&self) -> AnyKind {
        self.kind
    }

    fn ports(&self) -> Vec<PortValue> {
        let values = self.ports.iter().zip(self.words.iter());
        values.map(|(port, &bits)| PortValue { name: port.name.clone(), kind: port.kind, bits }).collect()
    }

    fn words(&self, words: &mut Vec<u64>) {
        words.clear();
        words.extend_from_slice(&self.words);
    }
}

/// `sphere: ray_origin_x=3f800000 ...`
impl fmt::Debug for Words {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.kind)?;
        self.ports.iter().zip(self.words.iter()).try_for_each(|(port, word)| write!(f, " {}={word:x}", port.name))
    }
}
