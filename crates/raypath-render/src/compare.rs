//! The datapath's tracer beside another.

use crate::bvh::{binary_tree, peer_triangles};
use crate::progress::Stopped;
use crate::scene::Scene;
use crate::trace::{Counts, Goal, Tracer, Tracing};
use obvhs::ray::{Ray as PeerRay, RayHit};
use raypath_ops::{Binary32, Ray};
use std::time::{Duration, Instant};

/// How two tracers do with the same rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// How many rays.
    pub rays: usize,
    /// What the datapath's operations took for all of them, on one core; the best of some runs.
    pub ours: Duration,
    /// What obvhs took: its binary tree, and Möller and Trumbore's test of both sides.
    pub obvhs: Duration,
    /// Jobs and fetches of ours.
    pub counts: Counts,
    /// How many rays hit something by ours.
    pub our_hits: usize,
    /// And by obvhs.
    pub obvhs_hits: usize,
    /// Rays that hit something by one and nothing by the other.
    pub differences: usize,
}

impl Comparison {
    /// Nanoseconds a ray of ours and of obvhs.
    pub fn nanoseconds(&self) -> [f64; 2] {
        [self.ours, self.obvhs].map(|time| 1e9 * time.as_secs_f64() / self.rays.max(1) as f64)
    }
}

/// Traces the closest hits of `rays` on one core, by the datapath's operations and by obvhs over the binary tree that the
/// scene's was made of, `runs` times each in turns (at least once), and keeps the best times. `watch` hears how many runs
/// are done.
///
/// # Errors
/// [`Stopped`] where `watch` answered false.
pub fn compare(
    scene: &Scene,
    rays: &[Ray<Binary32>],
    tracing: Tracing,
    runs: u32,
    watch: &(dyn Fn(u64) -> bool + Sync),
) -> Result<Comparison, Stopped> {
    let tree = binary_tree(scene.mesh());
    let triangles = peer_triangles(scene.mesh());
    // In the order of leaves, as it likes them best.
    let triangles: Vec<_> = tree.primitive_indices.iter().map(|&index| triangles[index as usize]).collect();
    let peer_rays: Vec<PeerRay> = rays.iter().map(peer_ray).collect();
    let (mut ours, mut obvhs) = (Duration::MAX, Duration::MAX);
    let (mut hit, mut peer_hit, mut counts) = (vec![false; rays.len()], vec![false; rays.len()], Counts::default());
    let mut tracer = Tracer::new(scene, tracing);
    for run in 1..=runs.max(1) {
        counts = Counts::default();
        let start = Instant::now();
        for (ray, hit) in rays.iter().zip(&mut hit) {
            *hit = tracer.trace(ray, Goal::Closest).is_some();
            counts += tracer.counts();
        }
        ours = ours.min(start.elapsed());
        let start = Instant::now();
        for (ray, peer_hit) in peer_rays.iter().zip(&mut peer_hit) {
            let mut closest = RayHit::none();
            tree.ray_traverse(*ray, &mut closest, |ray, place| triangles[place].intersect(ray));
            // Its distance is the extent where nothing was hit.
            *peer_hit = closest.primitive_id != RayHit::none().primitive_id;
        }
        obvhs = obvhs.min(start.elapsed());
        if !watch(run.into()) {
            return Err(Stopped);
        }
    }
    let count = |hits: &[bool]| hits.iter().filter(|&&hit| hit).count();
    let differences = hit.iter().zip(&peer_hit).filter(|(a, b)| a != b).count();
    let (our_hits, obvhs_hits) = (count(&hit), count(&peer_hit));
    Ok(Comparison { rays: rays.len(), ours, obvhs, counts, our_hits, obvhs_hits, differences })
}

fn peer_ray(ray: &Ray<Binary32>) -> PeerRay {
    let (origin, direction): ([f32; 3], [f32; 3]) = (ray.origin.into(), ray.dir.into());
    PeerRay::new(origin.into(), direction.into(), 0.0, ray.extent.into())
}
