use super::traversal::Need;
use super::{Counts, Goal, Hit, Tracing, Traversal};
use crate::progress::{Progress, Stopped};
use crate::scene::Scene;
use rayon::prelude::*;
use raypath_model::SimdKernels;
use raypath_ops::{Binary32, KernelOperation, Ray, RayBox, RayBoxInput, RayTriangle, RayTriangleInput, Rules};

/// Rays that are traced between two looks at the watch.
const BATCH: usize = 4096;

/// The closest hit of each ray, in their order, and what all of them cost. Uses all of rayon's threads; the result does
/// not depend on how many there are. `watch` hears now and then how many rays are done in all.
///
/// # Errors
/// [`Stopped`] where `watch` answered false.
pub fn trace_closest(
    scene: &Scene,
    rays: &[Ray<Binary32>],
    tracing: Tracing,
    watch: &(dyn Fn(u64) -> bool + Sync),
) -> Result<(Vec<Option<Hit>>, Counts), Stopped> {
    trace(scene, rays, tracing, Goal::Closest, watch, |hit| hit)
}

/// Whether each ray hits anything, in their order, and what all of them cost; otherwise like [`trace_closest`].
///
/// # Errors
/// [`Stopped`] where `watch` answered false.
pub fn trace_any(
    scene: &Scene,
    rays: &[Ray<Binary32>],
    tracing: Tracing,
    watch: &(dyn Fn(u64) -> bool + Sync),
) -> Result<(Vec<bool>, Counts), Stopped> {
    trace(scene, rays, tracing, Goal::Any, watch, |hit| hit.is_some())
}

fn trace<T: Copy + Default + Send>(
    scene: &Scene,
    rays: &[Ray<Binary32>],
    tracing: Tracing,
    goal: Goal,
    watch: &(dyn Fn(u64) -> bool + Sync),
    of: impl Fn(Option<Hit>) -> T + Sync,
) -> Result<(Vec<T>, Counts), Stopped> {
    let mut results = vec![T::default(); rays.len()];
    let progress = Progress::new(watch);
    let counts = results
        .par_chunks_mut(BATCH)
        .zip(rays.par_chunks(BATCH))
        .map(|(results, rays)| {
            let mut counts = Counts::default();
            if progress.is_stopped() {
                return counts;
            }
            let mut tracer = Tracer::new(scene, tracing);
            for (result, ray) in results.iter_mut().zip(rays) {
                *result = of(tracer.trace(ray, goal));
                counts += tracer.counts();
            }
            progress.add(rays.len() as u64);
            counts
        })
        .sum();
    progress.finish()?;
    Ok((results, counts))
}

/// Traces ray after ray, each job answered at once. Allocates when it is made, and never again.
#[derive(Debug, Clone)]
pub struct Tracer<'s> {
    traversal: Traversal<'s>,
    rules: Rules,
}

impl<'s> Tracer<'s> {
    /// A tracer through a scene.
    pub fn new(scene: &'s Scene, tracing: Tracing) -> Self {
        Self { traversal: Traversal::new(scene.bvh(), tracing), rules: tracing.rules }
    }

    /// What a ray hits: the closest, or for [`Goal::Any`] whichever was found first.
    #[inline]
    pub fn trace(&mut self, ray: &Ray<Binary32>, goal: Goal) -> Option<Hit> {
        self.traversal.start(*ray, goal);
        // Constant rules make two functions, neither of which asks for them again.
        match self.rules {
            Rules::Paper => run(&mut self.traversal, Rules::Paper),
            Rules::Chisel => run(&mut self.traversal, Rules::Chisel),
        }
        self.traversal.hit()
    }

    /// What the last ray cost.
    #[inline]
    pub fn counts(&self) -> Counts {
        self.traversal.counts()
    }
}

#[inline]
fn run(traversal: &mut Traversal, rules: Rules) {
    loop {
        match traversal.need() {
            Need::Fetch => {}
            Need::Boxes(boxes) => {
                let input = RayBoxInput { ray: *traversal.ray(), aabb: *boxes };
                let (answer, ()) = RayBox { rules }.run_with(Binary32, SimdKernels, input, ());
                traversal.boxes(&answer);
            }
            Need::Triangle(triangle) => {
                let input = RayTriangleInput { ray: *traversal.ray(), triangle };
                let (answer, ()) = RayTriangle { rules }.run_with(Binary32, SimdKernels, input, ());
                traversal.triangle(&answer);
            }
            // Every job has been answered, so there is nothing to wait for.
            Need::Wait | Need::Done => return,
        }
    }
}
