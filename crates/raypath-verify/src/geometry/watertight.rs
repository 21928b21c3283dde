//! No ray passes through an edge or vertex that is shared by faces which all face it.

use super::aimed_rays::{AimedRay, PlacedMesh, Target, bodies};
use super::campaign::{self, Failures, add_controls, tally_of_fields};
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
    let (tally, is_stopped) =
        campaign::run(request, 1, cases, |rng, tally: &mut Rays| tally.run(rng, &bodies, &is_hit))?;
    Ok(tally.verdict(&bodies, is_stopped))
}

/// An implementation: whether a ray hits a triangle.
trait Intersect: Fn(&Ray<Binary32>, [[f32; 3]; 3]) -> bool {}
impl<F: Fn(&Ray<Binary32>, [[f32; 3]; 3]) -> bool> Intersect for F {}

/// The counts of a campaign.
#[derive(Default)]
struct Rays {
    drawn: u64,
    /// Rays checked, by target: edge, vertex, whole mesh.
    checked: [u64; 3],
    /// Rays that hit more than one face.
    hit_several: u64,
    /// Rays through a patch with a thin face, which the claim excludes.
    thin: u64,
    /// Those of them that hit no face.
    thin_leaks: u64,
    /// Rays that ran on the leaking implementations, and those that leaked through each.
    tried: u64,
    leaks: [u64; LEAKY.len()],
    leaked: Failures,
}

impl Rays {
    /// Draws rays until one must hit by exact arithmetic, and checks it.
    fn run(&mut self, rng: &mut ChaCha8Rng, bodies: &[PlacedMesh], is_hit: &dyn Intersect) {
        for _ in 0..DRAWS {
            let body = &bodies[rng.random_range(0..bodies.len())];
            self.drawn += 1;
            let Some(shot) = body.random_ray(rng) else { continue };
            let hits = |intersect: &dyn Intersect| {
                let hits = |face: &&usize| intersect(&shot.ray, body.mesh.corners(**face));
                shot.patch.faces.iter().filter(hits).count()
            };
            match visibility(&shot.ray, &body.mesh, &shot.patch) {
                Visibility::BackFacing | Visibility::Behind | Visibility::NearRim => {}
                Visibility::Thin => {
                    self.thin += 1;
                    self.thin_leaks += u64::from(hits(is_hit) == 0);
                }
                Visibility::Clear => {
                    self.checked[shot.target as usize] += 1;
                    self.check(&shot, body, hits(is_hit));
                    self.tried += 1;
                    for (leaks, (_, intersect)) in self.leaks.iter_mut().zip(LEAKY) {
                        *leaks += u64::from(hits(&intersect) == 0);
                    }
                    return;
                }
            }
        }
    }

    fn check(&mut self, shot: &AimedRay<'_>, body: &PlacedMesh, hits: usize) {
        self.hit_several += u64::from(hits > 1);
        if hits == 0 {
            self.leaked.add(|| {
                let (origin, dir): ([f32; 3], [f32; 3]) = (shot.ray.origin.into(), shot.ray.dir.into());
                let faces: Vec<_> = shot.patch.faces.iter().map(|&face| body.mesh.corners(face)).collect();
                format!("{}: ray from {origin:?} along {dir:?} passes through {faces:?} without a hit", body.mesh.name)
            });
        }
    }

    fn verdict(self, bodies: &[PlacedMesh], is_stopped: bool) -> Verdict {
        let [edges, vertices, whole] =
            [Target::Edge, Target::Vertex, Target::Whole].map(|target| self.checked[target as usize]);
        let checked = edges + vertices + whole;
        let remarks = vec![
            format!("{} random rays; {} of the checked ones hit two faces or more", self.drawn, self.hit_several),
            format!(
                "through patches with a thin face, which the claim excludes: {} rays, {} of them without a hit",
                self.thin, self.thin_leaks
            ),
        ];
        let covered = format!(
            "{checked} rays at closed meshes ({} of them): {edges} at edges, {vertices} at vertices, {whole} at \
             whole meshes",
            bodies.len()
        );
        let mut verdict = Verdict { covered, remarks, failures: self.leaked.lines(), is_stopped };
        let names = LEAKY.map(|(name, _)| name);
        let label = "the same rays leak through other implementations";
        add_controls(&mut verdict, label, names, self.leaks, self.tried >= ENOUGH);
        verdict
    }
}

tally_of_fields!(Rays { drawn, checked, hit_several, thin, thin_leaks, tried, leaks, leaked });

#[cfg(test)]
mod tests {
    use super::{Intersect, Rays, bodies};
    use crate::geometry::implementations::{LEAKY, datapath};
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;
    use raypath_ops::{Binary32, Ray, Rules};

    fn run_rays(is_hit: &dyn Intersect) -> Rays {
        let (bodies, mut rng, mut rays) = (bodies(2), ChaCha8Rng::seed_from_u64(3), Rays::default());
        (0..20_000).for_each(|_| rays.run(&mut rng, &bodies, is_hit));
        rays
    }

    /// The campaign passes the datapath under both rule sets, and finds each leaking implementation.
    #[test]
    fn leaks_are_found() {
        for rules in [Rules::Paper, Rules::Chisel] {
            let rays = run_rays(&|ray: &Ray<Binary32>, corners| datapath(rules, ray, corners).triangle_hit.into());
            assert_eq!((rays.leaked.count(), rays.checked.iter().sum::<u64>()), (0, 20_000), "{rules}");
            assert!(rays.checked.iter().all(|&rays| rays > 50) && rays.hit_several > 1000, "{:?}", rays.checked);
        }
        for (name, intersect) in LEAKY {
            let leaked = run_rays(&intersect).leaked.count();
            assert!(leaked > 100, "{name}: {leaked}");
        }
    }
}
