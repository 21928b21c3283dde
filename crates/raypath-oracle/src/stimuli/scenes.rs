//! Rays with what they may hit, points with boxes, and keys with separators.

use crate::layout::Field;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_ops::Ray;
use raypath_ops::operations::key_compare::SEPARATORS;

type Point = [f32; 3];

/// The number of boxes, of which an operation takes four or eight.
const BOXES: usize = 8;

/// A ray with its derived values, boxes, a triangle, a compressed node and a sphere; a point; a key and separators.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The axis indices kx, ky and kz.
    axes: [u64; 3],
    origin: Point,
    direction: Point,
    inverse: Point,
    shear: Point,
    extent: f32,
    boxes: [[Point; 2]; BOXES],
    triangle: [Point; 3],
    t_min: f32,
    point: Point,
    node: Node,
    centre: Point,
    radius: f32,
    key: f32,
    separators: [f32; SEPARATORS],
}

/// A compressed node: its origin, its scales, and the offsets of its children.
#[derive(Debug, Clone)]
struct Node {
    origin: Point,
    scale: Point,
    offsets: [[[u64; 2]; 3]; 4],
}

fn one_of<T: Copy>(values: &[T], rng: &mut ChaCha8Rng) -> T {
    values[rng.random_range(0..values.len())]
}

impl Scene {
    /// The number of a field; 0 for fields of other operations.
    pub fn number(&self, field: Field) -> f32 {
        match field {
            Field::Origin(axis) => self.origin[axis],
            Field::Direction(axis) => self.direction[axis],
            Field::Inverse(axis) => self.inverse[axis],
            Field::Shear(axis) => self.shear[axis],
            Field::Extent => self.extent,
            Field::Bound { index, axis, is_max } => self.boxes[index][usize::from(is_max)][axis],
            Field::Vertex { vertex, axis } => self.triangle[vertex][axis],
            Field::TMin => self.t_min,
            Field::Point(axis) => self.point[axis],
            Field::NodeOrigin(axis) => self.node.origin[axis],
            Field::NodeScale(axis) => self.node.scale[axis],
            Field::Centre(axis) => self.centre[axis],
            Field::Radius => self.radius,
            Field::Key => self.key,
            Field::Separator(index) => self.separators[index],
            _ => 0.0,
        }
    }

    /// The word of a field that is no number; 0 for fields of other operations.
    pub fn word(&self, field: Field) -> u64 {
        match field {
            Field::Axis(axis) => self.axes[axis],
            Field::Offset { child, axis, is_max } => self.node.offsets[child][axis][usize::from(is_max)],
            _ => 0,
        }
    }

    /// A typical scene of a renderer: a ray aimed at the triangle, and boxes near its path.
    pub fn typical(rng: &mut ChaCha8Rng) -> Self {
        let point = |reach: f32, rng: &mut ChaCha8Rng| std::array::from_fn(|_| rng.random_range(-reach..reach));
        let (origin, triangle): (Point, [Point; 3]) = (point(4.0, rng), std::array::from_fn(|_| point(1.0, rng)));
        let weights: Point = point(1.0, rng).map(|weight: f32| weight.abs() + 0.01);
        let sum: f32 = weights.iter().sum();
        let target = |i: usize| (0..3).map(|vertex| weights[vertex] * triangle[vertex][i]).sum::<f32>() / sum;
        let direction: Point = std::array::from_fn(|i| target(i) - origin[i]);
        let extent = if rng.random_bool(0.7) { f32::INFINITY } else { rng.random_range(0.0..2.0) };
        // A direction of zero length is replaced by a lattice.
        let Ok(ray) = Ray::new(origin, direction, extent) else { return Self::lattice(rng) };
        let boxes = std::array::from_fn(|_| {
            let (centre, half): (Point, Point) = (point(1.0, rng), point(1.0, rng));
            [std::array::from_fn(|i| centre[i] - half[i].abs()), std::array::from_fn(|i| centre[i] + half[i].abs())]
        });
        let axes = [ray.kx, ray.ky, ray.kz].map(|axis| u32::from(axis).into());
        let (inverse, shear) = (ray.inv.into(), ray.shear.into());
        let t_min = if rng.random_bool(0.5) { 0.0 } else { rng.random_range(0.0..1.5) };
        let number = |rng: &mut ChaCha8Rng| rng.random_range(-1.0_f32..1.0);
        let node = Node::of([-2.0; 3], [1.0 / 64.0; 3], &boxes);
        let (centre, radius) = (point(1.0, rng), rng.random_range(-1.0..1.0));
        let (centre, radius) = if rng.random_bool(0.5) { (triangle[0], radius) } else { (centre, radius) };
        Self {
            axes,
            origin,
            direction,
            inverse,
            shear,
            extent,
            boxes,
            triangle,
            t_min,
            point: point(1.0, rng),
            node,
            centre,
            radius,
            key: number(rng),
            separators: std::array::from_fn(|_| number(rng)),
        }
    }

