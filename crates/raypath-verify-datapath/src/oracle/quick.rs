//! The operations of Table VII by the rules `paper` of `docs/reference/semantics.md`, with 16 lanes in binary32,
//! implemented independently from the text: in binary64, with each operation rounded once. It is for more jobs than the
//! exact oracle can run.
//!
//! Why one rounding: binary64 has 53 ≥ 2·24 + 2 bits, so that rounding a sum, difference or product of binary32 numbers
//! first to 53 and then to 24 bits gives the same as rounding once. If the result is subnormal, the binary64 one is
//! exact (products have 48 bits, and sums that small are multiples of 2^-149).

use raypath_ops::{
    AngularOutput, Beat, BeatInput, Binary32, EuclideanOutput, Flags, Job, Num, Outcome, RayBoxInput, RayBoxOutput,
    RayTriangleInput, RayTriangleOutput, Word,
};

/// The sum, rounded once.
pub fn add(a: f32, b: f32) -> f32 {
    (f64::from(a) + f64::from(b)) as f32
}

/// The difference, rounded once.
pub fn sub(a: f32, b: f32) -> f32 {
    (f64::from(a) - f64::from(b)) as f32
}

/// The product, rounded once.
pub fn mul(a: f32, b: f32) -> f32 {
    (f64::from(a) * f64::from(b)) as f32
}

/// The operations by rules `paper`, with their accumulators.
#[derive(Debug, Clone, Copy, Default)]
pub struct Oracle {
    euclidean: f32,
    dot_product: f32,
    norm: f32,
}

impl Oracle {
    /// The expected outcome of a job. A beat leaves its sum in the accumulator.
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

    fn euclidean(&mut self, input: &BeatInput<Binary32, 16>) -> Outcome {
        let Beat { a, b, mask, reset_accum } = input.euclidean;
        let lane = |i: usize| if bool::from(mask.0[i]) { sub(a[i].into(), b[i].into()) } else { 0.0 };
        let squares: [f32; 16] = std::array::from_fn(|i| mul(lane(i), lane(i)));
        let sum = add(self.euclidean, halving_tree(squares));
        self.euclidean = if reset_accum.into() { 0.0 } else { sum };
        Outcome::Euclidean(EuclideanOutput { euclidean_accumulator: sum.into(), euclidean_reset_accum: reset_accum })
    }

    fn angular(&mut self, input: &BeatInput<Binary32, 8>) -> Outcome {
        let Beat { a, b, mask, reset_accum } = input.euclidean;
        let lane = |v: [Num<Binary32>; 8], i: usize| if bool::from(mask.0[i]) { f32::from(v[i]) } else { 0.0 };
        let dots: [f32; 8] = std::array::from_fn(|i| mul(lane(a, i), lane(b, i)));
        let squares: [f32; 8] = std::array::from_fn(|i| mul(lane(b, i), lane(b, i)));
        let (dot, norm) = (add(self.dot_product, halving_tree(dots)), add(self.norm, halving_tree(squares)));
        (self.dot_product, self.norm) = if reset_accum.into() { (0.0, 0.0) } else { (dot, norm) };
        Outcome::Angular(AngularOutput {
            angular_dot_product: dot.into(),
            angular_norm: norm.into(),
            angular_reset_accum: reset_accum,
        })
    }
}

/// Adds lanes i and i + w/2 until one sum is left.
fn halving_tree<const N: usize>(mut lanes: [f32; N]) -> f32 {
    let mut width = N;
    while width > 1 {
        width /= 2;
        for i in 0..width {
            lanes[i] = add(lanes[i], lanes[i + width]);
        }
    }
    lanes[0]
}

/// The intermediate values of the triangle operation that the hit rules read.
#[derive(Debug, Clone, Copy)]
pub struct TriangleSteps {
    /// The edge function of BC.
    pub u: f32,
    /// The edge function of CA.
    pub v: f32,
    /// The edge function of AB.
    pub w: f32,
    /// The numerator of the distance.
    pub t_num: f32,
    /// The denominator of the distance.
    pub t_denom: f32,
}

impl TriangleSteps {
    /// Computes the triangle column of Table VII.
    pub fn of(input: &RayTriangleInput<Binary32>) -> Self {
        let RayTriangleInput { ray, triangle } = input;
        let origin: [f32; 3] = ray.origin.into();
        let [sx, sy, sz]: [f32; 3] = ray.shear.into();
        // An axis index of 3 reads z (rule 8).
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

    /// The hit by rule 6.
    pub fn hit_by_paper(self) -> bool {
        let Self { u, v, w, t_num, t_denom } = self;
        let any_nan = [u, v, w, t_num, t_denom].iter().any(|x| x.is_nan());
        !any_nan && u >= 0.0 && v >= 0.0 && w >= 0.0 && t_denom != 0.0 && t_num > 0.0
    }

    /// The hit by rule 6 of `chisel`.
    pub fn hit_by_chisel(self) -> bool {
        let Self { u, v, w, t_num, t_denom } = self;
        !(u < 0.0 || v < 0.0 || w < 0.0 || t_num < 0.0) && t_denom != 0.0
    }
}

/// The ray-box operation, by rules 1 to 5.
fn quadbox_by_paper(input: &RayBoxInput<Binary32>) -> Outcome {
    let origin: [f32; 3] = input.ray.origin.into();
    let inv: [f32; 3] = input.ray.inv.into();
    let extent = f32::from(input.ray.extent);
    let mut entries: [(bool, f32, usize); 4] = std::array::from_fn(|index| {
        let aabb = input.aabb[index];
        let (mut nears, mut fars) = ([0.0; 4], [extent; 4]);
        for (axis, slab) in [aabb.x, aabb.y, aabb.z].into_iter().enumerate() {
            let distance = |bound: Num<Binary32>| mul(sub(bound.into(), origin[axis]), inv[axis]);
            let (near, far) = (distance(slab.min), distance(slab.max));
            let swap = inv[axis].is_sign_negative();
            nears[axis] = if swap { far } else { near };
            fars[axis] = if swap { near } else { far };
        }
        let is_number = |x: &f32| !x.is_nan();
        let tmin = nears.into_iter().filter(is_number).fold(0.0, |a: f32, b| if b > a { b } else { a });
        let tmax = fars.into_iter().filter(is_number).reduce(|a, b| if b < a { b } else { a });
        let hit = tmax.is_some_and(|tmax| tmin <= tmax);
        (hit, if hit { tmin } else { f32::INFINITY }, index)
    });
    // Hits first. No distance is NaN or negative.
    entries.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    Outcome::Quadbox(RayBoxOutput {
        is_intersect: Flags::new(std::array::from_fn(|i| entries[i].0)),
        tmin: std::array::from_fn(|i| entries[i].1.into()),
        box_index: std::array::from_fn(|i| Word::truncate(entries[i].2 as u32)),
    })
}
