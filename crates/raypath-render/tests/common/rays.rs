//! Random rays of four kinds.

use rand::rngs::ChaCha8Rng;
use rand::{Rng, RngExt, SeedableRng};
use raypath_ops::{Binary32, Ray};
use raypath_render::{Bounds, Mesh};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// From outside through a picture's pixels.
    Primary,
    /// Between random points, some with an extent.
    Random,
    /// From outside towards points of edges.
    Edges,
    /// From outside towards vertices.
    Vertices,
}

impl Kind {
    pub const ALL: [Self; 4] = [Self::Primary, Self::Random, Self::Edges, Self::Vertices];
}

/// `count` rays of a kind for a mesh.
pub fn rays(mesh: &Mesh, kind: Kind, count: usize, seed: u64) -> Vec<Ray<Binary32>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let bounds = mesh.bounds();
    (0..count).map(|index| ray(mesh, bounds, kind, index, count, &mut random)).collect()
}

fn ray(mesh: &Mesh, bounds: Bounds, kind: Kind, index: usize, count: usize, random: &mut ChaCha8Rng) -> Ray<Binary32> {
    let (centre, size) = (bounds.centre(), bounds.longest_side());
    loop {
        let (origin, target, extent) = match kind {
            Kind::Primary => {
                // 100 eyes on a spiral.
                let eye = index * 100 / count;
                let angle = eye as f32 * 2.4;
                let origin = [
                    centre[0] + 2.0 * size * angle.cos(),
                    centre[1] + size * (eye as f32 / 50.0 - 1.0),
                    centre[2] + 2.0 * size * angle.sin(),
                ];
                (origin, around(centre, 0.5 * size, random), f32::INFINITY)
            }
            Kind::Random => {
                let (origin, target) = (around(centre, 0.8 * size, random), around(centre, 0.6 * size, random));
                let extent = if random.random::<bool>() { f32::INFINITY } else { 2.0 * random.random::<f32>() };
                (origin, target, extent)
            }
            Kind::Edges => {
                let [a, b, _] = rotated(corners(mesh, random), random);
                let part: f32 = [0.5, 0.25, 0.125, random.random()][random.random_range(0..4)];
                (eye(centre, size, random), std::array::from_fn(|k| a[k] + part * (b[k] - a[k])), f32::INFINITY)
            }
            Kind::Vertices => (eye(centre, size, random), corners(mesh, random)[0], f32::INFINITY),
        };
        let direction = std::array::from_fn(|k| target[k] - origin[k]);
        if let Ok(ray) = Ray::new(origin, direction, extent) {
            return ray;
        }
    }
}

fn corners(mesh: &Mesh, random: &mut impl Rng) -> [[f32; 3]; 3] {
    mesh.corners(random.random_range(0..mesh.triangles().len() as u32))
}

fn rotated<T: Copy>(three: [T; 3], random: &mut impl Rng) -> [T; 3] {
    let first = random.random_range(0..3);
    std::array::from_fn(|k| three[(first + k) % 3])
}

/// A point outside, one to seven sizes away from the centre. Half of the points lie on a coarse lattice, so that
/// differences are exact more often.
fn eye(centre: [f32; 3], size: f32, random: &mut impl Rng) -> [f32; 3] {
    let direction: [f32; 3] = std::array::from_fn(|_| random.random_range(-1.0..1.0));
    let greatest = direction.iter().fold(0.01, |max: f32, x| max.max(x.abs()));
    let distance = size * random.random_range(1.0..7.0);
    let point = std::array::from_fn(|k| centre[k] + distance / greatest * direction[k]);
    if random.random::<bool>() { point.map(|x| (x / size * 8.0).round() / 8.0 * size) } else { point }
}

fn around(centre: [f32; 3], radius: f32, random: &mut impl Rng) -> [f32; 3] {
    centre.map(|x| x + radius * random.random_range(-1.0..1.0))
}
