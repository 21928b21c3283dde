//! The scene: a torus, a camera that looks at it from above, and boxes around its triangles. It uses only the four
//! basic operations and square roots, so that it is the same on every machine.

use super::host::{Point, ray, unit};
use raypath_model::Binary64;
use raypath_ops::Ray;

/// Pixels of the camera's square picture, along each side.
const SIDE: usize = 64;
/// Rays of the scene.
pub const RAYS: usize = SIDE * SIDE;
/// Corners of the polygon that approximates a circle.
const CORNERS: usize = 16;

const CAMERA: Point = [2.1, -1.3, 1.6];
/// Half of the picture's width at a distance of 1.
const HALF_WIDTH: f64 = 0.55;
const RING: f64 = 1.0;
const TUBE: f64 = 0.4;

/// The rays of the camera's pixels, row by row, in a scene of this scale.
pub fn rays(scale: f64) -> impl Iterator<Item = Ray<Binary64>> {
    let forward = unit(CAMERA.map(|coordinate| -coordinate));
    let right = unit(cross(forward, [0.0, 0.0, 1.0]));
    let up = cross(right, forward);
    let offset = |pixel: usize| ((pixel as f64 + 0.5) / SIDE as f64 * 2.0 - 1.0) * HALF_WIDTH;
    let direction =
        move |x: usize, y: usize| unit(std::array::from_fn(|i| forward[i] + offset(x) * right[i] - offset(y) * up[i]));
    let origin = CAMERA.map(|coordinate| coordinate * scale);
    (0..RAYS).filter_map(move |pixel| ray(origin, direction(pixel % SIDE, pixel / SIDE)))
}

/// The torus, in this scale: a closed mesh of triangles, counter-clockwise as seen from outside.
pub fn triangles(scale: f64) -> Vec<[Point; 3]> {
    let circle = circle();
    let vertex = |i: usize, j: usize| {
        let ([x, y], [out, z]) = (circle[i % CORNERS], circle[j % CORNERS]);
        let radius = RING + TUBE * out;
        [radius * x, radius * y, TUBE * z].map(|coordinate| coordinate * scale)
    };
    let patches = (0..CORNERS * CORNERS).map(|patch| (patch / CORNERS, patch % CORNERS));
    patches
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

/// The bounding box of a triangle: its minimum and its maximum corner.
pub fn bounds([a, b, c]: [Point; 3]) -> [Point; 2] {
    let min = std::array::from_fn(|i| a[i].min(b[i]).min(c[i]));
    let max = std::array::from_fn(|i| a[i].max(b[i]).max(c[i]));
    [min, max]
}

/// The corners of a regular polygon with radius 1.
fn circle() -> [[f64; 2]; CORNERS] {
    let root = 2_f64.sqrt();
    let (cosine, sine) = ((2.0 + root).sqrt() / 2.0, (2.0 - root).sqrt() / 2.0);
    let mut corners = [[1.0, 0.0]; CORNERS];
    for corner in 1..CORNERS {
        let [x, y] = corners[corner - 1];
        corners[corner] = [x * cosine - y * sine, x * sine + y * cosine];
    }
    corners
}

fn cross(a: Point, b: Point) -> Point {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

#[cfg(test)]
mod tests {
    use super::{RAYS, bounds, cross, rays, triangles};
    use std::collections::HashSet;

    /// Every edge occurs once in each direction, so the mesh is closed. The volume is positive, so it faces outwards.
    #[test]
    fn the_torus_is_closed_and_faces_outwards() {
        let triangles = triangles(1.0);
        let key = |point: [f64; 3]| point.map(f64::to_bits);
        let edges = |[a, b, c]: [[f64; 3]; 3]| [(a, b), (b, c), (c, a)].map(|(from, to)| (key(from), key(to)));
        let all: HashSet<_> = triangles.iter().flat_map(|triangle| edges(*triangle)).collect();
        assert_eq!(all.len(), 3 * triangles.len());
        assert!(all.iter().all(|(from, to)| all.contains(&(*to, *from))));

        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let volume: f64 = triangles.iter().map(|[a, b, c]| dot(*a, cross(*b, *c)) / 6.0).sum();
        // A torus has the volume 2 pi^2 R r^2; the mesh has a little less.
        let round = 2.0 * std::f64::consts::PI.powi(2) * 0.4_f64.powi(2);
        assert!((0.9 * round..round).contains(&volume), "{volume} of {round}");
        assert!(triangles.len().is_multiple_of(4), "quadbox jobs take four");
    }

    #[test]
    fn every_pixel_has_a_ray() {
        assert_eq!(rays(1.0).count(), RAYS);
    }

    #[test]
    fn a_box_is_the_smallest_around_its_triangle() {
        let corners = bounds([[1.0, -2.0, 3.0], [0.0, 5.0, 3.5], [4.0, 1.0, -1.0]]);
        assert_eq!(corners, [[0.0, -2.0, -1.0], [4.0, 5.0, 3.5]]);
    }
}
