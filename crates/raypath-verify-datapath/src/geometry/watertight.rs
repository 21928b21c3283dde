//! No ray passes through an edge or vertex that is shared by faces which all face it, and with the rule `once` for edges
//! each ray hits exactly one of them, or as many as cover it.

use super::needles::Needles;
use super::patches::{Patch, Target};
use super::vector::{cross, dot, minus};
use super::visibility::{Visibility, visibility};
use rand::rngs::ChaCha8Rng;
use raypath_model::Functional;
use raypath_ops::{
    Binary32, EdgeRule, Job, Operation, Outcome, Ray, RayTriangleExtended, RayTriangleExtendedInput, RayTriangleInput,
    RayTriangleOutput, Rounding, Rules, Triangle,
};
use raypath_verify::campaign::{Campaign, Tally};
use raypath_verify::{Error, Request, Verdict};

/// The number of cases after which each leaking implementation must have been found.
const ENOUGH: u64 = 100_000;
/// The number of random rays to try until one satisfies the claim's preconditions.
const DRAWS: u32 = 200;

/// Aims rays at patches. In each case the ray passes, by exact arithmetic, through a patch of faces that all face it;
/// the datapath must hit one of them, and with `edges once` exactly one.
pub fn verify(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let (rules, rounding) = (request.config.semantics.rules_in_full(), request.config.semantics.rounding);
    let cases = request.jobs.unwrap_or(request.level.pick(1_000_000, 10_000_000, 1_000_000_000));
    let is_hit = |ray: &Ray<Binary32>, corners| datapath(rules, rounding, ray, corners).triangle_hit.into();
    let (tally, is_stopped) = Campaign::new(1, cases).run_cases(request, |rng, tally| run(tally, rng, &is_hit))?;
    Ok(verdict(tally, is_stopped))
}

/// An implementation: whether a ray hits a triangle.
trait Intersect: Fn(&Ray<Binary32>, [[f32; 3]; 3]) -> bool {}
impl<F: Fn(&Ray<Binary32>, [[f32; 3]; 3]) -> bool> Intersect for F {}

/// The counts of checked rays, by target.
const TARGETS: [(Target, &str); 2] = [(Target::Edge, "edges"), (Target::Vertex, "vertices")];

/// Draws a fan of needles, of which one must be hit with `edges once`, then patches and rays until one must hit by exact arithmetic, and checks it.
fn run(tally: &mut Tally, rng: &mut ChaCha8Rng, is_hit: &dyn Intersect) {
    if let Some(needles) = Needles::draw(rng) {
        tally.add("needles", true);
        let hits = |intersect: &dyn Intersect| needles.faces().filter(|face| intersect(&Needles::ray(), *face)).count();
        tally.add(BY_DIRECTION, hits(&by_direction) != 1);
        let hits = hits(&once);
        if hits != 1 {
            tally
                .fail(|| format!("a ray along z hits {hits} of {:?}, expected 1", needles.faces().collect::<Vec<_>>()));
        }
    }
    for _ in 0..DRAWS {
        let patch = Patch::draw(rng);
        tally.add("drawn", true);
        let Some(ray) = patch.aim(rng) else { continue };
        let hits = |intersect: &dyn Intersect| {
            patch.faces.iter().filter(|face| intersect(&ray, patch.corners(**face))).count()
        };
        match visibility(&ray, &patch) {
            Visibility::BackFacing | Visibility::Behind | Visibility::NearRim => {}
            Visibility::Thin => {
                tally.add("thin", true);
                tally.add("thin without a hit", hits(is_hit) == 0);
            }
            Visibility::Clear(turns) => {
                TARGETS.iter().for_each(|(target, name)| tally.add(*name, patch.target == *target));
                LEAKY.iter().for_each(|(name, intersect)| tally.add(*name, hits(intersect) == 0));
                let (hits, hits_once) = (hits(is_hit), hits(&once));
                tally.add("several hits", hits > 1);
                if hits == 0 || hits_once != turns {
                    let (origin, dir): ([f32; 3], [f32; 3]) = (ray.origin.into(), ray.dir.into());
                    let faces: Vec<_> = patch.faces.iter().map(|face| patch.corners(*face)).collect();
                    let found = format!("{hits} hits, and {hits_once} with edges once");
                    tally.fail(|| format!("a ray from {origin:?} along {dir:?} through {faces:?}: {found}"));
                }
                return;
            }
        }
    }
}

