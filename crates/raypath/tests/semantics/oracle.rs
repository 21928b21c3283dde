//! Table VII and the rules of `docs/semantics.md`, written once more, from the text: each operation in binary64 and rounded once.
//!
//! Why one rounding: binary64 has 53 ≥ 2·24 + 2 bits, so that rounding a sum, difference or product of binary32 numbers
//! first to 53 and then to 24 bits gives what rounding once gives. Where the result is subnormal the binary64 one is
//! exact (products have 48 bits, and sums that small are multiples of 2^-149).

use raypath::ops::{
    AngularInput, AngularOutput, Beat, Binary32, EuclideanInput, EuclideanOutput, Flags, Job, Num, Outcome,
    RayBoxInput, RayBoxOutput, RayTriangleInput, RayTriangleOutput, Word,
};

pub fn add(a: f32, b: f32) -> f32 {
    (f64::from(a) + f64::from(b)) as f32
}

pub fn sub(a: f32, b: f32) -> f32 {
    (f64::from(a) - f64::from(b)) as f32
}

pub fn mul(a: f32, b: f32) -> f32 {
    (f64::from(a) * f64::from(b)) as f32
}

/// The datapath by rules `paper`, job by job.
#[derive(Default)]
pub struct Oracle {
    euclidean: f32,
    dot_product: f32,
    norm: f32,
}

impl Oracle {
    pub fn run(&mut self, job: &Job) -> Outcome {
        match job {
            Job::Triangle(input) => {
                let steps = TriangleSteps::of(input);
                Outcome::Triangle(RayTriangleOutput {
                    t_num: steps.t_num.into(),
                    t_denom: steps.t_denom.into(),
                    triangle_hit: steps.hit_by_paper().into(),
                })
            }
            Job::Quadbox(input) => quadbox_by_paper(input),
            Job::Euclidean(input) => self.euclidean(input),
            Job::Angular(input) => self.angular(input),
        }
    }

    fn euclidean(&mut self, input: &EuclideanInput<Binary32, 16>) -> Outcome {
        let Beat { a, b, mask, reset_accum } = input.euclidean;
        let lane = |i: usize| if bool::from(mask.0[i]) { sub(a[i].into(), b[i].into()) } else { 0.0 };
        let squares = (0..16).map(|i| mul(lane(i), lane(i))).collect();
        let sum = add(self.euclidean, halving_tree(squares));
        self.euclidean = if reset_accum.into() { 0.0 } else { sum };
        Outcome::Euclidean(EuclideanOutput { euclidean_accumulator: sum.into(), euclidean_reset_accum: reset_accum })
    }

    fn angular(&mut self, input: &AngularInput<Binary32, 8>) -> Outcome {
        let Beat { a, b, mask, reset_accum } = input.euclidean;
        let lane = |v: [Num<Binary32>; 8], i: usize| if bool::from(mask.0[i]) { f32::from(v[i]) } else { 0.0 };
        let dots = (0..8).map(|i| mul(lane(a, i), lane(b, i))).collect();
        let squares = (0..8).map(|i| mul(lane(b, i), lane(b, i))).collect();
        let (dot, norm) = (add(self.dot_product, halving_tree(dots)), add(self.norm, halving_tree(squares)));
        (self.dot_product, self.norm) = if reset_accum.into() { (0.0, 0.0) } else { (dot, norm) };
        Outcome::Angular(AngularOutput {
            angular_dot_product: dot.into(),
            angular_norm: norm.into(),
            angular_reset_accum: reset_accum,
        })
    }
}

/// Lane i + lane i + w/2 until one is left.
fn halving_tree(lanes: Vec<f32>) -> f32 {
    if lanes.len() == 1 {
        return lanes[0];
    }
    let (low, high) = lanes.split_at(lanes.len() / 2);
    halving_tree(low.iter().zip(high).map(|(&a, &b)| add(a, b)).collect())
}

/// The values of the triangle column that a rule reads.
#[derive(Debug, Clone, Copy)]
pub struct TriangleSteps {
    pub u: f32,
    pub v: f32,
    pub w: f32,
    pub t_num: f32,
    pub t_denom: f32,
}

