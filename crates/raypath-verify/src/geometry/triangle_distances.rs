//! Ray against triangle: the error of t = t_num / t_denom, the distance of the intersection.

use super::campaign::{self, Failures, Largest, add_controls, tally_of_fields};
use super::dyadic::{Dyadic, within_gamma};
use super::error_units::{U, ulps_of};
use super::implementations::datapath;
use super::wrong_distances::WRONG;
use crate::error::Error;
use crate::request::Request;
use crate::verdict::Verdict;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_ops::{Binary32, Ray, RayTriangleOutput, Rules};

/// One case of this many also runs on the wrong implementations.
const CONTROL_INTERVAL: u64 = 16;
/// The number of cases after which each wrong implementation must have been refuted.
const ENOUGH: u64 = 5_000;

/// Compares random rays and triangles with exact arithmetic, by the bounds of `docs/reference/error-bounds.md`.
pub fn verify(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let rules = request.config.semantics.rules;
    let cases = request.jobs.unwrap_or(request.level.pick(300_000, 10_000_000, 300_000_000));
    let (tally, is_stopped) =
        campaign::run(request, 2, cases, |rng, tally: &mut DistanceErrors| tally.run(rules, rng))?;
    Ok(tally.verdict(is_stopped))
}

/// A random triangle, and a ray at a point in or near it, from near or far, perpendicular or grazing.
fn draw(rng: &mut ChaCha8Rng) -> (Ray<Binary32>, [[f32; 3]; 3]) {
    loop {
        let size = rng.random_range(-8.0..4.0_f64).exp2();
        let centre: [f64; 3] = std::array::from_fn(|_| rng.random_range(-4.0..4.0));
        let mut corner = || -> [f64; 3] { std::array::from_fn(|i| centre[i] + size * rng.random_range(-1.0..1.0)) };
        let mut corners = [corner(), corner(), corner()];
        if rng.random_range(0..3) == 0 {
            // Perpendicular to an axis.
            let axis = rng.random_range(0..3);
            corners.iter_mut().for_each(|corner| corner[axis] = centre[axis]);
        }
        let [u, v, w]: [f64; 3] = std::array::from_fn(|_| rng.random_range(-0.1..1.0));
        let target: [f64; 3] =
            std::array::from_fn(|i| (u * corners[0][i] + v * corners[1][i] + w * corners[2][i]) / (u + v + w));
        let away = rng.random_range(-2.0..10.0_f64).exp2() * size;
        let origin = target.map(|x| (x + away * rng.random_range(-1.0..1.0)) as f32);
        let length = [1.0, 0.01, 300.0][rng.random_range(0..3)];
        let direction = std::array::from_fn(|i| ((target[i] - f64::from(origin[i])) * length) as f32);
        if let Ok(ray) = Ray::new(origin, direction, f32::INFINITY) {
            return (ray, corners.map(|corner| corner.map(|x| x as f32)));
        }
    }
}

/// The result of an implementation.
#[derive(Debug, Clone, Copy)]
pub struct TriangleResult {
    /// The numerator of the distance.
    pub t_num: f32,
    /// The denominator of the distance.
    pub t_denom: f32,
    /// Whether the ray hits the triangle.
    pub hit: bool,
}

impl TriangleResult {
    /// The datapath's result.
    pub fn of(output: RayTriangleOutput<Binary32>) -> Self {
        Self { t_num: output.t_num.into(), t_denom: output.t_denom.into(), hit: output.triangle_hit.into() }
    }
}

/// Exact values, each multiplied by the power of the direction's largest component that avoids divisions.
struct Exact {
    /// t_denom · dz²
    area: Dyadic,
    /// t_num · dz³
    volume: Dyadic,
    /// ΣM · dz²: the magnitudes of the operands of the differences U, V and W.
    magnitude: Dyadic,
    /// Σ M·|Az| · |dz|³
    magnitude_by_depth: Dyadic,
    /// Az, Bz, Cz, each times |dz|.
    depths: [Dyadic; 3],
    /// |dz|
    dz: Dyadic,
}