    /// A scene of small integers: rays along axes and diagonals, in faces and through corners; boxes that are flat or
    /// touched; triangles hit at edges and vertices, from behind and edge-on.
    pub fn lattice(rng: &mut ChaCha8Rng) -> Self {
        const DIRECTIONS: [f32; 9] = [1.0, -1.0, 2.0, -2.0, 0.5, -0.5, 0.0, -0.0, 1.0];
        let small = |rng: &mut ChaCha8Rng| one_of(&[-2.0, -1.0, -0.0, 0.0, 1.0, 2.0], rng);
        let origin = std::array::from_fn(|_| small(rng));
        let is_zero = rng.random_bool(0.16);
        let direction: Point =
            if is_zero { [0.0, -0.0, 0.0] } else { std::array::from_fn(|_| one_of(&DIRECTIONS, rng)) };
        let extent = match rng.random_range(0..20) {
            0..8 if is_zero => f32::NAN,
            0..11 => f32::INFINITY,
            11 => one_of(&[f32::NAN, -1.0, -0.0, f32::NEG_INFINITY], rng),
            _ => one_of(&[0.0, 1.0, 2.0, 3.0, 4.0], rng),
        };
        // All boxes of a job are near the ray, or all are random.
        let aimed = rng.random_bool(0.7);
        let boxes = std::array::from_fn(|_| if aimed { box_on_ray(origin, direction, rng) } else { random_box(rng) });
        let permutations = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0]];
        let shear = [small(rng), small(rng), one_of(&[1.0, -1.0, 0.5, 2.0], rng)];
        let triangle = std::array::from_fn(|_| std::array::from_fn(|_| small(rng)));
        let inverse = direction.map(|d| 1.0 / d);
        let scale = std::array::from_fn(|_| one_of(&[0.5, 1.0, 1.0, 2.0], rng));
        let node = Node::of(std::array::from_fn(|_| small(rng) - 4.0), scale, &boxes);
        let whole = |rng: &mut ChaCha8Rng| rng.random_range(-8_i32..=8) as f32;
        let separators = std::array::from_fn(|_| if rng.random_bool(0.1) { f32::INFINITY } else { whole(rng) });
        Self {
            axes: one_of(&permutations, rng),
            origin,
            direction,
            inverse,
            shear,
            extent,
            boxes,
            triangle,
            t_min: one_of(&[0.0, 0.0, -0.0, 0.5, 1.0, 2.0, -1.0, f32::NAN], rng),
            point: std::array::from_fn(|_| small(rng)),
            node,
            centre: std::array::from_fn(|_| small(rng)),
            radius: one_of(&[0.0, 1.0, 1.0, 2.0, -1.0, 0.5], rng),
            key: whole(rng),
            separators,
        }
    }
}

/// A box around a point of the ray.
fn box_on_ray(origin: Point, direction: Point, rng: &mut ChaCha8Rng) -> [Point; 2] {
    let distance = one_of(&[-1.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 4.0], rng);
    let centre: Point = std::array::from_fn(|i| origin[i] + distance * direction[i]);
    let reaches = if rng.random_bool(0.3) { [0.0, 0.0, 0.0, 1.0] } else { [0.0, 0.5, 1.0, 2.0] };
    let reach = |rng: &mut ChaCha8Rng| one_of(&reaches, rng);
    [std::array::from_fn(|i| centre[i] - reach(rng)), std::array::from_fn(|i| centre[i] + reach(rng))]
}

/// A random box; one in ten has its bounds exchanged.
fn random_box(rng: &mut ChaCha8Rng) -> [Point; 2] {
    let low: Point = std::array::from_fn(|_| one_of(&[-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0], rng));
    let high: Point = std::array::from_fn(|i| low[i] + one_of(&[0.0, 1.0, 2.0, 3.0], rng));
    if rng.random_bool(0.1) { [high, low] } else { [low, high] }
}

impl Node {
    /// The node of this place with the first four boxes as children, as far as it reaches.
    fn of(origin: Point, scale: Point, boxes: &[[Point; 2]; BOXES]) -> Self {
        let offset = |child: usize, axis: usize, bound: usize| {
            let units = (boxes[child][bound][axis] - origin[axis]) / scale[axis];
            if units.is_finite() { units.round().clamp(0.0, 255.0) as u64 } else { 0 }
        };
        let slab = |child, axis| [offset(child, axis, 0), offset(child, axis, 1)];
        let child = |child| [slab(child, 0), slab(child, 1), slab(child, 2)];
        Self { origin, scale, offsets: [child(0), child(1), child(2), child(3)] }
    }
}
