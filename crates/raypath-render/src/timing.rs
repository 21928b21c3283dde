//! Cycle-exact simulation of rendering and ray tracing.
//!
//! Each agent is a pixel with the sequence of all its rays, or one ray of a list. Agents start in the order of their
//! numbers, pixels row by row. The work of the external circuit (stack, division, shading) takes no cycles; reads of
//! nodes and leaves take the memory latency.

mod sequence;
mod unit;

use crate::render::PictureSampler;
use crate::{Camera, Hit, Picture, RenderError, Scene, Shading, Tracing, UnitErrors};
use image::Rgb;
use raypath_model::{CycleModel, Functional};
use raypath_ops::{Binary32, Job, Ray, Rules};
use raypath_timing::{
    Observer, Progress, Sample, SimulationError, Sweep, System, Timing, accepted_jobs, simulate, sweep,
};
use raypath_traversal::blocks::NodeKind;
use sequence::{ResultStore, SingleRay};
use thiserror::Error;
pub use unit::{UnitSystem, time_picture_through_unit, time_rays_through_unit};

/// A picture to simulate: the arguments of [`render`](crate::render()).
#[derive(Debug, Clone, Copy)]
pub struct PictureSpec<'s> {
    /// The scene.
    pub scene: &'s Scene,
    /// The camera.
    pub camera: Camera,
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// The shading.
    pub shading: Shading,
}

/// A list of rays to simulate.
#[derive(Debug, Clone, Copy)]
pub struct RayBatch<'s> {
    /// The scene.
    pub scene: &'s Scene,
    /// The rays, of which the closest hits are computed.
    pub rays: &'s [Ray<Binary32>],
    /// The options of tracing.
    pub tracing: Tracing,
}

/// The reason why the simulation of a picture failed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PictureError {
    /// The picture is invalid.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The simulation did not complete.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The scene has no blocks for the traversal unit.
    #[error("the scene is not in memory, expected one through the unit")]
    NotInMemory,
    /// The unit reads other nodes than the scene has.
    #[error("the scene has {scene} nodes, expected {unit}, which the unit reads")]
    Nodes {
        /// Those of the scene.
        scene: NodeKind,
        /// Those of the unit.
        unit: NodeKind,
    },
    /// The unit ended rays with an error.
    #[error(transparent)]
    Unit(#[from] UnitErrors),
    /// The progress callback stopped the simulation of the unit.
    #[error("stopped")]
    Stopped,
}

/// Simulates the rendering of a picture. The pixels of the sample, and the jobs and fetches of each, equal those of
/// [`render`](crate::render()); other pixels are black. `progress` gets the number of completed pixels.
///
/// # Errors
/// The errors of [`render`](crate::render()) and of [`simulate`].
pub fn time_picture(
    spec: &PictureSpec,
    sample: Sample,
    system: &System,
    observer: &mut impl Observer,
    progress: Progress,
) -> Result<(Timing, Picture), PictureError> {
    let sampler = spec.sampler()?;
    let tracing = spec.shading.tracing;
    let numbers = sample.numbers(sampler.pixels());
    let store = ResultStore::new(numbers.len());
    let agents = store.clone().agents(spec.scene, tracing, numbers.clone(), |pixel| sampler.pixel(pixel));
    let timing = simulate(agents, &system.environment, pipeline(system, tracing.rules), observer, progress)?;
    Ok((timing, spec.drawn(numbers, store.results().map_err(RenderError::Camera)?)))
}

/// The jobs of a picture in the order in which the datapath accepts them. `progress` gets the number of completed
/// pixels.
///
/// # Errors
/// The errors of [`render`](crate::render()) and of [`simulate`].
pub fn picture_jobs(
    spec: &PictureSpec,
    sample: Sample,
    system: &System,
    progress: Progress,
) -> Result<Vec<Job>, PictureError> {
    let sampler = spec.sampler()?;
    let tracing = spec.shading.tracing;
    let numbers = sample.numbers(sampler.pixels());
    let store = ResultStore::new(numbers.len());
    let agents = store.clone().agents(spec.scene, tracing, numbers, |pixel| sampler.pixel(pixel));
    let jobs = accepted_jobs(agents, system, Functional::new(tracing.rules), progress)?;
    store.results().map_err(RenderError::Camera)?;
    Ok(jobs)
}