impl Exact {
    fn new(ray: &Ray<Binary32>, corners: [[f32; 3]; 3]) -> Self {
        let [kx, ky, kz] = [ray.kx, ray.ky, ray.kz].map(|k| u32::from(k) as usize);
        let (origin, d) = (<[f32; 3]>::from(ray.origin).map(Dyadic::from), <[f32; 3]>::from(ray.dir).map(Dyadic::from));
        let relative =
            corners.map(|corner| -> [Dyadic; 3] { std::array::from_fn(|i| Dyadic::from(corner[i]) - &origin[i]) });
        let sheared = |k: usize| relative.each_ref().map(|r| &r[k] * &d[kz] - &d[k] * &r[kz]);
        let reach = |k: usize| relative.each_ref().map(|r| (&r[k] * &d[kz]).abs() + (&d[k] * &r[kz]).abs());
        let (x, y, reach_x, reach_y) = (sheared(kx), sheared(ky), reach(kx), reach(ky));
        let forwards = d[kz].sign().is_gt();
        let depths = relative.each_ref().map(|r| if forwards { r[kz].clone() } else { -r[kz].clone() });
        let mut exact = Self {
            area: Dyadic::zero(),
            volume: Dyadic::zero(),
            magnitude: Dyadic::zero(),
            magnitude_by_depth: Dyadic::zero(),
            dz: d[kz].abs(),
            depths,
        };
        // U belongs to A and is computed from C and B; V and W likewise.
        for (of, p, q) in [(0, 2, 1), (1, 0, 2), (2, 1, 0)] {
            let edge = &x[p] * &y[q] - &y[p] * &x[q];
            let magnitude = &reach_x[p] * &reach_y[q] + &reach_y[p] * &reach_x[q];
            exact.volume = exact.volume + &edge * &exact.depths[of];
            exact.magnitude_by_depth = exact.magnitude_by_depth + &magnitude * &exact.depths[of].abs();
            exact.area = exact.area + edge;
            exact.magnitude = exact.magnitude + magnitude;
        }
        exact
    }
}

#[derive(Default)]
struct DistanceErrors {
    checked: u64,
    hits: u64,
    /// |t_denom − exact| and |t_num − exact|, in u·ΣM and u·ΣM|z|.
    denominator: Largest,
    numerator: Largest,
    /// By how much t is outside the range of the vertices' distances, relative to them, in u.
    outside: Largest,
    /// Hits with little cancellation: its error is at most that of t's own roundings. Their |t − exact| in ulps.
    benign: u64,
    benign_ulps: Largest,
    /// |t − exact| of all hits, relative to its bound, and in ulps.
    part_of_bound: Largest,
    ulps: Largest,
    /// Wrong results of each wrong implementation.
    refuted: [u64; WRONG.len()],
    failures: Failures,
}

impl DistanceErrors {
    /// Checks a random ray and triangle; in some cases also on the wrong implementations.
    fn run(&mut self, rules: Rules, rng: &mut ChaCha8Rng) {
        let (ray, corners) = draw(rng);
        let exact = Exact::new(&ray, corners);
        self.check(&exact, &ray, corners, TriangleResult::of(datapath(rules, &ray, corners)));
        if self.checked.is_multiple_of(CONTROL_INTERVAL) {
            for (refuted, (_, answer)) in self.refuted.iter_mut().zip(WRONG) {
                let mut control = Self::default();
                control.check(&exact, &ray, corners, answer(&ray, corners));
                *refuted += control.failures.count();
            }
        }
    }

