//! The closed meshes that rays are aimed at.

use super::mesh::Mesh;
use super::vector::{Point, cross, dot, minus, scaled, sum, unit};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::collections::HashMap;

/// All meshes, with random ones by this seed.
pub fn shapes(seed: u64) -> Vec<Mesh> {
    let rng = &mut ChaCha8Rng::seed_from_u64(seed);
    let (octahedron, icosahedron) = (octahedron(), icosahedron());
    let sphere = |times: u32| sphere(&icosahedron, times);
    let stretched = |name: &'static str, stretch: Point| {
        let (points, faces) = sphere(2);
        Mesh::new(name, &points.iter().map(|p| std::array::from_fn(|i| p[i] * stretch[i])).collect::<Vec<_>>(), faces)
    };
    let shape = |name: &'static str, (points, faces): (Vec<Point>, Vec<[usize; 3]>)| Mesh::new(name, &points, faces);
    vec![
        shape("tetrahedron", tetrahedron()),
        shape("cube", cube()),
        shape("octahedron", octahedron.clone()),
        shape("icosahedron", sphere(0)),
        shape("icosphere 1", sphere(1)),
        shape("icosphere 2", sphere(2)),
        shape("icosphere 3", sphere(3)),
        shape("lattice sphere", lattice(self::sphere(&octahedron, 2))),
        shape("torus", torus()),
        shape("spindle", spindle(256.0)),
        shape("lens", spindle(1.0 / 256.0)),
        stretched("needle", [1.0, 1.0 / 128.0, 1.0 / 1024.0]),
        stretched("leaf", [1.0, 0.5, 1.0 / 4096.0]),
        shape("star", star(sphere(2), rng)),
        shape("random hull", hull(rng)),
    ]
}

type Shape = (Vec<Point>, Vec<[usize; 3]>);

fn tetrahedron() -> Shape {
    let points = vec![[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]];
    let faces = vec![[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];
    let faces = faces.into_iter().map(|face| outwards(&points, face)).collect();
    (points, faces)
}

fn cube() -> Shape {
    let points = (0..8).map(|corner| std::array::from_fn(|axis| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 }));
    let points: Vec<Point> = points.collect();
    let faces = (0..3).flat_map(|axis| {
        let (side, [x, y]) = (1 << axis, [1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3)]);
        [0, side].into_iter().flat_map(move |at| [[at, at + x, at + x + y], [at, at + x + y, at + y]])
    });
    let faces = faces.map(|face| outwards(&points, face)).collect();
    (points, faces)
}

fn octahedron() -> Shape {
    let points =
        (0..6).map(|i| std::array::from_fn(|axis| if axis == i / 2 { 1.0 - 2.0 * (i % 2) as f64 } else { 0.0 }));
    let points: Vec<Point> = points.collect();
    let faces = (0..8).map(|i| outwards(&points, [i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2)])).collect();
    (points, faces)
}

/// An icosahedron of three golden rectangles; three corners at edge length of each other are a face.
fn icosahedron() -> Shape {
    let golden = (1.0 + 5_f64.sqrt()) / 2.0;
    let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let corner = |axis: usize, [s, t]: [f64; 2]| {
        let mut point = [0.0; 3];
        (point[axis], point[(axis + 1) % 3]) = (s, t * golden);
        point
    };
    let points: Vec<Point> = (0..3).flat_map(|axis| signs.map(|sign| corner(axis, sign))).collect();
    let near = |i: usize, j: usize| {
        let difference = minus(points[i], points[j]);
        dot(difference, difference) < 4.1
    };
    let mut faces = Vec::new();
    for (i, j, k) in (0..12).flat_map(|i| (0..i).flat_map(move |j| (0..j).map(move |k| (i, j, k)))) {
        if near(i, j) && near(j, k) && near(i, k) {
            faces.push(outwards(&points, [i, j, k]));
        }
    }
    (points.into_iter().map(unit).collect(), faces)
}

