use super::{Counts, Goal, Hit, Stopped, TraceError, Tracing, Traversal, UnitErrors};
use rayon::prelude::*;
use raypath_ops::{Binary32, Ray};
use raypath_scene::Scene;
use raypath_scene::blocks::Blocks;
use raypath_timing::{Progress, ProgressCounter};
use raypath_traversal::{StepParameters, Unit};

/// The number of rays in a unit of parallel work.
const BATCH: usize = 512;

/// Traces rays on all threads of rayon. Returns the closest hit of each ray, in order, and the total cost; the result
/// does not depend on the number of threads. `progress` gets the number of completed rays.
///
/// # Errors
/// `progress` returned false, or the traversal unit ended rays with an error.
pub fn trace_closest(
    scene: &Scene,
    rays: &[Ray<Binary32>],
    tracing: Tracing,
    progress: Progress,
) -> Result<(Vec<Option<Hit>>, Counts), TraceError> {
    trace(scene, rays, tracing, Goal::Closest, progress, |hit| hit)
}

/// Traces rays as [`trace_closest`] does, but returns only whether each ray hits anything.
///
/// # Errors
/// `progress` returned false, or the traversal unit ended rays with an error.
pub fn trace_any(
    scene: &Scene,
    rays: &[Ray<Binary32>],
    tracing: Tracing,
    progress: Progress,
) -> Result<(Vec<bool>, Counts), TraceError> {
    trace(scene, rays, tracing, Goal::Any, progress, |hit| hit.is_some())
}

fn trace<T: Copy + Default + Send>(
    scene: &Scene,
    rays: &[Ray<Binary32>],
    tracing: Tracing,
    goal: Goal,
    progress: Progress,
    result: impl Fn(Option<Hit>) -> T + Sync,
) -> Result<(Vec<T>, Counts), TraceError> {
    let mut results = vec![T::default(); rays.len()];
    let progress = ProgressCounter::new(progress);
    let counts: Counts = results
        .par_chunks_mut(BATCH)
        .zip(rays.par_chunks(BATCH))
        .map(|(results, rays)| {
            let mut counts = Counts::default();
            if progress.is_stopped() {
                return counts;
            }
            let mut tracer = Tracer::new(scene, tracing);
            for (slot, ray) in results.iter_mut().zip(rays) {
                *slot = result(tracer.trace(ray, goal));
                counts += tracer.counts();
            }
            progress.add(rays.len() as u64);
            counts
        })
        .sum();
    if progress.is_stopped() {
        return Err(Stopped.into());
    }
    counts.errors.check()?;
    Ok((results, counts))
}

/// Traces one ray after another in software: through the functional model of the traversal unit if the scene has its
/// [`Blocks`], else by the jobs of a [`Traversal`]. It allocates on creation only.
#[derive(Debug, Clone)]
pub struct Tracer<'s>(Way<'s>);

#[derive(Debug, Clone)]
enum Way<'s> {
    Traversal(Traversal<'s>),
    Unit { unit: Box<Unit>, blocks: &'s Blocks, two_sided: bool, counts: Counts },
}

impl<'s> Tracer<'s> {
    /// A tracer for a scene.
    pub fn new(scene: &'s Scene, tracing: Tracing) -> Self {
        let Tracing { rules, two_sided } = tracing;
        Self(match scene.blocks() {
            Some(blocks) => {
                let (node, features) = (blocks.nodes(), blocks.features());
                let step = StepParameters { node, features, ..StepParameters::default() };
                let unit = Box::new(Unit::new(rules, step));
                Way::Unit { unit, blocks, two_sided, counts: Counts::default() }
            }
            None => Way::Traversal(Traversal::new(scene.bvh(), tracing)),
        })
    }

    /// Traces a ray and returns its hit: the closest, or with [`Goal::Any`] the first found. There is none if the
    /// traversal unit ends the ray with an error, which [`counts`](Self::counts) has.
    #[inline]
    pub fn trace(&mut self, ray: &Ray<Binary32>, goal: Goal) -> Option<Hit> {
        match &mut self.0 {
            Way::Traversal(traversal) => {
                traversal.start(*ray, goal);
                traversal.run();
                traversal.hit()
            }
            Way::Unit { unit, blocks, two_sided, counts } => {
                let request = blocks.request(ray, goal == Goal::Any, *two_sided);
                let reply = unit.trace(blocks.bytes(), &request);
                let errors = UnitErrors::of(reply.status);
                let (nodes, triangles) = (u64::from(reply.nodes), u64::from(reply.triangles));
                let quadbox = nodes * blocks.nodes().children() as u64 / 4;
                *counts = Counts { quadbox, nodes, triangle: triangles, errors, ..Counts::default() };
                reply.hit.map(Hit::from)
            }
        }
    }

    /// The cost of the last ray. The unit does not count the leaves that it reads.
    #[inline]
    pub fn counts(&self) -> Counts {
        match &self.0 {
            Way::Traversal(traversal) => traversal.counts(),
            Way::Unit { counts, .. } => *counts,
        }
    }
}

impl From<raypath_traversal::Hit> for Hit {
    /// The numerator and the denominator of a back face are negative in the unit, which tests both faces in one job.
    fn from(hit: raypath_traversal::Hit) -> Self {
        let raypath_traversal::Hit { primitive, t, t_num, t_denom, back_face, instance, .. } = hit;
        let (t_num, t_denom) = if back_face { (-t_num, -t_denom) } else { (t_num, t_denom) };
        let instance = instance.map(|instance| instance.index);
        Self { triangle: primitive, from_behind: back_face, t_num, t_denom, t, instance }
    }
}
