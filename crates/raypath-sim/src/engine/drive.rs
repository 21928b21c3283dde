use crate::engine::{Engine, Run, Shown};
use crate::traffic::{Cycle, Traffic};
use raypath_model::Words;
use std::borrow::Borrow;
use std::collections::VecDeque;

/// What was seen of an engine in one cycle. Jobs are told by their positions among those that were presented.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// What source and sink did.
    pub cycle: Cycle,
    /// What the ports showed; in a cycle with a reset nothing is looked at.
    pub shown: Shown,
    /// The job that was withdrawn before the cycle.
    pub withdrawn: Option<usize>,
    /// The job that entered.
    pub entered: Option<usize>,
    /// The job whose outcome the sink took; none where no job is inside.
    pub left: Option<usize>,
    /// How many jobs were inside as the cycle began.
    pub inside: usize,
}

/// Feeds `jobs` to an engine under `traffic`, each presented once, and shows each outcome as it leaves, with its job's
/// position, until `on_outcome` answers false. Gives up when nothing has left for a long time: then fewer jobs come out
/// than went in.
pub fn drive<J: Borrow<Words>>(
    engine: &mut dyn Engine,
    jobs: impl Iterator<Item = J>,
    traffic: &mut Traffic,
    mut on_outcome: impl FnMut(usize, Words) -> bool,
) -> Run {
    observe(engine, jobs, traffic, |seen| match (seen.left, &seen.shown.output) {
        (Some(index), Some(outcome)) => on_outcome(index, outcome.clone()),
        _ => true,
    })
}

/// The same, but shows every cycle.
pub fn observe<J: Borrow<Words>>(
    engine: &mut dyn Engine,
    jobs: impl Iterator<Item = J>,
    traffic: &mut Traffic,
    mut on_cycle: impl FnMut(&Seen) -> bool,
) -> Run {
    /// More idle cycles than any traffic makes by chance.
    const PATIENCE: u64 = 100_000;
    let mut source = Source { jobs: jobs.peekable(), index: 0 };
    let mut run = Run::default();
    let mut inside = VecDeque::new();
    let mut last_progress = 0;
    source.present(engine);
    while (source.jobs.peek().is_some() || !inside.is_empty()) && run.cycles - last_progress < PATIENCE {
        let mut cycle = traffic.next_cycle();
        let withdrawn = if cycle.withdraws { source.advance(engine) } else { None };
        run.dropped += usize::from(withdrawn.is_some());
        cycle.offers &= source.jobs.peek().is_some() && !cycle.resets;
        cycle.takes &= !cycle.resets;
        run.cycles += 1;
        let nothing = Shown { input_ready: false, output: None };
        let mut seen = Seen { cycle, shown: nothing, withdrawn, entered: None, left: None, inside: inside.len() };
        if cycle.resets {
            engine.reset();
            run.dropped += inside.len();
            inside.clear();
        } else {
            seen.shown = engine.cycle(cycle.offers, cycle.takes);
            if seen.shown.output.is_some() && cycle.takes {
                seen.left = inside.pop_front();
                run.jobs += usize::from(seen.left.is_some());
                run.spurious += usize::from(seen.left.is_none());
            }
            if cycle.offers && seen.shown.input_ready {
                seen.entered = source.advance(engine);
                inside.extend(seen.entered);
            }
        }
        if withdrawn.is_some() || seen.entered.is_some() || seen.left.is_some() {
            last_progress = run.cycles;
        }
        if !on_cycle(&seen) {
            break;
        }
    }
    run
}

/// The jobs to come; the first of them is at the ports.
struct Source<I: Iterator> {
    jobs: std::iter::Peekable<I>,
    /// Position of the job at the ports.
    index: usize,
}

impl<J, I: Iterator<Item = J>> Source<I> {
    fn present(&mut self, engine: &mut dyn Engine)
    where
        J: Borrow<Words>,
    {
        if let Some(job) = self.jobs.peek() {
            engine.present(job.borrow());
        }
    }

    /// Goes on to the next job. Gives the position of the one that is over; the last stays at the ports.
    fn advance(&mut self, engine: &mut dyn Engine) -> Option<usize>
    where
        J: Borrow<Words>,
    {
        self.jobs.next()?;
        self.present(engine);
        self.index += 1;
        Some(self.index - 1)
    }
}
