//! Episodes: the independent parts of a campaign.

use super::failure::Trace;
use crate::coverage::{Coverage, CoverageModel, JobPoints, Tracker};
use crate::layout::Layout;
use crate::stimuli::{Stimuli, splitmix64};
use raypath_model::{WordModel, Words};
use raypath_sim::engine::{NetlistEngine, observe};
use raypath_sim::lockstep::{Difference, SideBySide};
use raypath_sim::traffic::{Cycle, Traffic};

/// The number of jobs in an episode.
pub const JOBS_PER_EPISODE: usize = 256;
/// The cycles with random handshakes; afterwards source and sink are always ready, and the remaining jobs pass.
const EVENTFUL_CYCLES: u32 = 1200;

/// A sequence of jobs and handshakes that starts from a new netlist's state. An episode therefore fails alone as it
/// fails in the campaign.
pub struct Episode {
    jobs: Vec<Words>,
    traffic: Traffic,
    /// The seed of the state that the netlist begins in.
    pub initial: u64,
}

/// The result of an episode.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Found {
    /// Clock cycles.
    pub cycles: u64,
    /// The difference that ended the episode.
    pub differences: Vec<String>,
}

impl Episode {
    /// The episode with this number in the campaign of this seed.
    pub fn new(model: &WordModel, layout: &Layout, seed: u64, number: u64) -> Self {
        let own = splitmix64(splitmix64(seed) ^ number);
        let mut stimuli = Stimuli::new(layout, model, own);
        let mut words = Vec::new();
        let jobs = (0..JOBS_PER_EPISODE).map(|_| {
            let kind = stimuli.next(&mut words);
            model.job_of_words(kind, &words)
        });
        let traffic = Traffic::eventful(splitmix64(own), EVENTFUL_CYCLES);
        Self { jobs: jobs.collect(), traffic, initial: own }
    }

    /// Runs the episode up to the first difference.
    pub fn run(
        &self,
        netlist: &mut NetlistEngine,
        model: &WordModel,
        coverage: Option<(&CoverageModel, &mut Coverage)>,
    ) -> Found {
        let points: Vec<JobPoints> = coverage.as_ref().map_or_else(Vec::new, |(model, _)| {
            self.jobs.iter().map(|job| model.job_points(job.kind(), job.as_words())).collect()
        });
        let mut tracker = coverage.map(|(model, coverage)| Tracker::new(model, coverage, &points));
        netlist.restart_randomly(self.initial);
        let is_different = std::cell::Cell::new(false);
        let mut engines = SideBySide::new(netlist, model.clone(), |_: Difference| is_different.set(true));
        let run = observe(&mut engines, self.jobs.iter(), &mut self.traffic.clone(), |seen| {
            if let Some(tracker) = &mut tracker {
                tracker.observe(seen);
            }
            !is_different.get()
        });
        Found { cycles: run.cycles, differences: engines.differences }
    }

    /// The episode as a trace of jobs and cycles.
    pub fn trace(self) -> Trace {
        let mut traffic = self.traffic;
        let cycles: Vec<Cycle> = (0..EVENTFUL_CYCLES).map(|_| traffic.next_cycle()).collect();
        Trace { jobs: self.jobs, cycles }
    }
}
