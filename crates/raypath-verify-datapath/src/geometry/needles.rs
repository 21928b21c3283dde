//! Fans of needles: triangles so thin that edge functions are 0 after rounding, and not exactly.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_ops::{Binary32, Ray};

/// Triangles around a vertex in the plane z = 1, of which needles point at the z axis. It passes through one of them.
#[derive(Debug, Clone)]
pub struct Needles {
    vertex: [f32; 2],
    /// Counter-clockwise around the vertex.
    rim: Vec<[f32; 2]>,
}

impl Needles {
    /// A fan, unless it has a face of the wrong orientation, or the z axis is outside or in a face whose edge functions are
    /// all 0 after rounding, which is missed.
    pub fn draw(rng: &mut ChaCha8Rng) -> Option<Self> {
        let size = 2.0_f32.powi(rng.random_range(-8..=0));
        let vertex: [f32; 2] = std::array::from_fn(|_| size * rng.random_range(0.5_f32..1.0));
        let [x, y] = vertex;
        // Behind the axis, seen from the vertex.
        let count = rng.random_range(2..=5);
        let mut tips: Vec<[f32; 2]> = (0..count)
            .map(|_| {
                let away: f32 = -rng.random_range(0.5..32.0);
                vertex.map(|x| f32::from_bits((x * away).to_bits().wrapping_add_signed(rng.random_range(-3..=3))))
            })
            .collect();
        let sides = [[-4.0 * y, 4.0 * x], [4.0 * y, -4.0 * x]];
        let order = |a: &[f32; 2], b: &[f32; 2]| 0.cmp(&area(vertex, *a, *b));
        tips.sort_by(order);
        let mut rim = vec![sides[0]];
        rim.extend(tips);
        rim.extend([sides[1], [3.0 * x, 3.0 * y]]);
        let fan = Self { vertex, rim };
        let is_oriented = fan.edges().all(|[a, b]| area(vertex, a, b) > 0);
        let sides = |[a, b]: [[f32; 2]; 2]| [(vertex, a), (a, b), (b, vertex)];
        let contains = |edge: &[[f32; 2]; 2]| sides(*edge).into_iter().all(|(p, q)| area(p, q, [0.0; 2]) >= 0);
        let vanishes = |edge| sides(edge).into_iter().all(|(p, q)| p[0] * q[1] == p[1] * q[0]);
        let mut around = fan.edges().filter(contains).peekable();
        (is_oriented && around.peek().is_some() && !around.any(vanishes)).then(|| fan.clone())
    }

    /// The ray along the z axis, to which a coordinate of the plane is its sheared coordinate.
    pub fn ray() -> Ray<Binary32> {
        Ray::new([0.0; 3], [0.0, 0.0, 1.0], f32::INFINITY).expect("a direction")
    }

    /// The corners of the triangles, whose fronts the ray sees.
    pub fn faces(&self) -> impl Iterator<Item = [[f32; 3]; 3]> {
        self.edges().map(|[a, b]| [self.vertex, b, a].map(|[x, y]| [x, y, 1.0]))
    }

    /// The edges of the rim.
    fn edges(&self) -> impl Iterator<Item = [[f32; 2]; 2]> {
        (0..self.rim.len()).map(|place| [self.rim[place], self.rim[(place + 1) % self.rim.len()]])
    }
}

/// Twice the area of a triangle, in units of 2^-96, exactly; above 0 if it is counter-clockwise.
fn area(a: [f32; 2], b: [f32; 2], c: [f32; 2]) -> i128 {
    let [a, b, c] = [a, b, c].map(|point| point.map(|x| (f64::from(x) * 2.0_f64.powi(48)) as i128));
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}