/// A sphere of radius 1: each face is divided into four this many times.
fn sphere((points, faces): &Shape, times: u32) -> Shape {
    let (mut points, mut faces) = (points.clone(), faces.clone());
    for _ in 0..times {
        let mut halves = HashMap::new();
        let mut half = |a: usize, b: usize| {
            *halves.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                points.push(unit(sum(points[a], points[b])));
                points.len() - 1
            })
        };
        let divided = faces.iter().flat_map(|&[a, b, c]| {
            let [ab, bc, ca] = [half(a, b), half(b, c), half(c, a)];
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        });
        faces = divided.collect();
    }
    (points, faces)
}

/// All coordinates rounded to eighths.
fn lattice((points, faces): Shape) -> Shape {
    (points.into_iter().map(|point| point.map(|x| (x * 8.0).round() / 8.0)).collect(), faces)
}

fn torus() -> Shape {
    let (ring, tube) = (circle(3), circle(2));
    let (around, across) = (ring.len(), tube.len());
    let vertex = |[x, y]: [f64; 2], [out, z]: [f64; 2]| [(1.0 + 0.4 * out) * x, (1.0 + 0.4 * out) * y, 0.4 * z];
    let points = ring.iter().flat_map(|&at| tube.iter().map(move |&side| vertex(at, side))).collect();
    let index = |i: usize, j: usize| i % around * across + j % across;
    let faces = (0..around * across).flat_map(|patch| {
        let (i, j) = (patch / across, patch % across);
        let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    (points, faces.collect())
}

/// Two pyramids of this height on a polygon of 64 corners, with needle-shaped faces that meet in one vertex.
fn spindle(height: f64) -> Shape {
    let ring = circle(4);
    let corners = ring.len();
    let points = ring.iter().map(|&[x, y]| [x, y, 0.0]).chain([[0.0, 0.0, height], [0.0, 0.0, -height]]).collect();
    let side = |i: usize| [[i, (i + 1) % corners, corners], [(i + 1) % corners, i, corners + 1]];
    (points, (0..corners).flat_map(side).collect())
}

/// A sphere with each vertex moved inwards or outwards at random.
fn star((points, faces): Shape, rng: &mut ChaCha8Rng) -> Shape {
    (points.into_iter().map(|point| scaled(point, rng.random_range(0.5..1.5))).collect(), faces)
}

/// The convex hull of random points on a sphere, a third of them close together, built point by point.
fn hull(rng: &mut ChaCha8Rng) -> Shape {
    let (mut points, mut faces) = tetrahedron();
    points.iter_mut().for_each(|point| *point = unit(*point));
    for i in 0..60 {
        let mut point = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        if i % 3 == 0 {
            point = sum(unit([1.0, 2.0, 3.0]), scaled(point, 1.0 / 256.0));
        }
        let point = unit(point);
        let faces_point = |&[a, b, c]: &[usize; 3]| {
            let normal = cross(minus(points[b], points[a]), minus(points[c], points[a]));
            dot(normal, minus(point, points[a])) > 0.0
        };
        let (visible, mut remaining): (Vec<[usize; 3]>, Vec<[usize; 3]>) = faces.iter().copied().partition(faces_point);
        let edges: Vec<[usize; 2]> = visible.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        let horizon = edges.iter().filter(|&&[a, b]| !edges.contains(&[b, a]));
        remaining.extend(horizon.map(|&[a, b]| [a, b, points.len()]));
        faces = remaining;
        points.push(point);
    }
    (points, faces)
}

/// The corners of a regular polygon of 4 · 2^times corners.
fn circle(times: u32) -> Vec<[f64; 2]> {
    let mut corners = vec![[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
    for _ in 0..times {
        let next = corners.iter().cycle().skip(1);
        let pairs: Vec<_> = corners.iter().zip(next).map(|(&a, &b)| (a, b)).collect();
        corners = pairs
            .into_iter()
            .flat_map(|(a, b)| {
                let [x, y, _] = unit([a[0] + b[0], a[1] + b[1], 0.0]);
                [a, [x, y]]
            })
            .collect();
    }
    corners
}

/// The face ordered counter-clockwise as seen from outside, for a mesh around the origin.
fn outwards(points: &[Point], [a, b, c]: [usize; 3]) -> [usize; 3] {
    if dot(points[a], cross(points[b], points[c])) > 0.0 { [a, b, c] } else { [a, c, b] }
}
