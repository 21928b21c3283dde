//! Simulated timing of pictures and rays.

use crate::CliError;
use crate::commands::full::{Subject, watched};
use raypath_model::PipelinePosition;
use raypath_render::{PictureSpec, RayBatch, sweep_picture, sweep_rays, time_picture, time_rays};
use raypath_timing::report::Recorder;
use raypath_timing::{Observer, PortActivity, Sample, Sweep, System, Timing};

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

impl Subject for Simulated<'_> {
    fn title(&self) -> String {
        match &self.work {
            Work::Picture { spec, .. } => format!("{}, {} x {} pixels", self.name, spec.size.0, spec.size.1),
            Work::Rays(batch) => format!("{}, {} rays", self.name, batch.rays.len()),
        }
    }

    fn names(&self) -> (&'static str, &'static str) {
        self.work.names()
    }

    fn count(&self) -> usize {
        self.work.count()
    }

    fn time(&self, system: &System, recorder: &mut Recorder) -> Result<Timing, CliError> {
        let sample = Sample::spread(self.count(), self.max);
        let observer = &mut Owners { recorder, sample };
        let total = sample.numbers(self.count()).len();
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
        let sample = Sample::spread(self.count(), SWEPT);
        let total = sample.numbers(self.count()).len() * IN_FLIGHT.len() * LATENCIES.len();
        match &self.work {
            Work::Picture { spec, .. } => watched("pixels swept", total, |progress| {
                sweep_picture(spec, sample, &IN_FLIGHT, &LATENCIES, system, progress)
            }),
            Work::Rays(batch) => watched("rays swept", total, |progress| {
                sweep_rays(batch, sample, &IN_FLIGHT, &LATENCIES, system, progress)
            }),
        }
    }

    fn rows(&self, timing: &Timing, clock_mhz: f64) -> Vec<(String, String)> {
        let Work::Picture { rays, .. } = self.work else { return Vec::new() };
        let rays_per_pixel = rays as f64 / self.count() as f64;
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