fn verdict(tally: Tally, is_stopped: bool) -> Verdict {
    let [edges, vertices] = TARGETS.map(|(_, name)| tally.count(name));
    let checked = edges + vertices;
    let count = |name| tally.count(name);
    let remarks = vec![
        format!(
            "{} random rays; {} of the checked ones hit two faces or more, and with edges once each hits as many as cover it",
            count("drawn"),
            count("several hits")
        ),
        format!(
            "through patches with a thin face, which the claim excludes: {} rays, {} of them without a hit",
            count("thin"),
            count("thin without a hit")
        ),
    ];
    let needles = count("needles");
    let covered = format!(
        "{checked} rays: {edges} at edges of two faces, {vertices} at vertices of three to eight; {needles} at needles"
    );
    let label = "the same rays leak through other implementations";
    tally.verdict(
        is_stopped,
        covered,
        remarks,
        (label, [LEAKY[0].0, LEAKY[1].0, LEAKY[2].0, BY_DIRECTION], checked >= ENOUGH),
    )
}

/// The datapath's result for a ray and a triangle.
pub fn datapath(
    rules: Rules,
    rounding: Rounding,
    ray: &Ray<Binary32>,
    [a, b, c]: [[f32; 3]; 3],
) -> RayTriangleOutput<Binary32> {
    let job = Job::Triangle(RayTriangleInput { ray: *ray, triangle: Triangle::new(a, b, c) });
    match Functional::<16, 8>::new(rules).rounding(rounding).run(&job) {
        Outcome::Triangle(output) => output,
        other => unreachable!("a triangle's outcome is no {other:?}"),
    }
}

/// Whether the datapath hits a triangle whose edges may belong to others.
fn once(ray: &Ray<Binary32>, [a, b, c]: [[f32; 3]; 3]) -> bool {
    let triangles = RayTriangleExtended { edges: EdgeRule::Once, ..RayTriangleExtended::PLAIN };
    let input = RayTriangleExtendedInput { ray: *ray, triangle: Triangle::new(a, b, c), t_min: 0.0.into() };
    triangles.run(Binary32, input, ()).0.triangle_hit.into()
}

