use crate::words::Ports;
use crate::{Dynamic, Model, OperationId, State, StateWords, Words};
use raypath_float::Format;
use raypath_ops::{
    Binary32, Job, Operation, Outcome, Port, PortKind, from_words, ports_of, to_canonical_words, to_words,
};
use std::cell::Cell;
use std::fmt;
use std::sync::Arc;

/// The functional model of a datapath of any operations. A job is an operation and the words at its ports ([`Words`]);
/// [`job_of`](Self::job_of) and [`output_of`](Self::output_of) convert from and to the operation's own types.
#[derive(Clone)]
pub struct WordModel {
    options: ModelOptions,
    /// In the order of their opcodes.
    operations: Arc<[Known]>,
    /// The state that the last job of each operation left.
    states: Vec<Vec<u64>>,
    buffers: Buffers,
}

/// The properties of a datapath that its operations do not determine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ModelOptions {
    /// The format of the numbers.
    pub format: Format,
    /// The width in bits of a tag that jobs carry to their outcomes; 0 for none.
    pub tag: u32,
    /// Outcomes have a port with the exceptions that the job raised.
    pub exception_flags: bool,
}

/// Buffers for the words of a job and its outcome, so that a job allocates only its outcome.
#[derive(Debug, Clone, Default)]
struct Buffers {
    job: Vec<u64>,
    answer: Vec<u64>,
}

struct Known {
    kind: OperationId,
    operation: Arc<dyn WordOperation>,
    inputs: Ports,
    outputs: Ports,
    /// For each input that the operation may have, whether it is present.
    has_input: Vec<bool>,
    /// For each output that the operation may have, whether it is present.
    has_output: Vec<bool>,
}

const TAG: &str = "tag";
/// The width of the exceptions' port.
const FLAGS: u32 = 4;

impl State for WordModel {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        self.states.iter_mut().for_each(|state| words.many(state));
    }
}

impl WordModel {
    /// The model of these operations, each with its opcode.
    pub fn new(operations: impl IntoIterator<Item = (u64, Arc<dyn WordOperation>)>, options: ModelOptions) -> Self {
        let ModelOptions { tag, exception_flags, .. } = options;
        let tag = (tag > 0).then(|| port(TAG, PortKind::Word, tag));
        let raised = exception_flags.then(|| port("exception_flags", PortKind::Word, FLAGS));
        let known = operations.into_iter().map(|(opcode, operation)| {
            let kind = OperationId::new(opcode, operation.name());
            let (inputs, outputs) = (operation.inputs(), operation.outputs());
            let has_input: Vec<bool> = inputs.iter().map(|port| operation.has_input(&port.name)).collect();
            let has_output: Vec<bool> = outputs.iter().map(|port| operation.has_output(&port.name)).collect();
            let inputs = present(inputs, &has_input).chain(tag.clone()).collect();
            let outputs = present(outputs, &has_output).chain(raised.clone()).chain(tag.clone()).collect();
            Known { kind, operation, inputs, outputs, has_input, has_output }
        });
        let mut operations: Vec<Known> = known.collect();
        operations.sort_by_key(|known| known.kind.opcode());
        let states = vec![Vec::new(); operations.len()];
        Self { options, states, operations: operations.into(), buffers: Buffers::default() }
    }

    /// The format of the numbers.
    pub fn format(&self) -> Format {
        self.options.format
    }

    /// The operations, in the order of their opcodes.
    pub fn kinds(&self) -> Vec<OperationId> {
        self.operations.iter().map(|known| known.kind).collect()
    }

    /// The operation with this name.
    pub fn kind(&self, name: &str) -> Option<OperationId> {
        self.operations.iter().map(|known| known.kind).find(|kind| kind.name() == name)
    }

    /// The ports of an operation's jobs; empty if the model does not have the operation.
    pub fn inputs(&self, kind: OperationId) -> &[Port] {
        self.of(kind).map_or(&[], |known| &known.inputs)
    }

    /// The ports of an operation's outcomes; empty if the model does not have the operation.
    pub fn outputs(&self, kind: OperationId) -> &[Port] {
        self.of(kind).map_or(&[], |known| &known.outputs)
    }

    /// The job of an operation with this input. Numbers are rounded if the model's format is narrower than binary32.
    /// `None` if the model does not have the operation.
    pub fn job_of<O: Operation>(&self, input: &O::Input<Binary32>) -> Option<Words> {
        let kind = self.kind(O::NAME)?;
        let mut words = Vec::new();
        to_words(input, &mut words);
        let words = self.present_inputs(kind, words);
        Some(self.job_by(kind, |index, port| self.rounded(port.kind, words.get(index).copied().unwrap_or(0))))
    }

