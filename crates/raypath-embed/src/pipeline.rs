use crate::general::General;
use crate::job::{Job, Outcome, Tagged, no_operation, operation};
use crate::paper::{Native, PaperModel};
use crate::ring::Ring;
use crate::state::{restore, save};
use crate::{Datapath, Error};
use raypath_model::{Flow, PipelinePosition, State, StateWords, Words};
use raypath_ops::JobKind;
use raypath_rtl::Lanes;
use raypath_sim::OperationId;
use std::fmt;
use std::sync::Arc;

/// The cycle-exact model of a datapath, whose jobs carry a tag. In every cycle it accepts and delivers what the
/// hardware does.
///
/// A cycle consists of at most one accepted [`offer`](Self::offer), then a [`step`](Self::step).
///
/// ```
/// use raypath_embed::{Datapath, Job, Outcome, Pipeline, Ray, Vertices};
///
/// let datapath = Datapath::open("", &[])?;
/// let mut pipeline = Pipeline::new(&datapath);
/// let ray = Ray::new([0.0, 0.0, -5.0], [0.0, 0.0, 1.0], f32::INFINITY)?;
/// let triangle = Vertices { a: [-1.0, -1.0, 0.0], b: [0.0, 1.0, 0.0], c: [1.0, -1.0, 0.0] };
/// assert!(pipeline.offer(&Job::Triangle { ray: &ray, triangle: &triangle }, 7)?);
/// assert_eq!(pipeline.skip(100), 12);
/// assert!(pipeline.output_valid());
/// let left = pipeline.step(true).expect("the output is valid");
/// assert!(left.tag == 7 && matches!(left.outcome, Outcome::Triangle(result) if result.triangle_hit == 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Pipeline {
    flow: Flow,
    /// The outcome of a job is computed when the job is offered, because it depends on the order of jobs alone.
    outcomes: Ring,
    /// The opcode of the job that was accepted in this cycle.
    accepted: Option<u64>,
    operations: Vec<OperationId>,
    /// Whether the datapath has each of the paper's operations.
    has_paper: [bool; JobKind::ALL.len()],
    lanes: usize,
    /// Native arithmetic, for datapaths in binary32 without features.
    native: Option<Box<dyn Native>>,
    general: General,
    /// The datapath in words.
    datapath: Arc<str>,
}

impl State for Pipeline {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        let Self { flow, outcomes, accepted, operations, native, general, .. } = self;
        flow.pass(words);
        accepted.pass(words);
        native.iter_mut().for_each(|native| native.pass(words));
        general.pass(words);
        outcomes.pass(words, |opcode, words| {
            let operation = operation(operations, opcode).ok()?;
            Some(general.outcome_of_words(operation, words))
        });
    }
}

impl Pipeline {
    /// An empty pipeline, with accumulators of zero.
    pub fn new(datapath: &Datapath) -> Self {
        let lanes = datapath.config().semantics.lanes;
        let native = datapath.native_rules().map(|rules| -> Box<dyn Native> {
            match lanes {
                Lanes::None | Lanes::Two => Box::new(PaperModel::<2, 1>::new(rules)),
                Lanes::Four => Box::new(PaperModel::<4, 2>::new(rules)),
                Lanes::Eight => Box::new(PaperModel::<8, 4>::new(rules)),
                Lanes::Sixteen => Box::new(PaperModel::<16, 8>::new(rules)),
                Lanes::ThirtyTwo => Box::new(PaperModel::<32, 16>::new(rules)),
                Lanes::SixtyFour => Box::new(PaperModel::<64, 32>::new(rules)),
            }
        });
        let flow = Flow::new(datapath.shape());
        let (operations, general) = (datapath.operations(), General::new(datapath));
        let has_paper = JobKind::ALL.map(|kind| operations.iter().any(|operation| *operation == kind));
        let outcomes = Ring::new(datapath.shape().capacity());
        Self {
            flow,
            outcomes,
            accepted: None,
            operations,
            has_paper,
            lanes: lanes.count(),
            native,
            general,
            datapath: datapath.description().into(),
        }
    }

    /// Offers a job with a tag in this cycle. Returns whether it is accepted, which a job after an accepted one is not.
    ///
    /// # Errors
    /// A datapath without the operation; another number of coordinates or words than the operation has.
    // Always inlined, so that a caller that has branched on the kind of its job does it once.
    #[inline(always)]
    pub fn offer(&mut self, job: &Job<'_>, tag: u64) -> Result<bool, Error> {
        if let Job::Words { opcode, inputs } = *job {
            return self.offer_words(opcode, inputs, tag);
        }
        let opcode = self.opcode(job)?;
        if !self.input_ready(opcode) {
            return Ok(false);
        }
        let outcome = self.outcomes.push(tag);
        match (job, &mut self.native) {
            (Job::Quadbox { ray, boxes }, Some(native)) => native.quadbox(ray, boxes, outcome),
            (Job::Triangle { ray, triangle }, Some(native)) => native.triangle(ray, triangle, outcome),
            (Job::Euclidean(beat), Some(native)) => native.euclidean(beat, outcome),
            (Job::Angular(beat), Some(native)) => native.angular(beat, outcome),
            (Job::Words { opcode, .. } | Job::Timing { opcode }, _) => *outcome = Outcome::Timing(*opcode),
            (_, None) => *outcome = self.general.run(job),
        }
        self.accepted = Some(opcode);
        Ok(true)
    }

