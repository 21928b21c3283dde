use crate::engine::{Engine, Run, Shown};
use crate::traffic::{Cycle, Traffic};
use raypath_model::Words;
use std::borrow::Borrow;
use std::collections::VecDeque;

/// The events of an engine in one cycle. Jobs are identified by their positions in the stream.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// The actions of source and sink.
    pub cycle: Cycle,
    /// The values of the output ports; not read in a cycle with a reset.
    pub shown: Shown,
    /// The job that was withdrawn before the cycle.
    pub withdrawn: Option<usize>,
    /// The job that was accepted.
    pub entered: Option<usize>,
    /// The job whose outcome the sink took; `None` also if no job was inside.
    pub left: Option<usize>,
    /// The number of jobs inside at the start of the cycle.
    pub inside: usize,
}

/// Runs `jobs` through an engine under `traffic`. `on_outcome` gets the position of each job and its outcome; the run
/// ends when it returns false. The run also ends after 100,000 cycles without progress, with fewer outcomes than jobs.
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

/// As [`drive`], but `on_cycle` gets every cycle.
pub fn observe<J: Borrow<Words>>(
    engine: &mut dyn Engine,
    jobs: impl Iterator<Item = J>,
    traffic: &mut Traffic,
    mut on_cycle: impl FnMut(&Seen) -> bool,
) -> Run {
    /// More cycles without progress than random traffic causes.
    const MAX_IDLE_CYCLES: u64 = 100_000;
    let mut source = Source { jobs: jobs.peekable(), index: 0 };
    let mut run = Run::default();
    let mut inside = VecDeque::new();
    let mut last_progress = 0;
    source.present(engine);
    while (source.jobs.peek().is_some() || !inside.is_empty()) && run.cycles - last_progress < MAX_IDLE_CYCLES {
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

/// The remaining jobs, of which the first is at the ports.
struct Source<I: Iterator> {
    jobs: std::iter::Peekable<I>,
    index: usize,
}

impl<J: Borrow<Words>, I: Iterator<Item = J>> Source<I> {
    fn present(&mut self, engine: &mut dyn Engine) {
        if let Some(job) = self.jobs.peek() {
            engine.present(job.borrow());
        }
    }

    /// Presents the next job and returns the position of the previous one. The last job stays at the ports.
    fn advance(&mut self, engine: &mut dyn Engine) -> Option<usize> {
        self.jobs.next()?;
        self.present(engine);
        self.index += 1;
        Some(self.index - 1)
    }
}
