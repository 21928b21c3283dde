//! Simulation of rendering and ray tracing through the traversal unit.

use super::sequence::{RaySequence, SingleRay};
use super::{PictureError, PictureSpec, RayBatch};
use crate::render::RenderError;
use crate::{Blocks, Goal, Hit, Picture, UnitErrors};
use raypath_model::Shape;
use raypath_ops::RayError;
use raypath_timing::{Progress, Sample};
use raypath_traversal::system::{RayUser, SystemParameters, SystemTiming, simulate};
use raypath_traversal::{RayRequest, Reply, UnitParameters};
use std::collections::VecDeque;

/// A simulated system: traversal units and their memory.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitSystem {
    /// The pipeline of the datapath.
    pub shape: Shape,
    /// The unit around it.
    pub unit: UnitParameters,
    /// The number of units, the cache and the memory with the scene.
    pub around: SystemParameters,
    /// Pixels or rays of a list that are in work at a time, at least 1. The rays of a pixel follow one another. With
    /// more than the unit has contexts, a ray waits whenever a context is free.
    pub in_flight: usize,
}

/// Simulates the rendering of a picture through the unit. The pixels of the sample equal those of
/// [`render`](crate::render()) for a scene [`through_unit`](crate::Scene::through_unit); other pixels are black.
/// `progress` gets the number of completed pixels.
///
/// # Errors
/// The errors of [`render`](crate::render()); a scene that is not in memory; rays that the unit ended with an error; the
/// progress stopped it.
pub fn time_picture_through_unit(
    spec: &PictureSpec,
    sample: Sample,
    system: &UnitSystem,
    progress: Progress,
) -> Result<(SystemTiming, Picture), PictureError> {
    let sampler = spec.sampler()?;
    let numbers = sample.numbers(sampler.pixels());
    let sequences = numbers.clone().map(|pixel| sampler.pixel(pixel));
    let blocks = spec.scene.blocks().ok_or(PictureError::NotInMemory)?;
    let two_sided = spec.shading.tracing.two_sided;
    let (timing, colours) = run(sequences, blocks, two_sided, system, progress)?;
    Ok((timing, spec.drawn(numbers, colours)))
}

/// Simulates the tracing of rays through the unit, and returns the closest hits of the rays of the sample, in order.
/// `progress` gets the number of completed rays.
///
/// # Errors
/// A scene that is not in memory, or with other nodes; rays that the unit ended with an error; the progress stopped it.
pub fn time_rays_through_unit(
    batch: &RayBatch,
    sample: Sample,
    system: &UnitSystem,
    progress: Progress,
) -> Result<(SystemTiming, Vec<Option<Hit>>), PictureError> {
    let RayBatch { scene, rays, tracing } = *batch;
    let sequences = sample.numbers(rays.len()).map(|number| SingleRay::new(rays[number]));
    let blocks = scene.blocks().ok_or(PictureError::NotInMemory)?;
    run(sequences, blocks, tracing.two_sided, system, progress)
}

/// Simulates sequences of rays. Returns their results in order.
fn run<S: RaySequence>(
    sequences: impl ExactSizeIterator<Item = S>,
    blocks: &Blocks,
    two_sided: bool,
    system: &UnitSystem,
    progress: Progress,
) -> Result<(SystemTiming, Vec<S::Result>), PictureError> {
    let (scene, nodes) = (blocks.nodes(), system.unit.step.node);
    if scene != nodes {
        return Err(PictureError::Nodes { scene, unit: nodes });
    }
    let mut parameters = system.unit;
    parameters.step.features.instances |= blocks.features().instances;
    let mut user = Sequences {
        results: vec![S::Result::default(); sequences.len()],
        waiting: sequences.enumerate(),
        places: Vec::new(),
        free: (0..system.in_flight.max(1)).rev().collect(),
        ready: VecDeque::new(),
        blocks,
        two_sided,
        done: 0,
        progress,
        error: None,
        errors: UnitErrors::default(),
    };
    user.places.resize_with(user.free.len(), || None);
    let timing = simulate(&system.shape, parameters, blocks.bytes(), &system.around, &mut user);
    match user.error {
        Some(error) => Err(RenderError::Camera(error).into()),
        None if timing.is_stopped => Err(PictureError::Stopped),
        None => {
            user.errors.check()?;
            Ok((timing, user.results))
        }
    }
}

/// Sequences that send rays: some in work, the others waiting.
struct Sequences<'p, S: RaySequence, I> {
    waiting: I,
    /// The sequences in work with their numbers, by the number of their rays.
    places: Vec<Option<(usize, S)>>,
    free: Vec<usize>,
    ready: VecDeque<(u64, RayRequest)>,
    results: Vec<S::Result>,
    blocks: &'p Blocks,
    two_sided: bool,
    done: u64,
    progress: Progress<'p>,
    error: Option<RayError>,
    errors: UnitErrors,
}

/// Completed sequences between two calls of the progress.
const STRIDE: u64 = 1024;

impl<S: RaySequence, I: Iterator<Item = (usize, S)>> Sequences<'_, S, I> {
    /// Sends the next ray of a sequence, or ends it. Returns whether the simulation goes on.
    fn advance(&mut self, place: usize, mut sequence: (usize, S), hit: Option<Hit>) -> bool {
        match sequence.1.next_ray(hit) {
            Ok(Some((ray, goal))) => {
                self.ready.push_back((place as u64, self.blocks.request(&ray, goal == Goal::Any, self.two_sided)));
                self.places[place] = Some(sequence);
                true
            }
            end => {
                self.error = self.error.or(end.err());
                self.results[sequence.0] = sequence.1.result();
                self.free.push(place);
                self.done += 1;
                self.error.is_none() && (!self.done.is_multiple_of(STRIDE) || (self.progress)(self.done))
            }
        }
    }
}

impl<S: RaySequence, I: Iterator<Item = (usize, S)>> RayUser for Sequences<'_, S, I> {
    fn next_ray(&mut self) -> Option<(u64, RayRequest)> {
        while self.ready.is_empty() && self.error.is_none() {
            let place = *self.free.last()?;
            let sequence = self.waiting.next()?;
            self.free.pop();
            self.advance(place, sequence, None);
        }
        self.ready.pop_front()
    }

    fn receive(&mut self, number: u64, reply: &Reply) -> bool {
        self.errors = self.errors.and(UnitErrors::of(reply.status));
        let place = number as usize;
        let Some(sequence) = self.places.get_mut(place).and_then(Option::take) else { return false };
        self.advance(place, sequence, reply.hit.map(Hit::from))
    }
}
