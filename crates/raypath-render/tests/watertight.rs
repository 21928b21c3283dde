//! Watertightness: traversal with boxes is as watertight as the triangle test.

use crate::common::meshes::{self, Named};
use crate::common::patches::Patches;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use raypath_ops::{Binary32, Ray};
use raypath_render::{Mesh, Scene, Tracing, builtin, trace_closest};

fn ray_count() -> usize {
    std::env::var("RAYPATH_RAYS").map_or(20_000, |count| count.parse().unwrap())
}

/// Rays towards edges and vertices whose faces all face the ray, from up to 256 times the size of the mesh.
#[test]
fn rays_at_edges_and_vertices_hit() {
    for Named { name, mesh } in meshes::all() {
        let (scene, patches) = (Scene::new(mesh.clone()).unwrap(), Patches::new(&mesh));
        let aimed: Vec<(Vec<u32>, Ray<Binary32>)> = aimed(&mesh, &patches);
        let rays: Vec<Ray<Binary32>> = aimed.iter().map(|(_, ray)| *ray).collect();
        let (hits, _) = trace_closest(&scene, &rays, Tracing::default(), &|_| true).unwrap();
        let checked = aimed.par_iter().zip(&hits).filter_map(|((patch, ray), hit)| {
            let farthest = patches.must_hit(patch, ray)?;
            Some(hit.is_some_and(|hit| f64::from(hit.t) <= farthest))
        });
        let checked: Vec<bool> = checked.collect();
        let misses = checked.iter().filter(|&&hit| !hit).count();
        println!("{name}: {} rays, of which {} must hit their patch; {misses} miss", rays.len(), checked.len());
        assert!(checked.len() > rays.len() / 5, "{name}: {} of {}", checked.len(), rays.len());
        assert_eq!(misses, 0, "{name}");
    }
}

/// Rays from inside closed bodies of the built-in scene, in random directions and towards vertices.
#[test]
fn rays_inside_closed_bodies_hit() {
    let scene = Scene::new(builtin().unwrap()).unwrap();
    let mesh = scene.mesh();
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut inside = |radius: f32, centre: [f32; 3]| centre.map(|x| x + radius * random.random_range(-1.0..1.0_f32));
    // The ground, and the sphere in the middle.
    let origins: Vec<[f32; 3]> = (0..ray_count() / 4)
        .map(|index| match index % 2 {
            0 => inside(0.1, [0.8, -0.3, -0.5]),
            _ => inside(0.2, [0.0, 1.95, 0.0]),
        })
        .collect();
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let rays = origins.iter().flat_map(|&origin| {
        let anywhere: [f32; 3] = std::array::from_fn(|_| random.random_range(-1.0..1.0));
        let vertex = mesh.positions()[random.random_range(0..mesh.positions().len())];
        let lattice: [f32; 3] = std::array::from_fn(|_| random.random_range(-2..=2) as f32);
        let at_vertex = std::array::from_fn(|k| vertex[k] - origin[k]);
        [anywhere, at_vertex, lattice].into_iter().filter_map(move |d| Ray::new(origin, d, f32::INFINITY).ok())
    });
    let rays: Vec<Ray<Binary32>> = rays.collect();
    let (hits, _) = trace_closest(&scene, &rays, Tracing { two_sided: true, ..Tracing::default() }, &|_| true).unwrap();
    assert_eq!(hits.iter().filter(|hit| hit.is_none()).count(), 0, "of {}", rays.len());
}

fn aimed(mesh: &Mesh, patches: &Patches) -> Vec<(Vec<u32>, Ray<Binary32>)> {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let bounds = mesh.bounds();
    let size = bounds.longest_side();
    let mut aimed = Vec::new();
    while aimed.len() < ray_count() {
        let face = random.random_range(0..mesh.triangles().len() as u32);
        let corner = random.random_range(0..3);
        let corners = mesh.corners(face);
        let (a, b) = (corners[corner], corners[(corner + 1) % 3]);
        let part: f32 = [0.5, 0.25, random.random()][random.random_range(0..3)];
        let (patch, target) = match random.random::<bool>() {
            true => (Some(patches.fan(face, corner)), a),
            false => (patches.edge(face, corner), std::array::from_fn(|k| a[k] + part * (b[k] - a[k]))),
        };
        let Some(patch) = patch else { continue };
        // An origin in front of the face.
        let p: [[f32; 3]; 2] = [1, 2].map(|k| std::array::from_fn(|axis| corners[k][axis] - corners[0][axis]));
        let normal: [f32; 3] = std::array::from_fn(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            p[0][i] * p[1][j] - p[0][j] * p[1][i]
        });
        let length = normal.iter().map(|x| x * x).sum::<f32>().sqrt();
        let away: f32 = random.random_range(-2.0_f32..8.0).exp2() * size;
        let origin: [f32; 3] = std::array::from_fn(|k| {
            let sideways = random.random_range(-0.7..0.7);
            target[k] + away * (normal[k] / length + sideways) / 2.0
        });
        let lattice = random.random::<bool>();
        let origin = if lattice { origin.map(|x| (x / size * 16.0).round() / 16.0 * size) } else { origin };
        let direction = std::array::from_fn(|k| target[k] - origin[k]);
        if let Ok(ray) = Ray::new(origin, direction, f32::INFINITY) {
            aimed.push((patch, ray));
        }
    }
    aimed
}
