//! No ray passes through an edge or vertex that is shared by faces which all face it.

use super::aimed_rays::{AimedRay, PlacedMesh, Target, bodies};
use super::campaign::{self, Tally};
use super::implementations::{LEAKY, datapath};
use super::visibility::{Visibility, visibility};
use crate::error::Error;
use crate::request::Request;
use crate::verdict::Verdict;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_ops::{Binary32, Ray};

/// The number of cases after which each leaking implementation must have been found.
const ENOUGH: u64 = 100_000;
/// The number of random rays to try until one satisfies the claim's preconditions.
const DRAWS: u32 = 200;

/// Runs rays at closed meshes. In each case the ray passes, by exact arithmetic, through a patch of faces that all face
/// it; the datapath must hit one of them.
pub fn verify(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let rules = request.config.semantics.rules;
    let cases = request.jobs.unwrap_or(request.level.pick(1_000_000, 20_000_000, 1_000_000_000));
    let bodies = bodies(request.seed);
    let is_hit = |ray: &Ray<Binary32>, corners| datapath(rules, ray, corners).triangle_hit.into();
    let (blocks, is_stopped) = campaign::run(request, 1, cases, |rng, tally| run(tally, rng, &bodies, &is_hit))?;
    Ok(verdict(Tally::joined(blocks), &bodies, is_stopped))
}

/// An implementation: whether a ray hits a triangle.
trait Intersect: Fn(&Ray<Binary32>, [[f32; 3]; 3]) -> bool {}
impl<F: Fn(&Ray<Binary32>, [[f32; 3]; 3]) -> bool> Intersect for F {}

/// The counts of checked rays, by target.
const TARGETS: [(Target, &str); 3] = [(Target::Edge, "edges"), (Target::Vertex, "vertices"), (Target::Whole, "whole")];

/// Draws rays until one must hit by exact arithmetic, and checks it.
fn run(tally: &mut Tally, rng: &mut ChaCha8Rng, bodies: &[PlacedMesh], is_hit: &dyn Intersect) {
    for _ in 0..DRAWS {
        let body = &bodies[rng.random_range(0..bodies.len())];
        tally.add("drawn", true);
        let Some(shot) = body.random_ray(rng) else { continue };
        let hits = |intersect: &dyn Intersect| {
            let hits = |face: &&usize| intersect(&shot.ray, body.mesh.corners(**face));
            shot.patch.faces.iter().filter(hits).count()
        };
        match visibility(&shot.ray, &body.mesh, &shot.patch) {
            Visibility::BackFacing | Visibility::Behind | Visibility::NearRim => {}
            Visibility::Thin => {
                tally.add("thin", true);
                tally.add("thin without a hit", hits(is_hit) == 0);
            }
            Visibility::Clear => {
                TARGETS.iter().for_each(|(target, name)| tally.add(name, shot.target == *target));
                check(tally, &shot, body, hits(is_hit));
                LEAKY.iter().for_each(|(name, intersect)| tally.add(name, hits(intersect) == 0));
                return;
            }
        }
    }
}

fn check(tally: &mut Tally, shot: &AimedRay<'_>, body: &PlacedMesh, hits: usize) {
    tally.add("several hits", hits > 1);
    if hits == 0 {
        tally.fail(|| {
            let (origin, dir): ([f32; 3], [f32; 3]) = (shot.ray.origin.into(), shot.ray.dir.into());
            let faces: Vec<_> = shot.patch.faces.iter().map(|&face| body.mesh.corners(face)).collect();
            format!("{}: ray from {origin:?} along {dir:?} passes through {faces:?} without a hit", body.mesh.name)
        });
    }
}

fn verdict(tally: Tally, bodies: &[PlacedMesh], is_stopped: bool) -> Verdict {
    let [edges, vertices, whole] = TARGETS.map(|(_, name)| tally.count(name));
    let checked = edges + vertices + whole;
    let remarks = vec![
        format!(
            "{} random rays; {} of the checked ones hit two faces or more",
            tally.count("drawn"),
            tally.count("several hits")
        ),
        format!(
            "through patches with a thin face, which the claim excludes: {} rays, {} of them without a hit",
            tally.count("thin"),
            tally.count("thin without a hit")
        ),
    ];
    let covered = format!(
        "{checked} rays at closed meshes ({} of them): {edges} at edges, {vertices} at vertices, {whole} at whole meshes",
        bodies.len()
    );
    let label = "the same rays leak through other implementations";
    tally.verdict(is_stopped, covered, remarks, (label, LEAKY.map(|(name, _)| name), checked >= ENOUGH))
}

#[cfg(test)]
mod tests {
    use super::{Intersect, TARGETS, Tally, bodies, run};
    use crate::geometry::implementations::{LEAKY, datapath};
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;
    use raypath_ops::{Binary32, Ray, Rules};

    fn run_rays(is_hit: &dyn Intersect) -> Tally {
        let (bodies, mut rng, mut tally) = (bodies(2), ChaCha8Rng::seed_from_u64(3), Tally::default());
        (0..20_000).for_each(|_| run(&mut tally, &mut rng, &bodies, is_hit));
        tally
    }

    /// The campaign passes the datapath under both rule sets, and finds each leaking implementation.
    #[test]
    fn leaks_are_found() {
        for rules in [Rules::Paper, Rules::Chisel] {
            let rays = run_rays(&|ray: &Ray<Binary32>, corners| datapath(rules, ray, corners).triangle_hit.into());
            let checked = TARGETS.map(|(_, name)| rays.count(name));
            assert_eq!((rays.failures(), checked.iter().sum::<u64>()), (0, 20_000), "{rules}");
            assert!(checked.iter().all(|&rays| rays > 50) && rays.count("several hits") > 1000, "{rays:?}");
        }
        for (name, intersect) in LEAKY {
            let leaked = run_rays(&intersect).failures();
            assert!(leaked > 100, "{name}: {leaked}");
        }
    }
}