impl TriangleSteps {
    pub fn of(input: &RayTriangleInput<Binary32>) -> Self {
        let RayTriangleInput { ray, triangle } = input;
        let origin: [f32; 3] = ray.origin.into();
        let [sx, sy, sz]: [f32; 3] = ray.shear.into();
        // An axis index of 3 reads z (ruling 8).
        let [kx, ky, kz] = [ray.kx, ray.ky, ray.kz].map(|k: Word<Binary32, 2>| (u32::from(k) as usize).min(2));
        let sheared = |vertex: [f32; 3]| {
            let p: [f32; 3] = std::array::from_fn(|axis| sub(vertex[axis], origin[axis]));
            [sub(p[kx], mul(sx, p[kz])), sub(p[ky], mul(sy, p[kz])), mul(sz, p[kz])]
        };
        let [a, b, c] = [triangle.a, triangle.b, triangle.c].map(|vertex| sheared(vertex.into()));
        let u = sub(mul(c[0], b[1]), mul(c[1], b[0]));
        let v = sub(mul(a[0], c[1]), mul(a[1], c[0]));
        let w = sub(mul(b[0], a[1]), mul(b[1], a[0]));
        let t_denom = add(add(u, v), w);
        let t_num = add(add(mul(u, a[2]), mul(v, b[2])), mul(w, c[2]));
        Self { u, v, w, t_num, t_denom }
    }

    /// Ruling 6.
    pub fn hit_by_paper(self) -> bool {
        let Self { u, v, w, t_num, t_denom } = self;
        let any_nan = [u, v, w, t_num, t_denom].iter().any(|x| x.is_nan());
        !any_nan && u >= 0.0 && v >= 0.0 && w >= 0.0 && t_denom != 0.0 && t_num > 0.0
    }

    /// The original (NOTES.md, Triangle).
    pub fn hit_by_chisel(self) -> bool {
        let Self { u, v, w, t_num, t_denom } = self;
        !(u < 0.0 || v < 0.0 || w < 0.0 || t_num < 0.0) && t_denom != 0.0
    }
}

/// Rulings 1 to 5.
fn quadbox_by_paper(input: &RayBoxInput<Binary32>) -> Outcome {
    let origin: [f32; 3] = input.ray.origin.into();
    let inv: [f32; 3] = input.ray.inv.into();
    let mut places: Vec<(bool, f32, usize)> = (0..4)
        .map(|index| {
            let aabb = input.aabb[index];
            let (mut nears, mut fars) = (vec![0.0], vec![f32::from(input.ray.extent)]);
            for (axis, slab) in [aabb.x, aabb.y, aabb.z].into_iter().enumerate() {
                let distance = |bound: Num<Binary32>| mul(sub(bound.into(), origin[axis]), inv[axis]);
                let (near, far) = (distance(slab.min), distance(slab.max));
                let swap = inv[axis].is_sign_negative();
                nears.push(if swap { far } else { near });
                fars.push(if swap { near } else { far });
            }
            let is_number = |x: &f32| !x.is_nan();
            let tmin = nears.into_iter().filter(is_number).fold(0.0, |a: f32, b| if b > a { b } else { a });
            let tmax = fars.into_iter().filter(is_number).reduce(|a, b| if b < a { b } else { a });
            let hit = tmax.is_some_and(|tmax| tmin <= tmax);
            (hit, if hit { tmin } else { f32::INFINITY }, index)
        })
        .collect();
    places.sort_by(|a, b| (!a.0, a.1, a.2).partial_cmp(&(!b.0, b.1, b.2)).expect("no distance is a NaN"));
    Outcome::Quadbox(RayBoxOutput {
        is_intersect: Flags::new(std::array::from_fn(|i| places[i].0)),
        tmin: std::array::from_fn(|i| places[i].1.into()),
        box_index: std::array::from_fn(|i| Word::truncate(places[i].2 as u32)),
    })
}
