use raypath_ops::JobKind;

/// How long a run took, and where its cycles went.
///
/// Each cycle is one of three: a job was [accepted](Self::accepted), one was offered and [refused](Self::refused), or the
/// source had none to offer ([starved](Self::starved)). They add up to [`cycles`](Self::cycles).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Timing {
    /// Cycles from the first to the one in which the last agent was done.
    pub cycles: u64,
    /// Agents that were done.
    pub agents: u64,
    /// Jobs of each kind, by opcode.
    pub jobs: [u64; 4],
    /// Fetches of all agents.
    pub fetches: u64,
    /// Cycles in which a job was accepted.
    pub accepted: u64,
    /// Cycles in which a job was offered and not accepted: the sink's back pressure has reached the entrance, or an
    /// accumulator keeps beats apart. With a sink that always takes it is the latter.
    pub refused: u64,
    /// Cycles in which there was no job to offer.
    pub starved: Starved,
    /// Cycles in which the output showed an answer that the sink did not take.
    pub sink_refused: u64,
    /// Cycles that jobs spent inside, over all jobs: from the cycle after it was accepted to the one in which its answer
    /// was taken. Divided by jobs it is the mean latency, divided by cycles the mean number of jobs inside.
    pub inside: u64,
    /// Cycles that jobs stood in line before they were accepted, over all jobs.
    pub queued: u64,
}

/// Cycles in which the source had no job to offer, by what the live agents were waiting for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Starved {
    /// All for memory.
    pub memory: u64,
    /// All for answers that were in the pipeline.
    pub answers: u64,
    /// Some for memory and the others for answers.
    pub both: u64,
    /// Some had a job, but another agent holds the datapath and is waiting.
    pub held: u64,
}

/// What a run is at some clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates {
    /// How long the run takes, in seconds.
    pub seconds: f64,
    /// Jobs a second.
    pub jobs: f64,
    /// Agents a second.
    pub agents: f64,
    /// Fetches a second.
    pub fetches: f64,
}

impl Timing {
    /// Jobs of all kinds.
    pub fn all_jobs(&self) -> u64 {
        self.jobs.iter().sum()
    }

    /// Jobs of one kind.
    pub fn jobs_of(&self, kind: JobKind) -> u64 {
        self.jobs[kind as usize]
    }

    /// Jobs a cycle: 0 ≤ x ≤ 1, and 0 of a run without cycles.
    pub fn jobs_per_cycle(&self) -> f64 {
        self.per_cycle(self.all_jobs())
    }

    /// Agents a cycle; 0 of a run without cycles.
    pub fn agents_per_cycle(&self) -> f64 {
        self.per_cycle(self.agents)
    }

    /// Cycles from a job's acceptance to its answer being taken, on average; 0 of a run without jobs.
    pub fn mean_latency(&self) -> f64 {
        if self.all_jobs() == 0 { 0.0 } else { self.inside as f64 / self.all_jobs() as f64 }
    }

    /// What the run is at a clock of so many MHz, which is greater than 0.
    pub fn at(&self, clock_mhz: f64) -> Rates {
        let hertz = clock_mhz * 1e6;
        Rates {
            seconds: self.cycles as f64 / hertz,
            jobs: self.jobs_per_cycle() * hertz,
            agents: self.agents_per_cycle() * hertz,
            fetches: self.per_cycle(self.fetches) * hertz,
        }
    }

    fn per_cycle(&self, count: u64) -> f64 {
        if self.cycles == 0 { 0.0 } else { count as f64 / self.cycles as f64 }
    }
}

impl Starved {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.memory + self.answers + self.both + self.held
    }
}