/// An implementation and its name.
type Named = (&'static str, fn(&Ray<Binary32>, [[f32; 3]; 3]) -> bool);

/// Implementations that let rays pass between faces. They are the negative control: a campaign that
/// does not find these faults would not find a fault of the datapath.
const LEAKY: [Named; 3] =
    [("edges that belong to no face", open_edges), ("fused products", fused), ("Möller-Trumbore", moeller_trumbore)];

/// U, V, W > 0 instead of ≥ 0.
fn open_edges(ray: &Ray<Binary32>, corners: [[f32; 3]; 3]) -> bool {
    let [a, b, c] = sheared(ray, corners);
    let edge = |p: [f32; 2], q: [f32; 2]| p[0] * q[1] - p[1] * q[0];
    edge(c, b) > 0.0 && edge(a, c) > 0.0 && edge(b, a) > 0.0
}

/// The count of needles of which not exactly one is hit if every edge function that is 0 after rounding is decided as if
/// it were 0 exactly.
const BY_DIRECTION: &str = "zeros decided by direction alone";

fn by_direction(ray: &Ray<Binary32>, corners: [[f32; 3]; 3]) -> bool {
    let [a, b, c] = sheared(ray, corners);
    let half_plane = |[x, y]: [f32; 2]| if y == 0.0 { x } else { y }.partial_cmp(&0.0);
    let has = |end: [f32; 2], start: [f32; 2]| match end[0] * start[1] - end[1] * start[0] {
        0.0 => half_plane(end) > half_plane(start),
        edge => edge > 0.0,
    };
    has(c, b) && has(a, c) && has(b, a)
}

/// One product of each edge function is not rounded, so that the ray can be outside of both faces of an edge.
fn fused(ray: &Ray<Binary32>, corners: [[f32; 3]; 3]) -> bool {
    let [a, b, c] = sheared(ray, corners);
    let edge = |p: [f32; 2], q: [f32; 2]| p[0].mul_add(q[1], -(p[1] * q[0]));
    edge(c, b) >= 0.0 && edge(a, c) >= 0.0 && edge(b, a) >= 0.0
}

/// Stages 2 to 4 of Table VII: x and y of each corner.
fn sheared(ray: &Ray<Binary32>, corners: [[f32; 3]; 3]) -> [[f32; 2]; 3] {
    let (origin, [sx, sy, _]) = (<[f32; 3]>::from(ray.origin), <[f32; 3]>::from(ray.shear));
    let [kx, ky, kz] = [ray.kx, ray.ky, ray.kz].map(|k| u32::from(k) as usize);
    corners.map(|corner| {
        let r: [f32; 3] = std::array::from_fn(|i| corner[i] - origin[i]);
        [r[kx] - sx * r[kz], r[ky] - sy * r[kz]]
    })
}

/// Möller and Trumbore's test in binary32: adjacent faces compute a common edge from different vertices.
fn moeller_trumbore(ray: &Ray<Binary32>, [a, b, c]: [[f32; 3]; 3]) -> bool {
    let (origin, d) = (<[f32; 3]>::from(ray.origin), <[f32; 3]>::from(ray.dir));
    let (e, f, from_a) = (minus(b, a), minus(c, a), minus(origin, a));
    let (p, q) = (cross(d, f), cross(from_a, e));
    let determinant = dot(e, p);
    let (v, w) = (dot(from_a, p), dot(d, q));
    determinant > 0.0 && v >= 0.0 && w >= 0.0 && v + w <= determinant && dot(f, q) > 0.0
}

#[cfg(test)]
mod tests {
    use super::{BY_DIRECTION, Intersect, LEAKY, TARGETS, Tally, datapath, once, run};
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;
    use raypath_ops::{Binary32, Ray, Rounding, Rules};

    fn run_rays(is_hit: &dyn Intersect) -> Tally {
        let (mut rng, mut tally) = (ChaCha8Rng::seed_from_u64(3), Tally::default());
        (0..20_000).for_each(|_| run(&mut tally, &mut rng, is_hit));
        tally
    }

    /// The campaign passes the datapath under both rule sets and both roundings, and finds each leaking implementation.
    #[test]
    fn leaks_are_found() {
        let cases = [(Rules::Paper, Rounding::Unit), (Rules::Chisel, Rounding::Unit), (Rules::Paper, Rounding::Sum)];
        for (rules, rounding) in cases {
            let is_hit = |ray: &Ray<Binary32>, corners| datapath(rules, rounding, ray, corners).triangle_hit.into();
            let rays = run_rays(&is_hit);
            let checked = TARGETS.map(|(_, name)| rays.count(name));
            assert_eq!((rays.failures(), checked.iter().sum::<u64>()), (0, 20_000), "{rules}, {rounding}");
            assert!(checked.iter().all(|&rays| rays > 2000) && rays.count("several hits") > 1000, "{rays:?}");
        }
        for (name, intersect) in LEAKY {
            let leaked = run_rays(&intersect).failures();
            assert!(leaked > 100, "{name}: {leaked}");
        }
        let rays = run_rays(&once);
        let (needles, by_direction) = (rays.count("needles"), rays.count(BY_DIRECTION));
        assert!(needles > 5_000 && by_direction > 10, "{needles} needles, {by_direction}");
    }
}