    fn check(&mut self, exact: &Exact, ray: &Ray<Binary32>, corners: [[f32; 3]; 3], answer: TriangleResult) {
        self.checked += 1;
        let (num, denom) = (Dyadic::from(answer.t_num), Dyadic::from(answer.t_denom));
        let squared = &exact.dz * &exact.dz;
        let cubed = &squared * &exact.dz;
        let (off_denom, off_num) = ((&denom * &squared - &exact.area).abs(), (&num * &cubed - &exact.volume).abs());
        self.denominator.add(off_denom.to_f64() / exact.magnitude.to_f64() / U);
        self.numerator.add(off_num.to_f64() / exact.magnitude_by_depth.to_f64() / U);
        let mut wrong = Vec::new();
        if !within_gamma(12, &off_denom, &exact.magnitude) {
            wrong.push("t_denom");
        }
        if !within_gamma(16, &off_num, &exact.magnitude_by_depth) {
            wrong.push("t_num");
        }
        if answer.hit && exact.area.sign().is_gt() && exact.depths.iter().all(|depth| depth.sign().is_gt()) {
            self.hits += 1;
            wrong.extend(self.check_range(exact, &num, &denom));
            wrong.extend(self.check_quotient(exact, answer));
        }
        if !wrong.is_empty() {
            let (origin, dir): ([f32; 3], [f32; 3]) = (ray.origin.into(), ray.dir.into());
            self.failures.add(|| {
                format!(
                    "{} beyond the bound: ray from {origin:?} along {dir:?} at {corners:?}: {answer:?}",
                    wrong.join(", ")
                )
            });
        }
    }

    /// The distance of a hit lies between those of the vertices, within γ₈.
    fn check_range(&mut self, exact: &Exact, num: &Dyadic, denom: &Dyadic) -> Option<&'static str> {
        let (t, [a, b, c]) = (num * &exact.dz, exact.depths.each_ref().map(|depth| depth * denom));
        let least = a.clone().min(b.clone()).min(c.clone());
        let greatest = a.max(b).max(c);
        let (below, above) = (&least - &t, &t - &greatest);
        self.outside.add(below.to_f64() / least.to_f64() / U);
        self.outside.add(above.to_f64() / greatest.to_f64() / U);
        (!within_gamma(8, &below, &least) || !within_gamma(8, &above, &greatest)).then_some("t outside the triangle")
    }

    /// |t − exact| ≤ γ₈ t + γ₁₁ (ΣM / t_denom) · max |z − t|.
    fn check_quotient(&mut self, exact: &Exact, answer: TriangleResult) -> Option<&'static str> {
        let (num, denom) = (Dyadic::from(answer.t_num), Dyadic::from(answer.t_denom));
        // All values are multiplied by t_denom · area · |dz|³.
        let squared = &exact.dz * &exact.dz;
        let off = (&num * &exact.area * &exact.dz - &exact.volume * &denom).abs() * &squared;
        let t = &exact.volume * &denom * &squared;
        let spread = exact.depths.each_ref().map(|depth| (depth * &exact.area - &exact.volume).abs());
        let [a, b, c] = spread;
        let cancelled = &exact.magnitude * &a.max(b).max(c);
        let [off_, t_, cancelled_] = [&off, &t, &cancelled].map(Dyadic::to_f64);
        let ulps = off_ / t_ * ulps_of(exact.volume.to_f64() / exact.area.to_f64() / exact.dz.to_f64());
        self.ulps.add(ulps);
        self.part_of_bound.add(off_ / (U * (8.0 * t_ + 11.0 * cancelled_)));
        if cancelled_ <= t_ {
            self.benign += 1;
            self.benign_ulps.add(ulps);
        }
        // γ₈ t + γ₁₁ c, multiplied by both denominators.
        let [eight, eleven] = [8, 11].map(|n| Dyadic::from((1 << 24) - n));
        let bound = Dyadic::from(8) * &eleven * &t + Dyadic::from(11) * &eight * &cancelled;
        (eight * eleven * &off > bound).then_some("t")
    }

    fn verdict(self, is_stopped: bool) -> Verdict {
        let covered = format!("{} rays and triangles, {} hits", self.checked, self.hits);
        let remarks = vec![
            format!(
                "t_denom: at most {:.2} u of the sum of magnitudes, bound 12; t_num: {:.2}, bound 16",
                self.denominator.0, self.numerator.0
            ),
            format!("t of a hit is outside the vertices' distances by at most {:.2} u, bound 8", self.outside.0),
            format!(
                "error of t: at most {:.2} ulps in {} hits with little cancellation, bound 19; at most {:.3} of its \
                 bound and {:.1} ulps in all hits",
                self.benign_ulps.0, self.benign, self.part_of_bound.0, self.ulps.0
            ),
        ];
        let mut verdict = Verdict { covered, remarks, failures: self.failures.lines(), is_stopped };
        let tried = self.checked / CONTROL_INTERVAL;
        let label = format!("wrong results found in {tried} cases of each wrong implementation");
        let names = WRONG.map(|(name, _)| name);
        add_controls(&mut verdict, &label, names, self.refuted, self.checked >= ENOUGH);
        verdict
    }
}

