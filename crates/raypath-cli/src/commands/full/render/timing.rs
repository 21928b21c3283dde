//! Simulated timing of pictures and rays: options, printed results and reports.

use crate::commands::full::{ViewArguments, print, recording, watched};
use crate::{CliError, number, whole};
use clap::Args;
use raypath_model::PipelinePosition;
use raypath_ops::JobKind;
use raypath_render::{PictureSpec, RayBatch, sweep_picture, sweep_rays, time_picture, time_rays};
use raypath_rtl::{Config, DatapathNetlist};
use raypath_sim::engine::shape;
use raypath_timing::report::{Recorder, Recording};
use raypath_timing::{Environment, Observer, PortActivity, Sample, Starved, Sweep, System, Timing, plot};
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(next_help_heading = "Timing: simulation of the pipeline with memory and several agents in flight")]
pub struct TimingArguments {
    /// Latency of a fetch in cycles: a node or a leaf
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

/// The number of pixels or rays at each point of a sweep.
const SWEPT: usize = 4096;
const IN_FLIGHT: [usize; 11] = [1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024];
const LATENCIES: [u64; 5] = [0, 20, 100, 300, 1000];

pub struct Simulated<'s> {
    pub name: String,
    pub work: Work<'s>,
    /// The maximum number of simulated pixels or rays.
    pub max: usize,
}

/// A picture with the number of rays of all its pixels, or the rays of a file.
pub enum Work<'s> {
    Picture { spec: PictureSpec<'s>, rays: u64 },
    Rays(RayBatch<'s>),
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
        subject: &Simulated<'_>,
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
        let (agents, agent) = subject.work.names();
        let mut recorder = self.view.recorder(agent, &datapath);
        let timing = subject.time(&system, &mut recorder)?;

        let mut recording = recording(subject.title(), config, &datapath, timing.cycles, &timing.jobs);
        recording.counts = vec![
            (format!("{agents} timed"), format!("{} of {}", timing.agents, subject.work.count())),
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

impl Simulated<'_> {
    fn title(&self) -> String {
        match &self.work {
            Work::Picture { spec, .. } => format!("{}, {} x {} pixels", self.name, spec.size.0, spec.size.1),
            Work::Rays(batch) => format!("{}, {} rays", self.name, batch.rays.len()),
        }
    }

    fn time(&self, system: &System, recorder: &mut Recorder) -> Result<Timing, CliError> {
        let sample = Sample::spread(self.work.count(), self.max);
        let observer = &mut Owners { recorder, sample };
        let total = sample.numbers(self.work.count()).len();
        match &self.work {
            Work::Picture { spec, .. } => watched("pixels timed", total, |progress| {
                time_picture(spec, sample, system, observer, progress).map(|(timing, _)| timing)
            }),
            Work::Rays(batch) => watched("rays timed", total, |progress| {
                time_rays(batch, sample, system, observer, progress).map(|(timing, _)| timing)
            }),
        }
    }

    fn sweep(&self, system: &System) -> Result<Sweep, CliError> {
        let sample = Sample::spread(self.work.count(), SWEPT);
        let total = sample.numbers(self.work.count()).len() * IN_FLIGHT.len() * LATENCIES.len();
        match &self.work {
            Work::Picture { spec, .. } => watched("pixels swept", total, |progress| {
                sweep_picture(spec, sample, &IN_FLIGHT, &LATENCIES, system, progress)
            }),
            Work::Rays(batch) => watched("rays swept", total, |progress| {
                sweep_rays(batch, sample, &IN_FLIGHT, &LATENCIES, system, progress)
            }),
        }
    }

    /// Further results at a clock frequency, as labels and formatted values.
    fn rows(&self, timing: &Timing, clock_mhz: f64) -> Vec<(String, String)> {
        let Work::Picture { rays, .. } = self.work else { return Vec::new() };
        let rays_per_pixel = rays as f64 / self.work.count() as f64;
        let rays_per_second = rays_per_pixel * timing.rates(clock_mhz).agents;
        vec![
            ("rays per pixel, in the whole picture".to_string(), format!("{rays_per_pixel:.3}")),
            (format!("rays per second at {clock_mhz} MHz"), format!("{rays_per_second:.4e}")),
        ]
    }
}

impl Work<'_> {
    /// The name of what it consists of, in plural and singular.
    pub fn names(&self) -> (&'static str, &'static str) {
        match self {
            Self::Picture { .. } => ("pixels", "pixel"),
            Self::Rays(_) => ("rays", "ray"),
        }
    }

    /// The first label for a picture, the second for rays.
    pub fn label(&self, [pixels, rays]: [&'static str; 2]) -> &'static str {
        if matches!(self, Self::Picture { .. }) { pixels } else { rays }
    }

    /// The number of pixels or rays.
    pub fn count(&self) -> usize {
        match self {
            Self::Picture { spec, .. } => spec.size.0 as usize * spec.size.1 as usize,
            Self::Rays(batch) => batch.rays.len(),
        }
    }
}

/// Records jobs with the numbers of their pixels or rays instead of those of the agents of a sample.
struct Owners<'r> {
    recorder: &'r mut Recorder,
    sample: Sample,
}

impl Observer for Owners<'_> {
    fn next_observed(&self, cycle: u64) -> Option<u64> {
        self.recorder.next_observed(cycle)
    }

    fn observe(&mut self, ports: &PortActivity, positions: impl Iterator<Item = PipelinePosition>) {
        let offered = ports.offered.map(|(kind, agent)| (kind, agent * self.sample.stride.get() as u64));
        self.recorder.observe(&PortActivity { offered, ..*ports }, positions);
    }
}

/// The results of a simulation as labels and formatted values. `agents` is the plural name of the agents.
fn rows(timing: &Timing, agents: &str, clock_mhz: f64) -> Vec<(String, String)> {
    let rates = timing.rates(clock_mhz);
    let Starved { memory, outcomes, both } = timing.starved;
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
        (format!("{agents} per second at {clock_mhz} MHz"), format!("{:.4e}", rates.agents)),
        (format!("seconds at {clock_mhz} MHz"), format!("{:.4e}", rates.seconds)),
    ]);
    rows
}