    /// One clock cycle. The job that was accepted enters, and if `output_ready`, the outcome at the output leaves.
    #[inline]
    pub fn step(&mut self, output_ready: bool) -> Option<&Tagged> {
        let taken = output_ready && self.flow.output_valid();
        self.flow.cycle(self.accepted.take(), taken);
        taken.then(|| self.outcomes.pop())
    }

    /// The words of the last [`Outcome::Words`] that left.
    pub fn left_words(&self) -> Option<&Words> {
        self.outcomes.left_words()
    }

    /// Advances up to `limit` cycles in which nothing else is offered and the sink is not ready, and stops in the first
    /// with a valid output. Returns the number of cycles. A job that was accepted enters in the first.
    pub fn skip(&mut self, limit: u64) -> u64 {
        if self.accepted.is_none() {
            return self.flow.idle(limit);
        }
        if limit == 0 || self.output_valid() {
            return 0;
        }
        self.step(false);
        1 + self.flow.idle(limit - 1)
    }

    /// Whether a job with this opcode would be accepted in this cycle.
    #[inline]
    pub fn input_ready(&self, opcode: u64) -> bool {
        self.accepted.is_none() && self.flow.input_ready(opcode)
    }

    /// Whether there is an outcome at the output in this cycle.
    #[inline]
    pub fn output_valid(&self) -> bool {
        self.flow.output_valid()
    }

    /// The outcome at the output in this cycle, and its words if it is [`Outcome::Words`]. It stays until a step takes
    /// it.
    pub fn output(&self) -> Option<(&Tagged, Option<&Words>)> {
        self.output_valid().then(|| self.outcomes.front())
    }

    /// The positions of the jobs inside, oldest first, without the one that was accepted in this cycle.
    pub fn positions(&self) -> impl Iterator<Item = PipelinePosition> + '_ {
        self.flow.positions()
    }

    fn offer_words(&mut self, opcode: u64, inputs: &[u64], tag: u64) -> Result<bool, Error> {
        let operation = operation(&self.operations, opcode)?;
        let expected = self.general.inputs(operation);
        if inputs.len() != expected {
            let problem = format!("{} words for a job of {operation}, expected {expected}", inputs.len());
            return Err(Error::Argument(problem));
        }
        if !self.input_ready(opcode) {
            return Ok(false);
        }
        let words = match (&mut self.native, operation.paper()) {
            // With typed jobs, whose accumulators it shares.
            (Some(native), Some(kind)) => self.general.outcome_of_words(operation, &native.run_words(kind, inputs)),
            _ => self.general.run_words(operation, inputs),
        };
        *self.outcomes.push(tag) = Outcome::Words(opcode);
        self.outcomes.push_words(words);
        self.accepted = Some(opcode);
        Ok(true)
    }

    /// The opcode of a job, if the datapath can compute it.
    #[inline(always)]
    fn opcode(&self, job: &Job<'_>) -> Result<u64, Error> {
        let (kind, lengths, lanes) = match job {
            Job::Quadbox { .. } => (JobKind::Quadbox, (0, 0), 0),
            Job::Triangle { .. } => (JobKind::Triangle, (0, 0), 0),
            Job::Euclidean(beat) => (JobKind::Euclidean, (beat.a.len(), beat.b.len()), self.lanes),
            Job::Angular(beat) => (JobKind::Angular, (beat.a.len(), beat.b.len()), self.lanes / 2),
            Job::Words { opcode, .. } | Job::Timing { opcode } => {
                return operation(&self.operations, *opcode).map(|found| found.opcode());
            }
        };
        if self.has_paper[kind as usize] && lengths == (lanes, lanes) {
            return Ok(kind.opcode());
        }
        Err(self.why_not(kind, lengths, lanes))
    }

    #[cold]
    fn why_not(&self, kind: JobKind, (a, b): (usize, usize), lanes: usize) -> Error {
        if !self.has_paper[kind as usize] {
            return no_operation(&self.operations, kind.name());
        }
        let problem = format!("a beat of {a} and {b} coordinates, expected {lanes} of each vector ({kind})");
        Error::Argument(problem)
    }

    /// The number of jobs inside, with the one that was accepted in this cycle.
    pub fn occupancy(&self) -> usize {
        self.outcomes.len()
    }

    /// The whole state as bytes, for [`restore`](Self::restore).
    pub fn save(&self) -> Vec<u8> {
        save(self, &self.datapath)
    }

    /// Takes over a saved state of a pipeline of an equal datapath. The words of the outcome that left last are gone.
    ///
    /// # Errors
    /// Bytes that no such pipeline of this release has saved. Then nothing changes.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let datapath = self.datapath.clone();
        restore(self, &datapath, bytes)
    }

    /// A cycle in which `rst_ni` is 0: all jobs are lost, and the accumulators are zero.
    pub fn reset(&mut self) {
        self.accepted = None;
        self.outcomes.clear();
        self.flow.reset();
        self.general.reset();
        self.native.iter_mut().for_each(|native| native.restart());
    }
}

impl fmt::Debug for Pipeline {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let positions: Vec<PipelinePosition> = self.positions().collect();
        f.debug_struct("Pipeline").field("operations", &self.operations).field("positions", &positions).finish()
    }
}
