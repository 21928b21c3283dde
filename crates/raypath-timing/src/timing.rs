use raypath_ops::JobKind;

/// The cycle count of a simulation, and how the cycles were used.
///
/// Each cycle has one of three uses: a job was [accepted](Self::accepted), a job was offered and
/// [refused](Self::refused), or no job was offered ([starved](Self::starved)). Their sum is [`cycles`](Self::cycles).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Timing {
    /// Cycles until the last agent was done.
    pub cycles: u64,
    /// Completed agents.
    pub agents: u64,
    /// Accepted jobs of each kind, by opcode.
    pub jobs: [u64; 4],
    /// Fetches of all agents.
    pub fetches: u64,
    /// Cycles in which a job was accepted.
    pub accepted: u64,
    /// Cycles in which a job was offered and not accepted, because of back pressure from the sink or because a
    /// multi-cycle accumulator was busy. With [`Sink::Always`](crate::Sink::Always) only the latter occurs.
    pub refused: u64,
    /// Cycles in which no job was offered.
    pub starved: Starved,
    /// Cycles in which the output was valid and the sink not ready.
    pub sink_refused: u64,
    /// The sum of all jobs' latencies, each from the cycle after acceptance to the cycle in which the sink took the
    /// outcome. Divided by `cycles` it is the mean number of jobs inside.
    pub latency_sum: u64,
    /// The sum of all jobs' waiting times before acceptance, in cycles.
    pub queueing_sum: u64,
}

/// Cycles in which no job was offered, by what the agents in flight were waiting for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Starved {
    /// All agents were waiting for memory.
    pub memory: u64,
    /// All agents were waiting for outcomes from the pipeline.
    pub outcomes: u64,
    /// Some agents were waiting for memory, the others for outcomes.
    pub both: u64,
}

/// Rates of a simulation at a clock frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates {
    /// The duration of the simulated run in seconds.
    pub seconds: f64,
    /// Jobs per second.
    pub jobs: f64,
    /// Agents per second.
    pub agents: f64,
    /// Fetches per second.
    pub fetches: f64,
}

impl Timing {
    /// Accepted jobs of all kinds.
    pub fn total_jobs(&self) -> u64 {
        self.jobs.iter().sum()
    }

    /// Accepted jobs of one kind.
    pub fn jobs_of(&self, kind: JobKind) -> u64 {
        self.jobs[kind as usize]
    }

    /// Jobs per cycle, 0 to 1; 0 if there were no cycles.
    pub fn jobs_per_cycle(&self) -> f64 {
        self.per_cycle(self.total_jobs())
    }

    /// Agents per cycle; 0 if there were no cycles.
    pub fn agents_per_cycle(&self) -> f64 {
        self.per_cycle(self.agents)
    }

    /// The mean latency of a job in cycles, from acceptance to the sink; 0 if there were no jobs.
    pub fn mean_latency(&self) -> f64 {
        if self.total_jobs() == 0 { 0.0 } else { self.latency_sum as f64 / self.total_jobs() as f64 }
    }

    /// The rates at a clock of `clock_mhz` MHz, which must be greater than 0.
    pub fn rates(&self, clock_mhz: f64) -> Rates {
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
    /// The sum over all causes.
    pub fn total(&self) -> u64 {
        self.memory + self.outcomes + self.both
    }
}