    /// A job of the paper's operations. Numbers are rounded if the model's format is narrower than binary32; ports that
    /// the job does not have are 0. `None` if the model does not have the operation.
    pub fn paper_job<const E: usize, const A: usize>(&self, job: &Job<E, A>) -> Option<Words> {
        let (kind, ports) = (self.kind(job.kind().name())?, job.ports());
        let bits = |name: &str| ports.iter().find(|port| port.name == name).map_or(0, |port| port.bits);
        Some(self.job_by(kind, |_, port| self.rounded(port.kind, bits(&port.name))))
    }

    /// An outcome of the paper's operations, converted as [`paper_job`](Self::paper_job) converts jobs.
    pub fn paper_outcome(&self, outcome: &Outcome) -> Option<Words> {
        let (kind, ports) = (self.kind(outcome.kind().name())?, outcome.ports());
        let bits = |name: &str| ports.iter().find(|port| port.name == name).map_or(0, |port| port.bits);
        Some(self.outcome_by(kind, |_, port| self.rounded(port.kind, bits(&port.name))))
    }

    /// The outcome as the output type of operation `O`; absent ports are 0. `None` if the outcome belongs to another
    /// operation or the format is not binary32.
    pub fn output_of<O: Operation>(&self, outcome: &Words) -> Option<O::Output<Binary32>> {
        let (kind, is_binary32) = (outcome.kind(), self.format() == Format::BINARY32);
        let known = self.of(kind).filter(|_| kind.name() == O::NAME && is_binary32)?;
        let mut words = Vec::new();
        all(outcome.as_words(), &known.has_output, &mut words);
        Some(from_words(Binary32, &words))
    }

    /// Selects the words of the present inputs from the words of all inputs that an operation may have.
    pub fn present_inputs(&self, kind: OperationId, words: Vec<u64>) -> Vec<u64> {
        self.of(kind).map_or_else(Vec::new, |known| present(words, &known.has_input).collect())
    }

    /// The words of all inputs that the job's operation may have; 0 for absent ones.
    pub fn all_inputs(&self, job: &Words) -> Vec<u64> {
        let mut words = Vec::new();
        self.of(job.kind()).into_iter().for_each(|known| all(job.as_words(), &known.has_input, &mut words));
        words
    }

    /// The words of all outputs that the outcome's operation may have; 0 for absent ones.
    pub fn all_outputs(&self, outcome: &Words) -> Vec<u64> {
        let mut words = Vec::new();
        self.of(outcome.kind()).into_iter().for_each(|known| all(outcome.as_words(), &known.has_output, &mut words));
        words
    }

    /// The job of this operation with the port values that `port` returns by name, without bits beyond a port's width.
    pub fn job(&self, kind: OperationId, mut port: impl FnMut(&str) -> u64) -> Words {
        self.job_by(kind, |_, of| port(&of.name))
    }

    /// The outcome of this operation with the port values that `port` returns by name. Bits beyond a port's width are
    /// ignored, and every NaN becomes the canonical NaN.
    pub fn outcome(&self, kind: OperationId, mut port: impl FnMut(&str) -> u64) -> Words {
        self.outcome_by(kind, |_, of| port(&of.name))
    }

    /// As [`job`](Self::job), with the words in the order of the ports. Missing words are 0.
    pub fn job_of_words(&self, kind: OperationId, words: &[u64]) -> Words {
        self.job_by(kind, |index, _| words.get(index).copied().unwrap_or(0))
    }

    /// As [`outcome`](Self::outcome), with the words in the order of the ports. Missing words are 0.
    pub fn outcome_of_words(&self, kind: OperationId, words: &[u64]) -> Words {
        self.outcome_by(kind, |index, _| words.get(index).copied().unwrap_or(0))
    }

    fn of(&self, kind: OperationId) -> Option<&Known> {
        self.operations.iter().find(|known| known.kind == kind)
    }

    /// A binary32 value of a port in the model's format.
    fn rounded(&self, kind: PortKind, bits: u64) -> u64 {
        if kind == PortKind::Number && self.format() != Format::BINARY32 {
            self.format().from_f32(f32::from_bits(bits as u32))
        } else {
            bits
        }
    }

    fn job_by(&self, kind: OperationId, word: impl FnMut(usize, &Port) -> u64) -> Words {
        self.words(kind, self.of(kind).map(|known| &known.inputs), word)
    }

    fn outcome_by(&self, kind: OperationId, mut word: impl FnMut(usize, &Port) -> u64) -> Words {
        let format = self.format();
        let (infinity, magnitude) = (format.infinity(), u64::MAX >> (65 - format.ieee_width()));
        self.words(kind, self.of(kind).map(|known| &known.outputs), |index, port| match word(index, port) {
            bits if port.kind == PortKind::Number && bits & magnitude > infinity => format.nan(),
            bits => bits,
        })
    }

