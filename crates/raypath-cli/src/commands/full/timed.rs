//! Simulated timing for `render` and `search`: options, printed results and reports.

use crate::commands::full::{ViewArguments, print, recording};
use crate::{CliError, number, whole};
use clap::Args;
use raypath_ops::JobKind;
use raypath_rtl::{Config, DatapathNetlist};
use raypath_sim::engine::shape;
use raypath_timing::report::{Recorder, Recording};
use raypath_timing::{Environment, Starved, Sweep, System, Timing, plot};
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(next_help_heading = "Timing: simulation of the pipeline with memory and several agents in flight")]
pub struct TimingArguments {
    /// Latency of a fetch in cycles: a node, a leaf or a vector
    #[arg(long, default_value_t = 100, value_parser = whole(0..=1_000_000u64), value_name = "M")]
    memory_latency: u64,
    /// Assumed clock frequency for rates, in MHz
    #[arg(long, default_value_t = 1000.0, value_parser = number(0.001..=1e6, "MHz, 0.001 to 1000000"), value_name = "MHZ")]
    clock: f64,
    /// Plot throughput over agents in flight, for several memory latencies, for a sample of the work
    #[arg(long, value_name = "FILE.svg")]
    sweep: Option<PathBuf>,
    /// Skip the simulation
    #[arg(long, conflicts_with_all = ["memory_latency", "clock", "timed", "sweep", "report", "konata"])]
    no_timing: bool,
    #[command(flatten)]
    pub view: ViewArguments,
}

/// Work to simulate.
pub trait Subject {
    /// The title of the report.
    fn title(&self) -> String;
    /// The name of its agents in plural and singular.
    fn names(&self) -> (&'static str, &'static str);
    /// The number of agents.
    fn count(&self) -> usize;
    /// Simulates the selected agents.
    fn time(&self, system: &System, recorder: &mut Recorder) -> Result<Timing, CliError>;
    /// Simulates a sample in several environments.
    fn sweep(&self, system: &System) -> Result<Sweep, CliError>;
    /// Further results at a clock frequency, as labels and formatted values.
    fn rows(&self, timing: &Timing, clock_mhz: f64) -> Vec<(String, String)>;
}

/// The result of a simulation: the recording for a report, and files to write.
pub struct Timed {
    pub recording: Recording,
    pub files: Vec<(PathBuf, Vec<u8>)>,
}

impl TimingArguments {
    pub fn has_sweep(&self) -> bool {
        self.sweep.is_some()
    }

    /// The file of the plot.
    pub fn sweep(&self) -> Option<&PathBuf> {
        self.sweep.as_ref()
    }

    /// The clock in MHz for which rates are printed.
    pub fn clock(&self) -> f64 {
        self.clock
    }

    /// The latency of the memory; `None` with `--no-timing`.
    pub fn memory_latency(&self) -> Option<u64> {
        (!self.no_timing).then_some(self.memory_latency)
    }

    /// Simulates with `in_flight` agents in flight and prints the results; `None` with `--no-timing`.
    pub fn run(
        &self,
        subject: &impl Subject,
        in_flight: usize,
        config: Config,
        out: &mut dyn Write,
    ) -> Result<Option<Timed>, CliError> {
        if self.no_timing {
            return Ok(None);
        }
        let datapath = DatapathNetlist::new(config)?;
        let environment = Environment { in_flight, memory_latency: self.memory_latency, ..Environment::default() };
        let system = System { environment, shape: shape(config, &datapath) };
        let (agents, agent) = subject.names();
        let mut recorder = self.view.recorder(agent, &datapath);
        let timing = subject.time(&system, &mut recorder)?;

        let mut recording = recording(subject.title(), config, &datapath, timing.cycles, &timing.jobs);
        recording.counts = vec![
            (format!("{agents} timed"), format!("{} of {}", timing.agents, subject.count())),
            (format!("{agents} in flight"), in_flight.to_string()),
            ("memory latency".to_string(), format!("{} cycles", self.memory_latency)),
        ];
        recording.counts.extend(rows(&timing, agents, self.clock));
        recording.counts.extend(subject.rows(&timing, self.clock));
        recording.window = recorder.window();
        print(&recording, out)?;

        let mut files = Vec::new();
        if self.sweep.is_some() || self.view.has_report() {
            let svg = plot(&subject.sweep(&system)?, &format!("Throughput: {}", subject.title()), agents);
            files.extend(self.sweep.iter().map(|path| (path.clone(), svg.clone().into_bytes())));
            recording.sweep = Some(svg);
        }
        Ok(Some(Timed { recording, files }))
    }
}

/// The results of a simulation as labels and formatted values. `agents` is the plural name of the agents.
fn rows(timing: &Timing, agents: &str, clock_mhz: f64) -> Vec<(String, String)> {
    let rates = timing.rates(clock_mhz);
    let Starved { memory, outcomes, both, locked } = timing.starved;
    let cycles = |count: u64| format!("{count} ({:.1} %)", 100.0 * count as f64 / timing.cycles.max(1) as f64);
    let mut rows = vec![("cycles".to_string(), timing.cycles.to_string())];
    rows.push(("jobs".to_string(), timing.total_jobs().to_string()));
    let kinds = JobKind::ALL.into_iter().filter(|kind| timing.jobs_of(*kind) > 0);
    rows.extend(kinds.map(|kind| (format!("  {kind}"), timing.jobs_of(kind).to_string())));
    rows.extend([
        ("jobs per cycle".to_string(), format!("{:.3}", timing.jobs_per_cycle())),
        ("mean latency of a job".to_string(), format!("{:.2} cycles", timing.mean_latency())),
        ("fetches".to_string(), timing.fetches.to_string()),
        ("cycles with a job accepted".to_string(), cycles(timing.accepted)),
        ("cycles with a job refused".to_string(), cycles(timing.refused)),
        ("cycles starved: all wait for memory".to_string(), cycles(memory)),
        ("cycles starved: all wait for outcomes".to_string(), cycles(outcomes)),
        ("cycles starved: some wait for each".to_string(), cycles(both)),
        ("cycles starved: datapath locked by another".to_string(), cycles(locked)),
        (format!("{agents} per second at {clock_mhz} MHz"), format!("{:.4e}", rates.agents)),
        (format!("seconds at {clock_mhz} MHz"), format!("{:.4e}", rates.seconds)),
    ]);
    rows
}
