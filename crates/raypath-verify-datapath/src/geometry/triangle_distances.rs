//! Ray against triangle: the error of t = t_num / t_denom, the distance of the intersection.

use super::watertight::datapath;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_ops::{Binary32, Ray, RayTriangleOutput, Rounding, Rules};
use raypath_oracle::geometry::dyadic::{Dyadic, U, ulps_of, within_gamma};
use raypath_verify::campaign::{Campaign, Tally};
use raypath_verify::{Error, Request, Verdict};

/// One case of this many also runs on the wrong implementations.
const CONTROL_INTERVAL: u64 = 16;
/// The number of cases after which each wrong implementation must have been refuted.
const ENOUGH: u64 = 5_000;

/// Compares random rays and triangles with exact arithmetic, by the bounds of `docs/reference/error-bounds.md`.
pub fn verify(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let (rules, rounding) = (request.config.semantics.rules_in_full(), request.config.semantics.rounding);
    let cases = request.jobs.unwrap_or(request.level.pick(300_000, 5_000_000, 300_000_000));
    let (tally, is_stopped) =
        Campaign::new(2, cases).run_cases(request, |rng, tally| run(tally, rules, rounding, rng))?;
    Ok(verdict(tally, is_stopped))
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

#[derive(Debug, Clone, Copy)]
struct TriangleResult {
    t_num: f32,
    t_denom: f32,
    hit: bool,
}

impl TriangleResult {
    fn of(output: RayTriangleOutput<Binary32>) -> Self {
        Self { t_num: output.t_num.into(), t_denom: output.t_denom.into(), hit: output.triangle_hit.into() }
    }
}

/// Exact values, each multiplied by the power of the direction's largest component that avoids divisions.
#[derive(Default)]
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
        let mut exact = Self { dz: d[kz].abs(), depths, ..Self::default() };
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

/// Checks a random ray and triangle; in some cases also on the wrong implementations.
fn run(tally: &mut Tally, rules: Rules, rounding: Rounding, rng: &mut ChaCha8Rng) {
    let (ray, corners) = draw(rng);
    let exact = Exact::new(&ray, corners);
    check(tally, &exact, &ray, corners, TriangleResult::of(datapath(rules, rounding, &ray, corners)));
    if tally.count("checked").is_multiple_of(CONTROL_INTERVAL) {
        for (name, answer) in WRONG {
            let mut control = Tally::default();
            check(&mut control, &exact, &ray, corners, answer(&ray, corners));
            tally.add(name, control.failures());
        }
    }
}

fn check(tally: &mut Tally, exact: &Exact, ray: &Ray<Binary32>, corners: [[f32; 3]; 3], answer: TriangleResult) {
    tally.add("checked", true);
    let (num, denom) = (Dyadic::from(answer.t_num), Dyadic::from(answer.t_denom));
    let squared = &exact.dz * &exact.dz;
    let cubed = &squared * &exact.dz;
    let (off_denom, off_num) = ((&denom * &squared - &exact.area).abs(), (&num * &cubed - &exact.volume).abs());
    tally.add_value("t_denom in u", off_denom.to_f64() / exact.magnitude.to_f64() / U);
    tally.add_value("t_num in u", off_num.to_f64() / exact.magnitude_by_depth.to_f64() / U);
    let mut wrong = Vec::new();
    if !within_gamma(12, &off_denom, &exact.magnitude) {
        wrong.push("t_denom");
    }
    if !within_gamma(16, &off_num, &exact.magnitude_by_depth) {
        wrong.push("t_num");
    }
    if answer.hit && exact.area.sign().is_gt() && exact.depths.iter().all(|depth| depth.sign().is_gt()) {
        tally.add("hits", true);
        wrong.extend(check_range(tally, exact, &num, &denom));
        wrong.extend(check_quotient(tally, exact, answer));
    }
    if !wrong.is_empty() {
        let (origin, dir): ([f32; 3], [f32; 3]) = (ray.origin.into(), ray.dir.into());
        let wrong = wrong.join(", ");
        tally
            .fail(|| format!("{wrong} beyond the bound: ray from {origin:?} along {dir:?} at {corners:?}: {answer:?}"));
    }
}

/// The distance of a hit lies between those of the vertices, within γ₈.
fn check_range(tally: &mut Tally, exact: &Exact, num: &Dyadic, denom: &Dyadic) -> Option<&'static str> {
    let (t, [a, b, c]) = (num * &exact.dz, exact.depths.each_ref().map(|depth| depth * denom));
    let least = a.clone().min(b.clone()).min(c.clone());
    let greatest = a.max(b).max(c);
    let (below, above) = (&least - &t, &t - &greatest);
    tally.add_value("t outside in u", below.to_f64() / least.to_f64() / U);
    tally.add_value("t outside in u", above.to_f64() / greatest.to_f64() / U);
    (!within_gamma(8, &below, &least) || !within_gamma(8, &above, &greatest)).then_some("t outside the triangle")
}

