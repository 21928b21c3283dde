//! Comparison of this tracer with the library obvhs.

use crate::{Counts, Goal, Scene, Stopped, Tracer, Tracing};
use obvhs::ray::{Ray as PeerRay, RayHit};
use raypath_ops::{Binary32, Ray};
use raypath_scene::bvh::{binary_tree, peer_triangles};
use raypath_timing::Progress;
use std::time::{Duration, Instant};

/// The times and hits of two tracers for the same rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// The number of rays.
    pub rays: usize,
    /// The time of this tracer for all rays on one core, the best of all runs.
    pub ours: Duration,
    /// The time of obvhs with its binary tree and its two-sided Möller–Trumbore test.
    pub obvhs: Duration,
    /// The jobs and fetches of this tracer.
    pub counts: Counts,
    /// The rays with a hit by this tracer.
    pub our_hits: usize,
    /// The rays with a hit by obvhs.
    pub obvhs_hits: usize,
    /// The rays with a hit by only one of the two.
    pub differences: usize,
}

impl Comparison {
    /// Nanoseconds per ray of this tracer and of obvhs.
    pub fn nanoseconds(&self) -> [f64; 2] {
        [self.ours, self.obvhs].map(|time| 1e9 * time.as_secs_f64() / self.rays.max(1) as f64)
    }
}

/// Traces the closest hits of `rays` on one core with this tracer and with obvhs, `runs` times each in turns (at least
/// once), and keeps the best times. obvhs uses the binary tree from which the tree of the scene was made. `progress`
/// gets the number of completed runs.
///
/// # Errors
/// [`Stopped`] if `progress` returned false.
pub fn compare(
    scene: &Scene,
    rays: &[Ray<Binary32>],
    tracing: Tracing,
    runs: u32,
    progress: Progress,
) -> Result<Comparison, Stopped> {
    let all: Vec<u32> = (0..scene.mesh().triangles().len() as u32).collect();
    let tree = binary_tree(scene.mesh(), &all, 4);
    let triangles = peer_triangles(scene.mesh(), &all);
    // In the order of leaves, which is fastest for obvhs.
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
            tree.ray_traverse(*ray, &mut closest, |ray, slot| triangles[slot].intersect(ray));
            *peer_hit = closest.primitive_id != RayHit::none().primitive_id;
        }
        obvhs = obvhs.min(start.elapsed());
        if !progress(run.into()) {
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
