use super::recording::{JobTrace, Span, Window};
use crate::observer::{Cycle, Observer};
use raypath_model::PipelinePosition;
use std::collections::VecDeque;

/// Writes down the first jobs from some cycle on, and where they are until they have left.
///
/// An [`Observer`] of [`crate::simulate`]; any other loop over a `CycleModel` calls [`cycle`](Observer::cycle)
/// in every cycle that it [wants](Observer::wants), before the model's cycle:
///
/// ```
/// use raypath_model::{CycleModel, Functional, Shape};
/// use raypath_ops::{Job, JobKind, Rules};
/// use raypath_timing::report::Recorder;
/// use raypath_timing::{Cycle, Observer};
///
/// let shape = Shape::default();
/// let mut model = CycleModel::new(Functional::<16, 8>::new(Rules::Paper), &shape);
/// let job = Job::from_ports(JobKind::Quadbox, |_| 0);
/// let mut recorder = Recorder::new("transaction", shape.latency, 0, 100);
/// for number in 0..20 {
///     let offer = Some(&job).filter(|_| number < 3);
///     let shown = model.output().is_some();
///     let cycle = Cycle {
///         number,
///         offered: offer.map(|job| (job.kind().opcode(), number)),
///         accepted: offer.is_some_and(|job| model.input_ready(job.kind().opcode())),
///         shown,
///         taken: shown,
///     };
///     recorder.cycle(&cycle, model.positions());
///     model.cycle(offer, true);
/// }
/// let window = recorder.window();
/// assert_eq!(window.jobs.len(), 3);
/// assert_eq!(window.jobs[2].entered, Vec::from_iter(3..15));
/// assert_eq!(window.jobs[2].left, Some(14));
/// ```
#[derive(Debug, Clone)]
pub struct Recorder {
    from: u64,
    most: usize,
    window: Window,
    /// The jobs inside, oldest first: which of the window's it is, none of a job that is not recorded.
    inside: VecDeque<Option<usize>>,
    /// How many of the window's jobs have left.
    left: usize,
    begun: bool,
}

impl Recorder {
    /// A recorder of the first `jobs` jobs that are accepted from cycle `from` on, in a pipeline of so many stages.
    /// `owner` is what a job's owner is called, as `ray`.
    pub fn new(owner: &str, stages: usize, from: u64, jobs: usize) -> Self {
        let window = Window { owner: owner.to_string(), first: from, end: from, stages, ..Window::default() };
        Self { from, most: jobs, window, inside: VecDeque::new(), left: 0, begun: false }
    }

    /// The pipeline was reset: the jobs inside never leave.
    pub fn reset(&mut self) {
        self.left += self.inside.drain(..).flatten().count();
    }

    /// What was recorded. Jobs that were inside when the last cycle passed have not left.
    pub fn window(self) -> Window {
        self.window
    }
}

impl Observer for Recorder {
    fn wants(&self, cycle: u64) -> Option<u64> {
        if self.left < self.most { Some(cycle.max(self.from)) } else { None }
    }

    fn cycle(&mut self, cycle: &Cycle, places: impl Iterator<Item = PipelinePosition>) {
        if self.wants(cycle.number) != Some(cycle.number) {
            return;
        }
        for (index, place) in places.enumerate() {
            if !self.begun {
                // It was accepted before anybody looked.
                self.inside.push_back(None);
            }
            let Some(Some(job)) = self.inside.get(index) else { continue };
            let entered = &mut self.window.jobs[*job].entered;
            if entered.len() < place.stage {
                entered.push(cycle.number);
            }
        }
        if !self.begun {
            (self.begun, self.window.first) = (true, cycle.number);
        }
        self.window.end = cycle.number + 1;
        if cycle.taken
            && let Some(Some(job)) = self.inside.pop_front()
        {
            self.window.jobs[job].left = Some(cycle.number);
            self.left += 1;
        }
        if let Some((opcode, owner)) = cycle.offered
            && cycle.accepted
        {
            let recorded = self.window.jobs.len() < self.most;
            self.inside.push_back(recorded.then_some(self.window.jobs.len()));
            if recorded {
                let entered = Vec::with_capacity(self.window.stages);
                let operation = opcode as usize;
                self.window.jobs.push(JobTrace { operation, owner, accepted: cycle.number, entered, left: None });
            }
        }
        if cycle.offered.is_some() && !cycle.accepted {
            extend(&mut self.window.refused, cycle.number);
        }
        if cycle.shown && !cycle.taken {
            extend(&mut self.window.stalled, cycle.number);
        }
    }
}

fn extend(spans: &mut Vec<Span>, cycle: u64) {
    match spans.last_mut() {
        Some(last) if last.from + last.cycles == cycle => last.cycles += 1,
        _ => spans.push(Span { from: cycle, cycles: 1 }),
    }
}