/// |t − exact| ≤ γ₈ t + γ₁₁ (ΣM / t_denom) · max |z − t|.
fn check_quotient(tally: &mut Tally, exact: &Exact, answer: TriangleResult) -> Option<&'static str> {
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
    tally.add_value("t in ulps", ulps);
    tally.add_value("part of t's bound", off_ / (U * (8.0 * t_ + 11.0 * cancelled_)));
    // With little cancellation, the error is at most that of t's own roundings.
    if cancelled_ <= t_ {
        tally.add("hits with little cancellation", true);
        tally.add_value("t with little cancellation in ulps", ulps);
    }
    // γ₈ t + γ₁₁ c, multiplied by both denominators.
    let [eight, eleven] = [8, 11].map(|n| Dyadic::from((1 << 24) - n));
    let bound = Dyadic::from(8) * &eleven * &t + Dyadic::from(11) * &eight * &cancelled;
    (eight * eleven * &off > bound).then_some("t")
}

fn verdict(tally: Tally, is_stopped: bool) -> Verdict {
    let (checked, largest) = (tally.count("checked"), |name| tally.largest(name));
    let covered = format!("{checked} rays and triangles, {} hits", tally.count("hits"));
    let remarks = vec![
        format!(
            "t_denom: at most {:.2} u of the sum of magnitudes, bound 12; t_num: {:.2}, bound 16",
            largest("t_denom in u"),
            largest("t_num in u")
        ),
        format!("t of a hit is outside the vertices' distances by at most {:.2} u, bound 8", largest("t outside in u")),
        format!(
            "error of t: at most {:.2} ulps in {} hits with little cancellation, bound 19; at most {:.3} of its bound \
             and {:.1} ulps in all hits",
            largest("t with little cancellation in ulps"),
            tally.count("hits with little cancellation"),
            largest("part of t's bound"),
            largest("t in ulps")
        ),
    ];
    let label = format!("wrong results found in {} cases of each wrong implementation", checked / CONTROL_INTERVAL);
    tally.verdict(is_stopped, covered, remarks, (&label, WRONG.map(|(name, _)| name), checked >= ENOUGH))
}

/// A wrong implementation and its name.
type Named = (&'static str, fn(&Ray<Binary32>, [[f32; 3]; 3]) -> TriangleResult);

/// The negative control, wrong implementations: inputs and results with too few bits, and a missing factor.
const WRONG: [Named; 4] = [
    ("shear constants of 16 bits", |ray, corners| with_shear(ray, corners, |shear| shear.map(|x| truncate(x, 16)))),
    ("depths without the factor of the shear", |ray, corners| with_shear(ray, corners, |[x, y, _]| [x, y, 1.0])),
    ("t_num of 16 bits", |ray, corners| {
        let right = with_shear(ray, corners, |shear| shear);
        TriangleResult { t_num: truncate(right.t_num, 16), ..right }
    }),
    ("t_denom of 16 bits", |ray, corners| {
        let right = with_shear(ray, corners, |shear| shear);
        TriangleResult { t_denom: truncate(right.t_denom, 16), ..right }
    }),
];

/// The datapath's result for a ray with other shear constants.
fn with_shear(ray: &Ray<Binary32>, corners: [[f32; 3]; 3], shear: impl Fn([f32; 3]) -> [f32; 3]) -> TriangleResult {
    let ray = Ray { shear: shear(ray.shear.into()).into(), ..*ray };
    TriangleResult::of(datapath(Rules::Paper, Rounding::Unit, &ray, corners))
}

/// The number with a significand of `bits` bits, rounded towards zero.
pub fn truncate(number: f32, bits: u32) -> f32 {
    f32::from_bits(number.to_bits() >> (24 - bits) << (24 - bits))
}

#[cfg(test)]
mod tests {
    use super::{Exact, Tally, TriangleResult, check, datapath, draw, ulps_of};
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;
    use raypath_ops::{Ray, Rounding, Rules};

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
        let (mut right, mut wrong, mut hits) = (Tally::default(), Tally::default(), 0);
        for _ in 0..3000 {
            let (ray, corners) = draw(&mut rng);
            let answer = TriangleResult::of(datapath(Rules::Paper, Rounding::Unit, &ray, corners));
            let exact = Exact::new(&ray, corners);
            check(&mut right, &exact, &ray, corners, answer);
            let once = TriangleResult::of(datapath(Rules::Paper, Rounding::Sum, &ray, corners));
            check(&mut right, &exact, &ray, corners, once);
            if answer.hit {
                hits += 1;
                let t_num = answer.t_num * (1.0 + 1e-5);
                check(&mut wrong, &exact, &ray, corners, TriangleResult { t_num, ..answer });
            }
        }
        assert_eq!(right.failures(), 0, "{right:?}");
        assert!(hits > 500 && right.count("hits with little cancellation") > 100, "{hits} {right:?}");
        assert!(wrong.failures() > hits / 20, "{} of {hits}", wrong.failures());
    }
}
