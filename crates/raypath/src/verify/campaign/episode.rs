use crate::engine::{NetlistEngine, observe};
use crate::lockstep::{Difference, SideBySide};
use crate::models::PaperModel;
use crate::traffic::{Cycle, Traffic};
use crate::verify::coverage::{Atlas, Coverage, Features, Tracker};
use crate::verify::layout::Layout;
use crate::verify::shrink::Trace;
use crate::verify::stimuli::Stimuli;
use raypath_model::OnPorts;
use raypath_rtl::Config;

/// How many jobs an episode presents.
pub const JOBS_PER_EPISODE: usize = 256;
/// For so long anything may happen; then source and sink let the rest pass.
const EVENTFUL_CYCLES: u32 = 1200;

/// Some jobs and what happens around them, from the state on that a new netlist has: so that an episode fails alone as it
/// fails among others.
pub struct Episode<M: PaperModel> {
    jobs: Vec<M::Job>,
    traffic: Traffic,
}

/// What an episode found.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Found {
    /// Clock cycles.
    pub cycles: u64,
    /// The difference that ended it, in words.
    pub differences: Vec<String>,
}

impl<M: PaperModel> Episode<M> {
    /// The episode with this number in a campaign.
    pub fn new(model: &M, layout: &Layout, config: Config, seed: u64, number: u64) -> Self {
        let own = mixed(mixed(seed) ^ number);
        let mut stimuli = Stimuli::new(layout, config, own);
        let mut words = Vec::new();
        let jobs = (0..JOBS_PER_EPISODE).map(|_| {
            let kind = stimuli.next(&mut words);
            model.job_of_words(kind, &words)
        });
        Self { jobs: jobs.collect(), traffic: Traffic::eventful(mixed(own), EVENTFUL_CYCLES) }
    }

    /// Runs it up to the first difference.
    pub fn run(&self, netlist: &mut NetlistEngine<M>, model: &M, coverage: Option<(&Atlas, &mut Coverage)>) -> Found {
        let mut words = Vec::new();
        let features: Vec<Features> = coverage.as_ref().map_or_else(Vec::new, |(atlas, _)| {
            let of = |job: &M::Job| {
                job.words(&mut words);
                atlas.features(job.kind(), &words)
            };
            self.jobs.iter().map(of).collect()
        });
        let mut tracker = coverage.map(|(atlas, coverage)| Tracker::new(atlas, coverage, &features));
        netlist.restart();
        let is_different = std::cell::Cell::new(false);
        let mut engines = SideBySide::new(netlist, model.clone(), |_: Difference| is_different.set(true));
        let run = observe(&mut engines, self.jobs.iter(), &mut self.traffic.clone(), |seen| {
            if let Some(tracker) = &mut tracker {
                tracker.watch(seen);
            }
            !is_different.get()
        });
        Found { cycles: run.cycles, differences: engines.differences }
    }

    /// The same as a list of jobs and cycles.
    pub fn trace(self) -> Trace<M> {
        let mut traffic = self.traffic;
        let cycles: Vec<Cycle> = (0..EVENTFUL_CYCLES).map(|_| traffic.next_cycle()).collect();
        Trace { jobs: self.jobs, cycles }
    }
}

/// A number as if drawn at random for another (the finalizer of SplitMix64: Steele, Lea and Flood, OOPSLA 2014).
pub fn mixed(number: u64) -> u64 {
    let mut z = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