    fn words(&self, kind: OperationId, ports: Option<&Ports>, mut word: impl FnMut(usize, &Port) -> u64) -> Words {
        let ports = ports.cloned().unwrap_or_else(|| [].into());
        let mask = |port: &Port| u64::MAX >> (64 - port.width.unwrap_or(self.format().ieee_width()));
        let words = ports.iter().enumerate().map(|(index, port)| word(index, port) & mask(port)).collect();
        Words::new(kind, ports, words)
    }
}

fn port(name: &str, kind: PortKind, width: u32) -> Port {
    Port { name: name.to_string(), kind, width: Some(width) }
}

/// The present items among all.
fn present<T>(all: impl IntoIterator<Item = T>, are_present: &[bool]) -> impl Iterator<Item = T> {
    all.into_iter().zip(are_present).filter_map(|(one, is_present)| is_present.then_some(one))
}

/// Replaces the contents of `words` by the present words at their positions among all; 0 for absent ones.
fn all(present: &[u64], are_present: &[bool], words: &mut Vec<u64>) {
    let mut present = present.iter();
    let word = |&is_present: &bool| if is_present { present.next().copied().unwrap_or(0) } else { 0 };
    words.clear();
    words.extend(are_present.iter().map(word));
}

impl Model for WordModel {
    type Kind = OperationId;
    type Job = Words;
    type Outcome = Words;

    #[inline]
    fn kind(job: &Words) -> OperationId {
        job.kind()
    }

    /// Computes a job. The outcome has no ports if the model does not have the job's operation.
    fn run(&mut self, job: &Words) -> Words {
        let (kind, options) = (job.kind(), self.options);
        let Buffers { job: inputs, answer } = &mut self.buffers;
        let mut known = self.operations.iter().zip(&mut self.states);
        let Some((known, state)) = known.find(|(known, _)| known.kind == kind) else {
            return Words::new(kind, [].into(), [].into());
        };
        let raised = options.exception_flags.then(Cell::default);
        all(job.as_words(), &known.has_input, inputs);
        known.operation.run_words(Dynamic::new(options.format, raised.as_ref()), inputs, state, answer);
        let tag = (options.tag > 0).then(|| job.as_words().last().copied().unwrap_or(0));
        let words =
            present(answer.iter().copied(), &known.has_output).chain(raised.map(Cell::into_inner)).chain(tag).collect();
        Words::new(kind, known.outputs.clone(), words)
    }

    fn reset(&mut self) {
        self.states.iter_mut().for_each(Vec::clear);
    }
}

impl PartialEq for WordModel {
    /// Whether both have the same operations in the same state.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.operations, &other.operations) && self.options == other.options && self.states == other.states
    }
}

impl fmt::Debug for WordModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.operations.iter().map(|known| known.kind.name()).collect();
        f.debug_struct("WordModel").field("operations", &names).field("states", &self.states).finish()
    }
}

/// An operation as a function on the words at its ports, implemented for every [`Operation`] and object-safe.
pub trait WordOperation: Send + Sync {
    /// [`Operation::NAME`].
    fn name(&self) -> &'static str;

    /// All input ports that the operation may have.
    fn inputs(&self) -> Vec<Port>;

    /// All output ports that the operation may have.
    fn outputs(&self) -> Vec<Port>;

    /// Whether the operation has an input port: [`Operation::has_input`].
    fn has_input(&self, port: &str) -> bool;

    /// Whether the operation has an output port: [`Operation::has_output`].
    fn has_output(&self, port: &str) -> bool;

    /// Computes one job over `circuit`. `job` has a word for each of [`inputs`](Self::inputs). `output` is replaced by
    /// a word for each of [`outputs`](Self::outputs). `state` has the words that the previous job left, initially none,
    /// and is replaced by those that this job leaves.
    fn run_words(&self, circuit: Dynamic<'_>, job: &[u64], state: &mut Vec<u64>, output: &mut Vec<u64>);
}

impl<O: Operation + Send + Sync> WordOperation for O {
    fn name(&self) -> &'static str {
        O::NAME
    }

    fn inputs(&self) -> Vec<Port> {
        ports_of::<O::Input<Binary32>>()
    }

    fn outputs(&self) -> Vec<Port> {
        ports_of::<O::Output<Binary32>>()
    }

    fn has_input(&self, port: &str) -> bool {
        Operation::has_input(self, port)
    }

    fn has_output(&self, port: &str) -> bool {
        Operation::has_output(self, port)
    }

    fn run_words(&self, circuit: Dynamic<'_>, job: &[u64], state: &mut Vec<u64>, output: &mut Vec<u64>) {
        let (result, next) = self.run(circuit, from_words(circuit, job), from_words(circuit, state));
        to_words(&next, state);
        to_canonical_words(&result, output);
    }
}
