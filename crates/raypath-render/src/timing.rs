//! How long the datapath takes for a picture or for rays, cycle by cycle.
//!
//! An agent is a pixel with all its rays, one after another, or one ray of a list. Agents begin in the order of their
//! numbers, pixels row by row. What the external circuit does (stack, division, shading) takes no cycles, but reading
//! nodes and leaves does.

mod errand;

use crate::camera::Camera;
use crate::picture::Picture;
use crate::render::{Painter, RenderError, Shading};
use crate::scene::Scene;
use crate::trace::{Hit, Tracing};
use errand::{Desk, Single};
use raypath_model::{CycleModel, Functional};
use raypath_ops::{Binary32, Ray, Rules};
use raypath_timing::{Hardware, Observer, Sample, SimulationError, Sweep, Timing, Watch, simulate, sweep};
use thiserror::Error;

/// A picture to be made, by the arguments of [`render`](crate::render()).
#[derive(Debug, Clone, Copy)]
pub struct Still<'s> {
    /// What is seen.
    pub scene: &'s Scene,
    /// From where.
    pub camera: Camera,
    /// Pixels in a row, and rows.
    pub size: (u32, u32),
    /// How.
    pub shading: Shading,
}

/// Rays whose closest hits are sought.
#[derive(Debug, Clone, Copy)]
pub struct Bundle<'s> {
    /// What they may hit.
    pub scene: &'s Scene,
    /// The rays.
    pub rays: &'s [Ray<Binary32>],
    /// How they are traced.
    pub tracing: Tracing,
}

/// Why a picture is not timed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PictureError {
    /// There is no such picture.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The simulation came to no end.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
}

/// Makes a picture with every job on its way through the datapath. Its pixels, and the jobs and fetches of each, are those
/// of [`render`](crate::render()); pixels outside of the sample are black. `watch` hears now and then how many pixels are
/// done.
///
/// # Errors
/// Those of [`render`](crate::render()) and of [`simulate`].
pub fn time_picture(
    still: &Still,
    sample: Sample,
    hardware: &Hardware,
    observer: &mut impl Observer,
    watch: Watch,
) -> Result<(Timing, Picture), PictureError> {
    let painter = still.painter()?;
    let numbers = sample.numbers(painter.pixels());
    let desk = Desk::new(numbers.len());
    let agents =
        desk.clone().agents(painter.scene(), still.shading.tracing, numbers.clone(), |pixel| painter.brush(pixel));
    let model = model(hardware, still.shading.tracing.rules);
    let timing = simulate(agents, &hardware.machine, model, observer, watch)?;
    let mut canvas = vec![[0; 3]; painter.pixels()];
    for (number, colour) in numbers.zip(desk.found().map_err(RenderError::Camera)?) {
        canvas[number] = colour;
    }
    Ok((timing, Picture::of(still.size.0, still.size.1, canvas)))
}

/// Times a picture with each number of pixels in flight and each memory latency, in place of those of `hardware`. `watch`
/// hears how many pixels are done at all points together.
///
/// # Errors
/// Those of [`render`](crate::render()) and of [`sweep`].
pub fn sweep_picture(
    still: &Still,
    sample: Sample,
    in_flight: &[usize],
    latencies: &[u64],
    hardware: &Hardware,
    watch: Watch,
) -> Result<Sweep, PictureError> {
    let painter = still.painter()?;
    let tracing = still.shading.tracing;
    let agents = || {
        let numbers = sample.numbers(painter.pixels());
        Desk::new(numbers.len()).agents(painter.scene(), tracing, numbers, |pixel| painter.brush(pixel))
    };
    Ok(sweep(in_flight, latencies, &hardware.machine, &model(hardware, tracing.rules), agents, watch)?)
}

/// Traces the closest hits of rays with every job on its way through the datapath. Answers them in the order of the rays
/// of the sample; they, and the jobs and fetches, are those of [`trace_closest`](crate::trace_closest). `watch` hears now
/// and then how many rays are done.
///
/// # Errors
/// Those of [`simulate`].
pub fn time_rays(
    bundle: &Bundle,
    sample: Sample,
    hardware: &Hardware,
    observer: &mut impl Observer,
    watch: Watch,
) -> Result<(Timing, Vec<Option<Hit>>), SimulationError> {
    let Bundle { scene, rays, tracing } = *bundle;
    let numbers = sample.numbers(rays.len());
    let desk = Desk::new(numbers.len());
    let agents = desk.clone().agents(scene, tracing, numbers, |number| Single::new(rays[number]));
    let timing = simulate(agents, &hardware.machine, model(hardware, tracing.rules), observer, watch)?;
    // Rays that exist cannot fail to be made.
    Ok((timing, desk.found().unwrap_or_default()))
}

/// Times rays with each number of them in flight and each memory latency, in place of those of `hardware`. `watch` hears
/// how many rays are done at all points together.
///
/// # Errors
/// Those of [`sweep`].
pub fn sweep_rays(
    bundle: &Bundle,
    sample: Sample,
    in_flight: &[usize],
    latencies: &[u64],
    hardware: &Hardware,
    watch: Watch,
) -> Result<Sweep, SimulationError> {
    let Bundle { scene, rays, tracing } = *bundle;
    let agents = || {
        let numbers = sample.numbers(rays.len());
        Desk::new(numbers.len()).agents(scene, tracing, numbers, |number| Single::new(rays[number]))
    };
    sweep(in_flight, latencies, &hardware.machine, &model(hardware, tracing.rules), agents, watch)
}

impl Still<'_> {
    fn painter(&self) -> Result<Painter<'_>, RenderError> {
        Painter::new(self.scene, &self.camera, self.size, &self.shading)
    }
}

/// Rays' jobs are the same with any number of lanes.
fn model(hardware: &Hardware, rules: Rules) -> CycleModel<Functional> {
    hardware.model(Functional::new(rules))
}
