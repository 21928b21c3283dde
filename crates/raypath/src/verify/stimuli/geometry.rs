use crate::verify::layout::Field;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use raypath_ops::Ray;

type Point = [f32; 3];

/// A ray with all that comes along with it, four boxes and a triangle.
#[derive(Debug, Clone, Default)]
pub struct Geometry {
    /// kx, ky, kz.
    pub axes: [u64; 3],
    origin: Point,
    direction: Point,
    inverse: Point,
    shear: Point,
    extent: f32,
    /// Lower and upper corner.
    boxes: [[Point; 2]; 4],
    triangle: [Point; 3],
}

fn one_of<T: Copy>(values: &[T], rng: &mut ChaCha8Rng) -> T {
    values[rng.random_range(0..values.len())]
}

impl Geometry {
    /// The number in a field; 0 for what is no number of a ray, a box or a triangle.
    pub fn number(&self, field: Field) -> f32 {
        match field {
            Field::Origin(axis) => self.origin[axis],
            Field::Direction(axis) => self.direction[axis],
            Field::Inverse(axis) => self.inverse[axis],
            Field::Shear(axis) => self.shear[axis],
            Field::Extent => self.extent,
            Field::Bound { place, axis, is_max } => self.boxes[place][usize::from(is_max)][axis],
            Field::Vertex { vertex, axis } => self.triangle[vertex][axis],
            Field::Axis(_) | Field::Lane { .. } | Field::Mask | Field::Reset | Field::Unknown => 0.0,
        }
    }

    /// As a renderer makes them: a ray aimed at the triangle, and boxes around where it goes.
    pub fn scene(rng: &mut ChaCha8Rng) -> Self {
        let point = |reach: f32, rng: &mut ChaCha8Rng| std::array::from_fn(|_| rng.random_range(-reach..reach));
        let (origin, triangle): (Point, [Point; 3]) = (point(4.0, rng), std::array::from_fn(|_| point(1.0, rng)));
        let weights: Point = point(1.0, rng).map(|weight: f32| weight.abs() + 0.01);
        let sum: f32 = weights.iter().sum();
        let target = |i: usize| (0..3).map(|vertex| weights[vertex] * triangle[vertex][i]).sum::<f32>() / sum;
        let direction: Point = std::array::from_fn(|i| target(i) - origin[i]);
        let extent = if rng.random_bool(0.7) { f32::INFINITY } else { rng.random_range(0.0..2.0) };
        // A scene without a ray is replaced by a lattice.
        let Ok(ray) = Ray::new(origin, direction, extent) else { return Self::lattice(rng) };
        let boxes = std::array::from_fn(|_| {
            let (centre, half): (Point, Point) = (point(1.0, rng), point(1.0, rng));
            [std::array::from_fn(|i| centre[i] - half[i].abs()), std::array::from_fn(|i| centre[i] + half[i].abs())]
        });
        let axes = [ray.kx, ray.ky, ray.kz].map(|axis| u32::from(axis).into());
        let (inverse, shear) = (ray.inv.into(), ray.shear.into());
        Self { axes, origin, direction, inverse, shear, extent, boxes, triangle }
    }

    /// Everything on small whole numbers: rays along axes and diagonals, in faces and through corners, boxes that are
    /// flat or touched, triangles met at edges, vertices, from behind and edge-on.
    pub fn lattice(rng: &mut ChaCha8Rng) -> Self {
        const DIRECTIONS: [f32; 9] = [1.0, -1.0, 2.0, -2.0, 0.5, -0.5, 0.0, -0.0, 1.0];
        let small = |rng: &mut ChaCha8Rng| one_of(&[-2.0, -1.0, -0.0, 0.0, 1.0, 2.0], rng);
        let origin = std::array::from_fn(|_| small(rng));
        let is_still = rng.random_bool(0.12);
        let direction: Point =
            if is_still { [0.0, -0.0, 0.0] } else { std::array::from_fn(|_| one_of(&DIRECTIONS, rng)) };
        let extent = match rng.random_range(0..20) {
            0..6 if is_still => f32::NAN,
            0..11 => f32::INFINITY,
            11 => one_of(&[f32::NAN, -1.0, -0.0, f32::NEG_INFINITY], rng),
            _ => one_of(&[0.0, 1.0, 2.0, 3.0, 4.0], rng),
        };
        // Boxes of one job are alike in how they are met.
        let aimed = rng.random_bool(0.7);
        let boxes = std::array::from_fn(|_| if aimed { met(origin, direction, rng) } else { anywhere(rng) });
        let permutations = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0]];
        let shear = [small(rng), small(rng), one_of(&[1.0, -1.0, 0.5, 2.0], rng)];
        let triangle = std::array::from_fn(|_| std::array::from_fn(|_| small(rng)));
        let inverse = direction.map(|d| 1.0 / d);
        Self { axes: one_of(&permutations, rng), origin, direction, inverse, shear, extent, boxes, triangle }
    }
}

/// A box around a place that the ray comes by.
fn met(origin: Point, direction: Point, rng: &mut ChaCha8Rng) -> [Point; 2] {
    let place = one_of(&[-1.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 4.0], rng);
    let centre: Point = std::array::from_fn(|i| origin[i] + place * direction[i]);
    let reaches = if rng.random_bool(0.3) { [0.0, 0.0, 0.0, 1.0] } else { [0.0, 0.5, 1.0, 2.0] };
    let reach = |rng: &mut ChaCha8Rng| one_of(&reaches, rng);
    [std::array::from_fn(|i| centre[i] - reach(rng)), std::array::from_fn(|i| centre[i] + reach(rng))]
}

/// A box anywhere; few have their bounds exchanged.
fn anywhere(rng: &mut ChaCha8Rng) -> [Point; 2] {
    let low: Point = std::array::from_fn(|_| one_of(&[-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0], rng));
    let high: Point = std::array::from_fn(|i| low[i] + one_of(&[0.0, 1.0, 2.0, 3.0], rng));
    if rng.random_bool(0.1) { [high, low] } else { [low, high] }
}