tally_of_fields!(DistanceErrors {
    checked,
    hits,
    denominator,
    numerator,
    outside,
    benign,
    benign_ulps,
    part_of_bound,
    ulps,
    refuted,
    failures
});

#[cfg(test)]
mod tests {
    use super::super::implementations::datapath;
    use super::{DistanceErrors, Exact, TriangleResult, WRONG, draw, ulps_of};
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;
    use raypath_ops::{Ray, Rules};

    #[test]
    fn the_exact_values_are_right_where_they_are_known() {
        let ray = Ray::new([0.0; 3], [0.0, 0.0, 2.0], f32::INFINITY).expect("a ray");
        let exact = Exact::new(&ray, [[-1.0, -1.0, 2.0], [0.0, 1.0, 2.0], [1.0, -1.0, 2.0]]);
        // Twice the area 2, at the distance 1.
        let [area, volume] = [&exact.area, &exact.volume].map(super::Dyadic::to_f64);
        assert_eq!((area / 4.0, volume / 8.0), (4.0, 4.0));
        assert_eq!(ulps_of(1.0), 2_f64.powi(23));
        assert_eq!(ulps_of(1.5), 1.5 * 2_f64.powi(23));
    }

    /// Results with a few more roundings than the bounds allow are found.
    #[test]
    fn wrong_distances_are_found() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (mut right, mut wrong, mut hits) = (DistanceErrors::default(), DistanceErrors::default(), 0);
        for _ in 0..3000 {
            let (ray, corners) = draw(&mut rng);
            let output = datapath(Rules::Paper, &ray, corners);
            let (t_num, t_denom) = (f32::from(output.t_num), f32::from(output.t_denom));
            let hit: bool = output.triangle_hit.into();
            let exact = Exact::new(&ray, corners);
            right.check(&exact, &ray, corners, TriangleResult { t_num, t_denom, hit });
            if hit {
                hits += 1;
                wrong.check(&exact, &ray, corners, TriangleResult { t_num: t_num * (1.0 + 1e-5), t_denom, hit });
            }
        }
        assert_eq!(right.failures.lines(), Vec::<String>::new());
        assert!(hits > 500 && right.benign > 100, "{hits} {}", right.benign);
        assert!(wrong.failures.count() > hits / 20, "{} of {hits}", wrong.failures.count());
    }

    #[test]
    fn each_wrong_implementation_is_refuted() {
        let (mut errors, mut rng) = (DistanceErrors::default(), ChaCha8Rng::seed_from_u64(2));
        (0..3200).for_each(|_| errors.run(Rules::Paper, &mut rng));
        assert_eq!(errors.failures.lines(), Vec::<String>::new());
        for ((name, _), refuted) in WRONG.iter().zip(errors.refuted) {
            assert!(refuted > 0, "{name} is not refuted");
        }
    }
}