/// Simulates the rendering of a picture with each number of pixels in flight and each memory latency, in place of those
/// of `system`. `progress` gets the number of completed pixels of all points together.
///
/// # Errors
/// The errors of [`render`](crate::render()) and of [`sweep`].
pub fn sweep_picture(
    spec: &PictureSpec,
    sample: Sample,
    in_flight: &[usize],
    latencies: &[u64],
    system: &System,
    progress: Progress,
) -> Result<Sweep, PictureError> {
    let sampler = spec.sampler()?;
    let tracing = spec.shading.tracing;
    let agents = || {
        let numbers = sample.numbers(sampler.pixels());
        ResultStore::new(numbers.len()).agents(spec.scene, tracing, numbers, |pixel| sampler.pixel(pixel))
    };
    Ok(sweep(in_flight, latencies, &system.environment, &pipeline(system, tracing.rules), agents, progress)?)
}

/// Simulates the tracing of rays and returns the closest hits of the rays of the sample, in order. The hits, jobs and
/// fetches equal those of [`trace_closest`](crate::trace_closest). `progress` gets the number of completed rays.
///
/// # Errors
/// The errors of [`simulate`].
pub fn time_rays(
    batch: &RayBatch,
    sample: Sample,
    system: &System,
    observer: &mut impl Observer,
    progress: Progress,
) -> Result<(Timing, Vec<Option<Hit>>), SimulationError> {
    let RayBatch { scene, rays, tracing } = *batch;
    let numbers = sample.numbers(rays.len());
    let store = ResultStore::new(numbers.len());
    let agents = store.clone().agents(scene, tracing, numbers, |number| SingleRay::new(rays[number]));
    let timing = simulate(agents, &system.environment, pipeline(system, tracing.rules), observer, progress)?;
    // A single ray exists already, so its sequence has no error.
    Ok((timing, store.results().unwrap_or_default()))
}

/// Simulates the tracing of rays with each number of rays in flight and each memory latency, in place of those of
/// `system`. `progress` gets the number of completed rays of all points together.
///
/// # Errors
/// The errors of [`sweep`].
pub fn sweep_rays(
    batch: &RayBatch,
    sample: Sample,
    in_flight: &[usize],
    latencies: &[u64],
    system: &System,
    progress: Progress,
) -> Result<Sweep, SimulationError> {
    let RayBatch { scene, rays, tracing } = *batch;
    let agents = || {
        let numbers = sample.numbers(rays.len());
        ResultStore::new(numbers.len()).agents(scene, tracing, numbers, |number| SingleRay::new(rays[number]))
    };
    sweep(in_flight, latencies, &system.environment, &pipeline(system, tracing.rules), agents, progress)
}

impl PictureSpec<'_> {
    fn sampler(&self) -> Result<PictureSampler<'_>, RenderError> {
        PictureSampler::new(self.scene, &self.camera, self.size, &self.shading)
    }

    /// The picture in which the pixels of these numbers have these colours.
    fn drawn(&self, numbers: impl Iterator<Item = usize>, colours: Vec<[u8; 3]>) -> Picture {
        let (width, height) = self.size;
        let mut picture = Picture::new(width, height);
        for (number, colour) in numbers.zip(colours) {
            picture.put_pixel(number as u32 % width, number as u32 / width, Rgb(colour));
        }
        picture
    }
}

/// The pipeline with the default number of lanes, which box and triangle jobs do not depend on.
fn pipeline(system: &System, rules: Rules) -> CycleModel<Functional> {
    system.pipeline(Functional::new(rules).conservative(true))
}
