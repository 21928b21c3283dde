use crate::general::General;
use crate::job::{Job, Outcome, no_operation, operation};
use crate::paper::{Native, PaperModel};
use crate::{Datapath, Error};
use raypath_model::{Elastic, PipelinePosition, Transfer};
use raypath_ops::JobKind;
use raypath_rtl::Lanes;
use raypath_sim::OperationId;
use std::collections::VecDeque;
use std::fmt;

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
/// assert_eq!(pipeline.output().map(|(tag, _)| tag), Some(7));
/// let (tag, outcome) = pipeline.step(true).expect("the output is valid");
/// assert!(tag == 7 && matches!(outcome, Outcome::Triangle(result) if result.triangle_hit == 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Pipeline {
    flow: Elastic<()>,
    /// The tags and outcomes of the jobs inside, oldest first. An outcome is computed when its job is offered, because
    /// it depends on the order of jobs alone; it is not moved until it has left, which would take as long.
    outcomes: VecDeque<(u64, Outcome)>,
    /// The oldest outcome left in the last cycle.
    has_left: bool,
    /// The opcode of the job that was accepted in this cycle.
    accepted: Option<u64>,
    operations: Vec<OperationId>,
    /// Whether the datapath has each of the paper's operations.
    has_paper: [bool; JobKind::ALL.len()],
    lanes: usize,
    /// Native arithmetic, for datapaths in binary32 without features.
    native: Option<Box<dyn Native>>,
    general: General,
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
        let flow = Elastic::new(datapath.shape());
        let (operations, general) = (datapath.operations(), General::new(datapath));
        let has_paper = JobKind::ALL.map(|kind| operations.iter().any(|operation| *operation == kind));
        let outcomes = VecDeque::with_capacity(datapath.shape().capacity() + 2);
        Self {
            flow,
            outcomes,
            has_left: false,
            accepted: None,
            operations,
            has_paper,
            lanes: lanes.count(),
            native,
            general,
        }
    }

    /// Offers a job with a tag in this cycle. Returns whether it is accepted, which a job after an accepted one is not.
    ///
    /// # Errors
    /// A datapath without the operation; another number of coordinates or words than the operation has.
    #[inline]
    pub fn offer(&mut self, job: &Job<'_>, tag: u64) -> Result<bool, Error> {
        let opcode = self.opcode(job)?;
        if !self.input_ready(opcode) {
            return Ok(false);
        }
        match (*job, &mut self.native) {
            (Job::Timing { opcode }, _) => self.outcomes.push_back((tag, Outcome::Timing(opcode))),
            (Job::Words { inputs, .. }, native) => {
                let found = operation(&self.operations, opcode)?;
                let words = match (native, found.paper()) {
                    // With typed jobs, whose accumulators it shares.
                    (Some(native), Some(kind)) => self.general.outcome_of_words(found, &native.run_words(kind, inputs)),
                    _ => self.general.run_words(found, inputs),
                };
                self.outcomes.push_back((tag, Outcome::Words(Box::new(words))));
            }
            (_, Some(native)) => native.run(job, tag, &mut self.outcomes),
            (_, None) => self.outcomes.push_back((tag, self.general.run(job))),
        }
        self.accepted = Some(opcode);
        Ok(true)
    }

    /// One clock cycle. The job that was accepted enters, and if `output_ready`, the outcome at the output leaves with
    /// its tag.
    #[inline]
    pub fn step(&mut self, output_ready: bool) -> Option<(u64, &Outcome)> {
        self.forget_left();
        let Transfer { output, .. } = self.flow.cycle(self.accepted.take().map(|opcode| (opcode, ())), output_ready);
        output?;
        self.has_left = true;
        self.outcomes.front().map(|(tag, outcome)| (*tag, outcome))
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
        self.flow.output().is_some()
    }

    /// The outcome at the output in this cycle with its tag. It stays until a step takes it.
    #[inline]
    pub fn output(&self) -> Option<(u64, &Outcome)> {
        self.flow.output()?;
        self.outcomes.get(usize::from(self.has_left)).map(|(tag, outcome)| (*tag, outcome))
    }

    /// The positions of the jobs inside, oldest first, without the one that was accepted in this cycle.
    pub fn positions(&self) -> impl Iterator<Item = PipelinePosition> + '_ {
        self.flow.positions()
    }

    #[inline]
    fn forget_left(&mut self) {
        if std::mem::take(&mut self.has_left) {
            self.outcomes.pop_front();
        }
    }

    /// The opcode of a job, if the datapath can compute it.
    #[inline(always)]
    fn opcode(&self, job: &Job<'_>) -> Result<u64, Error> {
        let (kind, lengths, lanes) = match *job {
            Job::Quadbox { .. } => (JobKind::Quadbox, (0, 0), 0),
            Job::Triangle { .. } => (JobKind::Triangle, (0, 0), 0),
            Job::Euclidean(beat) => (JobKind::Euclidean, (beat.a.len(), beat.b.len()), self.lanes),
            Job::Angular(beat) => (JobKind::Angular, (beat.a.len(), beat.b.len()), self.lanes / 2),
            Job::Timing { opcode } if self.operations.iter().any(|found| found.opcode() == opcode) => {
                return Ok(opcode);
            }
            Job::Timing { opcode } => return Err(no_operation(&self.operations, &format!("opcode {opcode}"))),
            Job::Words { opcode, inputs } => return self.check_words(opcode, inputs.len()).map(|()| opcode),
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

    fn check_words(&self, opcode: u64, given: usize) -> Result<(), Error> {
        let found = operation(&self.operations, opcode)?;
        let expected = self.general.inputs(found);
        let problem = || Error::Argument(format!("{given} words for a job of {found}, expected {expected}"));
        if given == expected { Ok(()) } else { Err(problem()) }
    }

    /// The number of jobs inside, with the one that was accepted in this cycle.
    pub fn occupancy(&self) -> usize {
        self.outcomes.len() - usize::from(self.has_left)
    }

    /// A cycle in which `rst_ni` is 0: all jobs are lost, and the accumulators are zero.
    pub fn reset(&mut self) {
        self.accepted = None;
        self.has_left = false;
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
