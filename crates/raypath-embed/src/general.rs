//! Jobs of the paper's operations in any format and with any features, through the words at their ports.

use crate::Datapath;
use crate::job::{Job, Outcome};
use raypath_float::Format;
use raypath_model::{Model, WordModel, Words, state};
use raypath_ops::{self as ops, Aabb, Binary32, JobKind, PortKind, RayBoxInput, RayTriangleInput};
use raypath_sim::OperationId;

/// The functional model of a datapath, for jobs of the paper's operations in binary32. Numbers are rounded to the
/// datapath's format and back. Ports that only features add are 0.
#[derive(Debug, Clone)]
pub struct General {
    model: WordModel,
    /// Of the paper's operations that the datapath has.
    operations: Vec<PaperOperation>,
    words: Vec<u64>,
}

state! { General { model } }

/// The ports of one of the paper's operations, related to those of [`ops::Job`] and [`ops::Outcome`].
#[derive(Debug, Clone)]
struct PaperOperation {
    kind: JobKind,
    id: OperationId,
    /// For each port of the datapath's jobs, the word of [`WideJob`] for it, and whether it is a number.
    inputs: Vec<(Option<usize>, bool)>,
    /// For each word of [`ops::Outcome`], the datapath's port for it, and whether it is a number.
    outputs: Vec<(Option<usize>, bool)>,
}

/// A job with as many lanes as any datapath has.
type WideJob = ops::Job<MAX_LANES, { MAX_LANES / 2 }>;
const MAX_LANES: usize = 64;

impl General {
    /// The model with accumulators of zero.
    pub fn new(datapath: &Datapath) -> Self {
        let model = datapath.model();
        let of = |kind: JobKind| Some(PaperOperation::new(&model, kind, model.kind(kind.name())?));
        let operations = JobKind::ALL.into_iter().filter_map(of).collect();
        Self { operations, words: Vec::new(), model }
    }

    /// Computes a job in the types of an operation of the paper.
    pub fn run(&mut self, job: &Job<'_>) -> Outcome {
        let job = match *job {
            Job::Quadbox { ray, boxes } => {
                let aabb = boxes.each_ref().map(Aabb::from);
                WideJob::Quadbox(RayBoxInput { ray: ray.into(), aabb })
            }
            Job::Triangle { ray, triangle } => {
                WideJob::Triangle(RayTriangleInput { ray: ray.into(), triangle: triangle.into() })
            }
            Job::Euclidean(beat) => WideJob::Euclidean(beat.into()),
            Job::Angular(beat) => WideJob::Angular(beat.into()),
            Job::Words { opcode, .. } | Job::Timing { opcode } => return Outcome::Timing(opcode),
        };
        self.run_wide(&job)
    }

    /// Computes a job of any operation from the words at its ports. Missing words are 0.
    pub fn run_words(&mut self, operation: OperationId, inputs: &[u64]) -> Words {
        let job = self.model.job_of_words(operation, inputs);
        self.model.run(&job)
    }

    /// The outcome of an operation with these words at its ports.
    pub fn outcome_of_words(&self, operation: OperationId, words: &[u64]) -> Words {
        self.model.outcome_of_words(operation, words)
    }

    /// The number of words of an operation's job.
    pub fn inputs(&self, operation: OperationId) -> usize {
        self.model.inputs(operation).len()
    }

    /// Sets the accumulators to zero.
    pub fn reset(&mut self) {
        self.model.reset();
    }

    /// All outputs are 0 if the datapath does not have the operation.
    fn run_wide(&mut self, job: &WideJob) -> Outcome {
        let Self { model, operations, words, .. } = self;
        let Some(operation) = operations.iter().find(|operation| operation.kind == job.kind()) else {
            return ops::Outcome::from_words_in(Binary32, job.kind(), &[]).into();
        };
        job.words(words);
        let format = model.format();
        let input = |&(from, is_number): &(Option<usize>, bool)| {
            let word = from.map_or(0, |from| words[from]);
            if is_number && format != Format::BINARY32 { format.from_f32(f32::from_bits(word as u32)) } else { word }
        };
        let inputs: Vec<u64> = operation.inputs.iter().map(input).collect();
        let outcome = model.run(&model.job_of_words(operation.id, &inputs));
        let output = |&(from, is_number): &(Option<usize>, bool)| {
            let word = from.map_or(0, |from| outcome.as_words()[from]);
            if is_number && format != Format::BINARY32 {
                u64::from((format.to_f64(word) as f32).to_bits())
            } else {
                word
            }
        };
        let outputs: Vec<u64> = operation.outputs.iter().map(output).collect();
        ops::Outcome::from_words_in(Binary32, operation.kind, &outputs).into()
    }
}

impl PaperOperation {
    fn new(model: &WordModel, kind: JobKind, id: OperationId) -> Self {
        let (job, outcome) = (
            WideJob::from_words_in(Binary32, kind, &[]).ports(),
            <ops::Outcome>::from_words_in(Binary32, kind, &[]).ports(),
        );
        let is_number = |kind: PortKind| kind == PortKind::Number;
        let inputs = model
            .inputs(id)
            .iter()
            .map(|port| (job.iter().position(|value| value.name == port.name), is_number(port.kind)));
        let outputs = outcome
            .iter()
            .map(|value| (model.outputs(id).iter().position(|port| port.name == value.name), is_number(value.kind)));
        Self { kind, id, inputs: inputs.collect(), outputs: outputs.collect() }
    }
}
