//! No ray slips through an edge or a vertex that is shared by faces which all look at it.

use super::aim::{Aim, Body, Shot, bodies};
use super::campaign::{self, Failures, Tally};
use super::intersect::{LEAKY, datapath};
use super::sight::{Sight, sight};
use crate::error::Error;
use crate::request::Request;
use crate::verdict::Verdict;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use raypath_ops::{Binary32, Ray};

/// Cases after which an intersection that leaks must have been seen to.
const ENOUGH: u64 = 100_000;
/// Rays drawn until one fulfils what is supposed.
const DRAWS: u32 = 200;

/// Shoots rays at closed meshes. Each case is a ray of which exact arithmetic says that it passes through a patch of
/// faces which all look at it; the datapath must hit one of them.
pub fn verify(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let rules = request.config.semantics.rules;
    let cases = request.jobs.unwrap_or(request.level.pick(1_000_000, 20_000_000, 1_000_000_000));
    let bodies = bodies(request.seed);
    let is_hit = |ray: &Ray<Binary32>, corners| datapath(rules, ray, corners).triangle_hit.into();
    let (tally, is_stopped) =
        campaign::run(request, 1, cases, |rng, tally: &mut Rays| tally.shoot(rng, &bodies, &is_hit))?;
    Ok(tally.verdict(&bodies, is_stopped))
}

/// Whether a ray hits a triangle.
trait Intersect: Fn(&Ray<Binary32>, [[f32; 3]; 3]) -> bool {}
impl<F: Fn(&Ray<Binary32>, [[f32; 3]; 3]) -> bool> Intersect for F {}

/// What became of the rays.
#[derive(Default)]
struct Rays {
    drawn: u64,
    /// By what they were aimed at: edge, vertex, the whole.
    judged: [u64; 3],
    /// Hits of more than one face: on an edge, as computed.
    hit_several: u64,
    /// Rays through a patch of which a face is seen too thin: nothing is claimed of them.
    thin: u64,
    /// Of them, those that hit nothing.
    thin_leaks: u64,
    /// Rays at which other ways to intersect were tried, and how many slipped through each.
    tried: u64,
    leaks: [u64; LEAKY.len()],
    leaked: Failures,
}

impl Rays {
    /// Draws rays until exact arithmetic says of one that it must hit, and judges it.
    fn shoot(&mut self, rng: &mut ChaCha8Rng, bodies: &[Body], is_hit: &dyn Intersect) {
        for _ in 0..DRAWS {
            let body = &bodies[rng.random_range(0..bodies.len())];
            self.drawn += 1;
            let Some(shot) = body.shoot(rng) else { continue };
            let hits = |intersect: &dyn Intersect| {
                let hits = |face: &&usize| intersect(&shot.ray, body.mesh.corners(**face));
                shot.patch.faces.iter().filter(hits).count()
            };
            match sight(&shot.ray, &body.mesh, &shot.patch) {
                Sight::LooksAway | Sight::Behind | Sight::NearRim => {}
                Sight::Thin => {
                    self.thin += 1;
                    self.thin_leaks += u64::from(hits(is_hit) == 0);
                }
                Sight::Clear => {
                    self.judged[shot.aim as usize] += 1;
                    self.judge(&shot, body, hits(is_hit));
                    self.tried += 1;
                    for (leaks, (_, intersect)) in self.leaks.iter_mut().zip(LEAKY) {
                        *leaks += u64::from(hits(&intersect) == 0);
                    }
                    return;
                }
            }
        }
    }

    fn judge(&mut self, shot: &Shot<'_>, body: &Body, hits: usize) {
        self.hit_several += u64::from(hits > 1);
        if hits == 0 {
            self.leaked.add(|| {
                let (origin, dir): ([f32; 3], [f32; 3]) = (shot.ray.origin.into(), shot.ray.dir.into());
                let faces: Vec<_> = shot.patch.faces.iter().map(|&face| body.mesh.corners(face)).collect();
                format!("{}: ray from {origin:?} along {dir:?} slips through {faces:?}", body.mesh.name)
            });
        }
    }

    fn verdict(self, bodies: &[Body], is_stopped: bool) -> Verdict {
        let [edges, vertices, whole] = [Aim::Edge, Aim::Vertex, Aim::Whole].map(|aim| self.judged[aim as usize]);
        let judged = edges + vertices + whole;
        let mut remarks = vec![
            format!(
                "drawn {} rays; of those judged {} hit two faces or more, being on an edge as computed",
                self.drawn, self.hit_several
            ),
            format!(
                "through patches with a face seen too thin, of which nothing is claimed: {} rays, {} slipped through",
                self.thin, self.thin_leaks
            ),
        ];
        let slipped: Vec<String> =
            LEAKY.iter().zip(self.leaks).map(|((name, _), leaks)| format!("{name} {leaks}")).collect();
        remarks.push(format!("the same rays slip through other ways to intersect: {}", slipped.join(", ")));
        let mut failures = self.leaked.lines();
        if self.tried >= ENOUGH {
            let tight = LEAKY.iter().zip(self.leaks).filter(|(_, leaks)| *leaks == 0);
            failures
                .extend(tight.map(|((name, _), _)| format!("the campaign cannot fail: no ray slips through {name}")));
        }
        let covered = format!(
            "{judged} rays at closed meshes ({} of them): {edges} at edges, {vertices} at vertices, {whole} at the whole",
            bodies.len()
        );
        Verdict { covered, failures, remarks, is_stopped }
    }
}

impl Tally for Rays {
    fn join(&mut self, later: Self) {
        self.drawn += later.drawn;
        self.hit_several += later.hit_several;
        self.thin += later.thin;
        self.thin_leaks += later.thin_leaks;
        self.tried += later.tried;
        self.judged.iter_mut().zip(later.judged).for_each(|(a, b)| *a += b);
        self.leaks.iter_mut().zip(later.leaks).for_each(|(a, b)| *a += b);
        self.leaked.join(later.leaked);
    }
}

#[cfg(test)]
mod tests {
    use super::{Intersect, Rays, bodies};
    use crate::geometry::intersect::{LEAKY, datapath};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use raypath_ops::{Binary32, Ray, Rules};

    fn shoot(is_hit: &dyn Intersect) -> Rays {
        let (bodies, mut rng, mut rays) = (bodies(2), ChaCha8Rng::seed_from_u64(3), Rays::default());
        (0..20_000).for_each(|_| rays.shoot(&mut rng, &bodies, is_hit));
        rays
    }

    /// The campaign passes the datapath under both rule sets, and each of the ways to intersect that leak fails it.
    #[test]
    fn what_leaks_is_found() {
        for rules in [Rules::Paper, Rules::Chisel] {
            let rays = shoot(&|ray: &Ray<Binary32>, corners| datapath(rules, ray, corners).triangle_hit.into());
            assert_eq!((rays.leaked.count(), rays.judged.iter().sum::<u64>()), (0, 20_000), "{rules}");
            assert!(rays.judged.iter().all(|&rays| rays > 50) && rays.hit_several > 1000, "{:?}", rays.judged);
        }
        for (name, intersect) in LEAKY {
            let leaked = shoot(&intersect).leaked.count();
            assert!(leaked > 100, "{name}: {leaked}");
        }
    }
}
