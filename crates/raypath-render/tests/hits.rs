//! The hits of the tracer, compared with exact geometry and with brute force over all triangles.
//!
//! `RAYPATH_RAYS` is the number of rays of each kind per mesh, by default 2,000, half of them two-sided. `RAYPATH_MESH`
//! selects one mesh. The campaign traces a million rays per mesh:
//! `RAYPATH_RAYS=250000 cargo test --release -p raypath-render --test integration -- hits watertight --nocapture`.

use crate::common::meshes::{self, Named};
use crate::common::oracle::{Oracle, Verdict};
use crate::common::rays::{Kind, rays};
use rayon::prelude::*;
use raypath_ops::{Binary32, Operation, Ray, RayTriangle, RayTriangleInput, Rounding, Rules, Triangle};
use raypath_render::{Hit, Mesh, Scene, Tracing, trace_any, trace_closest};

fn ray_count() -> usize {
    std::env::var("RAYPATH_RAYS").map_or(2_000, |count| count.parse().unwrap())
}

#[test]
fn hits_are_those_of_exact_geometry_within_the_error_bounds() {
    for Named { name, mesh } in meshes::all() {
        for two_sided in [false, true] {
            let (oracle, tracing) = (Oracle::new(&mesh, two_sided), Tracing { two_sided, ..Tracing::default() });
            let scene = Scene::new(mesh.clone()).unwrap();
            let count = ray_count() / 2;
            for kind in Kind::ALL {
                let rays = rays(&mesh, kind, count, 1);
                assert!(rays.iter().all(|ray| scene.reaches(ray.origin.into())));
                let (hits, _) = trace_closest(&scene, &rays, tracing, &|_| true).unwrap();
                let checked = rays.par_iter().zip(&hits).map(|(ray, &hit)| {
                    oracle.check(ray, hit).unwrap_or_else(|error| panic!("{name}, {kind:?}, {ray:?}: {error}"))
                });
                let verdicts: Vec<Verdict> = checked.collect();
                let count = |verdict| verdicts.iter().filter(|&&v| v == verdict).count();
                let found = hits.iter().flatten().count();
                println!(
                    "{name:8} {kind:9?} two-sided {two_sided:5}: {} rays, {found} hits; \
                     same {}, other triangle {}, hit not miss {}, miss not hit {}",
                    rays.len(),
                    count(Verdict::Same),
                    count(Verdict::Other),
                    count(Verdict::HitNotMiss),
                    count(Verdict::MissNotHit),
                );
                // The rays must have hits, and away from edges rounding has next to no effect.
                assert!(found > rays.len() / 20, "{name}, {kind:?}: {found} hits");
                if matches!(kind, Kind::Primary | Kind::Random) {
                    assert!(count(Verdict::Same) as f64 > 0.999 * rays.len() as f64, "{name}, {kind:?}");
                }
                let (any, _) = trace_any(&scene, &rays, tracing, &|_| true).unwrap();
                assert!(any.iter().zip(&hits).all(|(&any, hit)| any == hit.is_some()), "{name}, {kind:?}: any hit");
            }
        }
    }
}

/// Traversal gives the same hit, bit for bit, as the triangle jobs of all triangles.
#[test]
fn traversal_equals_brute_force() {
    for Named { name, mesh } in meshes::all() {
        let scene = Scene::new(mesh.clone()).unwrap();
        let count = (ray_count() * 3_000 / mesh.triangles().len()).min(ray_count());
        for two_sided in [false, true] {
            for kind in Kind::ALL {
                let rays = rays(&mesh, kind, count, 2);
                let (hits, _) =
                    trace_closest(&scene, &rays, Tracing { two_sided, rules: Rules::Paper }, &|_| true).unwrap();
                let all: Vec<Option<Hit>> = rays.par_iter().map(|ray| brute_force(&mesh, ray, two_sided)).collect();
                let lost = hits.iter().zip(&all).filter(|(hit, all)| hit != all).count();
                assert_eq!(lost, 0, "{name}, {kind:?}: of {count} rays");
            }
        }
    }
}

fn brute_force(mesh: &Mesh, ray: &Ray<Binary32>, two_sided: bool) -> Option<Hit> {
    let mut best: Option<Hit> = None;
    for triangle in 0..mesh.triangles().len() as u32 {
        let [a, b, c] = mesh.corners(triangle);
        for from_behind in [false, true].into_iter().take(1 + usize::from(two_sided)) {
            let triangle_seen = if from_behind { Triangle::new(a, c, b) } else { Triangle::new(a, b, c) };
            let input = RayTriangleInput { ray: *ray, triangle: triangle_seen };
            let (output, ()) = RayTriangle { rules: Rules::Paper, rounding: Rounding::Unit }.run(Binary32, input, ());
            let (t_num, t_denom) = (f32::from(output.t_num), f32::from(output.t_denom));
            let t = t_num / t_denom;
            let nearer = best.is_none_or(|best| t < best.t);
            if bool::from(output.triangle_hit) && t <= f32::from(ray.extent) && nearer {
                best = Some(Hit { triangle, from_behind, t_num, t_denom, t, instance: None });
            }
        }
    }
    best
}
