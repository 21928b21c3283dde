//! Simulated timing of pictures and rays.

use crate::commands::full::progress::watched;
use crate::commands::full::timed::Subject;
use crate::error::CliError;
use raypath_model::PipelinePosition;
use raypath_ops::{Binary32, Ray};
use raypath_render::{
    Camera, PictureSpec, RayBatch, Scene, Shading, Tracing, sweep_picture, sweep_rays, time_picture, time_rays,
};
use raypath_timing::report::Recorder;
use raypath_timing::{Observer, PortActivity, Sample, Sweep, System, Timing};

/// The number of pixels or rays at each point of a sweep.
const SWEPT: usize = 4096;
const IN_FLIGHT: [usize; 11] = [1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024];
const LATENCIES: [u64; 5] = [0, 20, 100, 300, 1000];

/// A picture to simulate.
pub struct Pixels<'s> {
    pub name: String,
    pub scene: &'s Scene,
    pub camera: Camera,
    pub size: (u32, u32),
    pub shading: Shading,
    /// The number of rays of the whole picture.
    pub rays: u64,
    /// The maximum number of simulated pixels.
    pub max: usize,
}

/// Rays of a file to simulate.
pub struct Rays<'s> {
    pub name: String,
    pub scene: &'s Scene,
    pub rays: &'s [Ray<Binary32>],
    pub tracing: Tracing,
    /// The maximum number of simulated rays.
    pub max: usize,
}

impl Pixels<'_> {
    fn spec(&self) -> PictureSpec<'_> {
        PictureSpec { scene: self.scene, camera: self.camera, size: self.size, shading: self.shading }
    }
}

impl Subject for Pixels<'_> {
    fn title(&self) -> String {
        format!("{}, {} x {} pixels", self.name, self.size.0, self.size.1)
    }

    fn names(&self) -> (&'static str, &'static str) {
        ("pixels", "pixel")
    }

    fn count(&self) -> usize {
        self.size.0 as usize * self.size.1 as usize
    }

    fn time(&self, system: &System, recorder: &mut Recorder) -> Result<Timing, CliError> {
        let sample = Sample::spread(self.count(), self.max);
        watched("pixels timed", sample.numbers(self.count()).len(), |progress| {
            time_picture(&self.spec(), sample, system, &mut Owners { recorder, sample }, progress)
                .map(|(timing, _)| timing)
        })
    }

    fn sweep(&self, system: &System) -> Result<Sweep, CliError> {
        let sample = Sample::spread(self.count(), SWEPT);
        watched("pixels swept", swept(sample, self.count()), |progress| {
            sweep_picture(&self.spec(), sample, &IN_FLIGHT, &LATENCIES, system, progress)
        })
    }

    fn rows(&self, timing: &Timing, clock_mhz: f64) -> Vec<(String, String)> {
        let rays_per_pixel = self.rays as f64 / self.count() as f64;
        vec![
            ("rays per pixel, in the whole picture".to_string(), format!("{rays_per_pixel:.3}")),
            (
                format!("rays per second at {clock_mhz} MHz"),
                format!("{:.4e}", rays_per_pixel * timing.rates(clock_mhz).agents),
            ),
        ]
    }
}

impl Subject for Rays<'_> {
    fn title(&self) -> String {
        format!("{}, {} rays", self.name, self.rays.len())
    }

    fn names(&self) -> (&'static str, &'static str) {
        ("rays", "ray")
    }

    fn count(&self) -> usize {
        self.rays.len()
    }

    fn time(&self, system: &System, recorder: &mut Recorder) -> Result<Timing, CliError> {
        let sample = Sample::spread(self.count(), self.max);
        watched("rays timed", sample.numbers(self.count()).len(), |progress| {
            time_rays(&self.batch(), sample, system, &mut Owners { recorder, sample }, progress)
                .map(|(timing, _)| timing)
        })
    }

    fn sweep(&self, system: &System) -> Result<Sweep, CliError> {
        let sample = Sample::spread(self.count(), SWEPT);
        watched("rays swept", swept(sample, self.count()), |progress| {
            sweep_rays(&self.batch(), sample, &IN_FLIGHT, &LATENCIES, system, progress)
        })
    }

    fn rows(&self, _: &Timing, _: f64) -> Vec<(String, String)> {
        Vec::new()
    }
}

impl Rays<'_> {
    fn batch(&self) -> RayBatch<'_> {
        RayBatch { scene: self.scene, rays: self.rays, tracing: self.tracing }
    }
}

/// The number of agents at all points of a sweep.
fn swept(sample: Sample, all: usize) -> usize {
    sample.numbers(all).len() * IN_FLIGHT.len() * LATENCIES.len()
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
