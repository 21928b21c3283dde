use super::recording::{JobTrace, Span, Window};
use crate::agent::{Observer, PortActivity};
use raypath_model::PipelinePosition;
use std::collections::VecDeque;

/// An observer that records the first jobs accepted from a given cycle on, with their positions in every cycle.
///
/// It is an [`Observer`] for [`simulate`](crate::simulate). Any other loop over a `CycleModel` calls
/// [`observe`](Observer::observe) before the model's cycle:
///
/// ```
/// use raypath_model::{CycleModel, Functional, Shape};
/// use raypath_ops::{Job, JobKind, Rules};
/// use raypath_timing::report::Recorder;
/// use raypath_timing::{Observer, PortActivity};
///
/// let shape = Shape::default();
/// let mut pipeline = CycleModel::new(Functional::<16, 8>::new(Rules::Paper), &shape);
/// let job = Job::from_ports(JobKind::Quadbox, |_| 0);
/// let mut recorder = Recorder::new("transaction", shape.latency, 0, 100);
/// for cycle in 0..20 {
///     let offer = Some(&job).filter(|_| cycle < 3);
///     let output_valid = pipeline.output().is_some();
///     let ports = PortActivity {
///         cycle,
///         offered: offer.map(|job| (job.kind().opcode(), cycle)),
///         accepted: offer.is_some_and(|job| pipeline.input_ready(job.kind().opcode())),
///         output_valid,
///         output_taken: output_valid,
///     };
///     recorder.observe(&ports, pipeline.positions());
///     pipeline.cycle(offer, true);
/// }
/// let window = recorder.window();
/// assert_eq!(window.jobs.len(), 3);
/// assert_eq!(window.jobs[2].entered, Vec::from_iter(3..15));
/// assert_eq!(window.jobs[2].left, Some(14));
/// ```
#[derive(Debug, Clone)]
pub struct Recorder {
    from: u64,
    max_jobs: usize,
    window: Window,
    /// The indices in the window of the jobs inside, oldest first; `None` for a job that is not recorded.
    inside: VecDeque<Option<usize>>,
    /// The number of recorded jobs that have left.
    left: usize,
    started: bool,
}

impl Recorder {
    /// A recorder of the first `max_jobs` jobs that are accepted from cycle `from` on, in a pipeline of `stages`
    /// stages. `owner` is the name of a job's owner, such as `ray`.
    pub fn new(owner: &str, stages: usize, from: u64, max_jobs: usize) -> Self {
        let window = Window { owner: owner.to_string(), first: from, end: from, stages, ..Window::default() };
        Self { from, max_jobs, window, inside: VecDeque::new(), left: 0, started: false }
    }

    /// Records a reset of the pipeline, which discards the jobs inside.
    pub fn reset(&mut self) {
        self.left += self.inside.drain(..).flatten().count();
    }

    /// The recorded window.
    pub fn window(self) -> Window {
        self.window
    }
}

impl Observer for Recorder {
    fn next_observed(&self, cycle: u64) -> Option<u64> {
        if self.left < self.max_jobs { Some(cycle.max(self.from)) } else { None }
    }

    fn observe(&mut self, ports: &PortActivity, positions: impl Iterator<Item = PipelinePosition>) {
        let now = ports.cycle;
        if self.next_observed(now) != Some(now) {
            return;
        }
        for (index, position) in positions.enumerate() {
            if !self.started {
                // Accepted before the first observed cycle.
                self.inside.push_back(None);
            }
            let Some(Some(job)) = self.inside.get(index) else { continue };
            let entered = &mut self.window.jobs[*job].entered;
            if entered.len() < position.stage {
                entered.push(now);
            }
        }
        if !self.started {
            (self.started, self.window.first) = (true, now);
        }
        self.window.end = now + 1;
        if ports.output_taken
            && let Some(Some(job)) = self.inside.pop_front()
        {
            self.window.jobs[job].left = Some(now);
            self.left += 1;
        }
        if let Some((opcode, owner)) = ports.offered
            && ports.accepted
        {
            let recorded = self.window.jobs.len() < self.max_jobs;
            self.inside.push_back(recorded.then_some(self.window.jobs.len()));
            if recorded {
                let entered = Vec::with_capacity(self.window.stages);
                let operation = opcode as usize;
                self.window.jobs.push(JobTrace { operation, owner, accepted: now, entered, left: None });
            }
        }
        if ports.offered.is_some() && !ports.accepted {
            extend(&mut self.window.refused, now);
        }
        if ports.output_valid && !ports.output_taken {
            extend(&mut self.window.stalled, now);
        }
    }
}

/// Adds a cycle to ascending spans.
fn extend(spans: &mut Vec<Span>, cycle: u64) {
    match spans.last_mut() {
        Some(last) if last.from + last.cycles == cycle => last.cycles += 1,
        _ => spans.push(Span { from: cycle, cycles: 1 }),
    }
}
