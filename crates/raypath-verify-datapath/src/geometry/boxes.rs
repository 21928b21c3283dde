//! Ray against box: the hit is exact unless it depends on rounding, and tmin has an error of at most three roundings.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_model::Functional;
use raypath_ops::{Aabb, Binary32, BoxBits, Job, Outcome, Ray, RayBoxInput, RayBoxOutput, Rules};
use raypath_oracle::geometry::ExactIntersection;
use raypath_oracle::geometry::dyadic::{U, ulps_of};
use raypath_verify::campaign::{Campaign, Tally};
use raypath_verify::{Error, Request, Verdict};

/// The number of boxes after which each deliberate fault must have been found.
const ENOUGH: u64 = 40_000;

/// Compares random rays and boxes that touch or nearly touch with exact arithmetic.
pub fn verify(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let cases = request.jobs.unwrap_or(request.level.pick(100_000, 1_500_000, 50_000_000));
    let (tally, is_stopped) = Campaign::new(4, cases).run_cases(request, run)?;
    Ok(verdict(tally, is_stopped))
}

/// Whether the box is hit, and tmin.
type Answer = (bool, f32);

/// The datapath's result for each box.
fn datapath(rules: Rules, case: &Case) -> [Answer; 4] {
    let Outcome::Quadbox(output) = Functional::<16, 8>::new(rules).run(&job(case)) else {
        unreachable!("a quadbox job has a quadbox outcome")
    };
    by_index(&output)
}

fn job(case: &Case) -> Job {
    let aabb = case.boxes.map(|[low, high]| Aabb::new(low, high));
    Job::Quadbox(RayBoxInput { ray: case.ray, aabb })
}

/// The results in the order of the boxes in the job.
fn by_index(output: &RayBoxOutput<Binary32>) -> [Answer; 4] {
    let mut answers = [(false, 0.0); 4];
    for (rank, hit) in output.is_intersect.to_array().into_iter().enumerate() {
        answers[u32::from(output.box_index[rank]) as usize] = (hit, output.tmin[rank].into());
    }
    answers
}

/// A faulty implementation and its name.
type Named = (&'static str, fn(&Case) -> [Answer; 4]);

/// The faulty implementations that the campaign must find.
const FAULTY: [Named; 3] = [
    ("the original's comparisons", |case| datapath(Rules::Chisel, case)),
    ("inverses of 22 bits", |case| with_inverses(case, Rules::Paper, |_, inv| f32::from_bits(inv.to_bits() & !3))),
    ("slabs ignored that the ray runs along", |case| {
        with_inverses(case, Rules::Paper, |d, inv| if d == 0.0 { f32::NAN } else { inv })
    }),
];

/// The datapath's results for a ray with a different inverse direction.
fn with_inverses(case: &Case, rules: Rules, inverse: impl Fn(f32, f32) -> f32) -> [Answer; 4] {
    let (mut case, dir) = (*case, <[f32; 3]>::from(case.ray.dir));
    let inv = <[f32; 3]>::from(case.ray.inv);
    case.ray.inv = std::array::from_fn::<f32, 3, _>(|i| inverse(dir[i], inv[i])).into();
    datapath(rules, &case)
}

/// Checks the results for a random ray and four boxes.
fn run(rng: &mut ChaCha8Rng, tally: &mut Tally) {
    let case = draw(rng);
    let geometry = case.boxes.map(|aabb| ExactIntersection::new(&case.ray, aabb));
    check_outer(tally, &case, &geometry);
    let answers = datapath(Rules::Paper, &case);
    let faulty = FAULTY.map(|(name, fault)| (name, fault(&case)));
    for i in 0..4 {
        if geometry[i].is_out_of_range {
            tally.add("out of range", true);
            continue;
        }
        count(tally, &case, case.boxes[i], &geometry[i], answers[i]);
        if !is_right(&geometry[i], answers[i]) {
            let (origin, dir): ([f32; 3], [f32; 3]) = (case.ray.origin.into(), case.ray.dir.into());
            let (extent, aabb, answer) = (f32::from(case.ray.extent), case.boxes[i], answers[i]);
            let entry = geometry[i].entry.to_f64();
            tally.fail(|| {
                format!(
                    "ray from {origin:?} along {dir:?} to {extent:e}, box {aabb:?}: {answer:?}, exact entry {entry:e}"
                )
            });
        }
        faulty.iter().for_each(|&(name, ref answers)| tally.add(name, !is_right(&geometry[i], answers[i])));
    }
}

fn count(
    tally: &mut Tally,
    case: &Case,
    [low, high]: [[f32; 3]; 2],
    geometry: &ExactIntersection,
    (hit, tmin): Answer,
) {
    let (origin, dir) = (<[f32; 3]>::from(case.ray.origin), <[f32; 3]>::from(case.ray.dir));
    let some_axis = |is: &dyn Fn(usize) -> bool| (0..3).any(is);
    tally.add("checked", true);
    tally.add("flat", some_axis(&|i| low[i] == high[i]));
    tally.add("empty", some_axis(&|i| low[i] > high[i]));
    tally.add("along a slab", some_axis(&|i| dir[i] == 0.0));
    tally.add("in a plane", some_axis(&|i| dir[i] == 0.0 && (origin[i] == low[i] || origin[i] == high[i])));
    tally.add("touched", geometry.is_hit && geometry.gap == 0.0);
    tally.add("undetermined", geometry.required_hit.is_none());
    tally.add("hit", hit);
    tally.add("differing", hit != geometry.is_hit);
    // Relative errors have no meaning where distances underflow.
    let entry = geometry.entry.to_f64();
    let is_large = entry > 2_f64.powi(-120);
    if hit != geometry.is_hit && is_large {
        tally.add_value("gap", geometry.gap.abs() / U);
    }
    if hit && is_large {
        let off = geometry.entry.distance(tmin) / entry;
        tally.add_value("tmin in u", off / U);
        tally.add_value("tmin in ulps", off * ulps_of(entry));
    }
}

fn verdict(tally: Tally, is_stopped: bool) -> Verdict {
    let count = |name| tally.count(name);
    let covered = format!(
        "{} boxes, {} hit; {} touched in one point, {} flat, {} empty, {} with the ray along a slab, {} in its plane",
        count("checked"),
        count("hit"),
        count("touched"),
        count("flat"),
        count("empty"),
        count("along a slab"),
        count("in a plane")
    );
    let remarks = vec![
        format!(
            "error of tmin: at most {:.3} ulps, {:.3} u; bound 3",
            tally.largest("tmin in ulps"),
            tally.largest("tmin in u")
        ),
        format!(
            "within the rounding bound, so that either result is right: {} boxes, {} of them with another result than \
             exact arithmetic, at a gap of at most {:.3} u; bound 6",
            count("undetermined"),
            count("differing"),
            tally.largest("gap")
        ),
        format!("beyond the range of binary32, which the claim excludes: {} boxes", count("out of range")),
        format!(
            "rules bounds, 8 to 24 bits: {} boxes, {} entered by the exact ray, all of them hit; {} hit; a box hit but \
             not entered is missed by at most {:.2} units of the last bit; beyond the range that the claim excludes: {}",
            count("outer: checked"),
            count("outer: entered"),
            count("outer: hit"),
            tally.largest("outer: gap"),
            count("outer: out of range"),
        ),
    ];
    let is_enough = count("checked") >= ENOUGH;
    let [a, b, c] = FAULTY.map(|(name, _)| name);
    let [d, e, f] = OUTER.map(|(name, _)| name);
    let controls = ("wrong results of faulty implementations", [a, b, c, d, e, f], is_enough);
    tally.verdict(is_stopped, covered, remarks, controls)
}

/// Whether rounding allows a result.
fn is_right(geometry: &ExactIntersection, (hit, tmin): Answer) -> bool {
    geometry.required_hit.is_none_or(|required_hit| hit == required_hit) && (!hit || geometry.entry.may_round_to(tmin))
}

/// The answers for the four boxes of a case.
type Answering = fn(&Case, Rules) -> [Answer; 4];

/// The faulty implementations of the rules `bounds` that the campaign must find.
const OUTER: [(&str, Answering); 3] = [
    ("near bounds without the margin", |case, rules| moved(case, rules, 4)),
    ("far bounds lowered by 60 numbers", |case, rules| moved(case, rules, -64)),
    ("bounds rounded to nearest", |case, _| datapath(Rules::Paper, case)),
];

/// The results for inverses that are this many numbers farther from zero.
fn moved(case: &Case, rules: Rules, numbers: i32) -> [Answer; 4] {
    let is_inverse = |inv: f32| (2_f32.powi(-120)..2_f32.powi(120)).contains(&inv.abs());
    let moved = |inv: f32| if is_inverse(inv) { inv.to_bits().wrapping_add_signed(numbers) } else { inv.to_bits() };
    with_inverses(case, rules, |_, inv| f32::from_bits(moved(inv)))
}

/// Checks the results under the rules `bounds`, in a number of bits that follows from the case's numbers: a box that
/// the exact ray enters is hit, and tmin is a lower bound.
fn check_outer(tally: &mut Tally, case: &Case, geometry: &[ExactIntersection; 4]) {
    let numbers = <[f32; 3]>::from(case.ray.dir).into_iter().chain(case.boxes.into_iter().flatten().flatten());
    let digest = numbers.fold(1_u32, |digest, x| (digest ^ x.to_bits()).wrapping_mul(0x9e37_79b1).rotate_left(9));
    let bits = BoxBits::MIN.0 + digest % (BoxBits::MAX.0 - BoxBits::MIN.0 + 1);
    let rules = Rules::Bounds(BoxBits(bits));
    let (answers, faulty) = (datapath(rules, case), OUTER.map(|(name, fault)| (name, fault(case, rules))));
    for (i, of) in geometry.iter().enumerate() {
        if of.is_out_of_range || !is_in_range(case, case.boxes[i]) {
            tally.add("outer: out of range", true);
            continue;
        }
        let is_outer = |(hit, tmin): Answer| !of.is_hit || hit && of.entry.is_at_least(tmin);
        tally.add("outer: checked", true);
        tally.add("outer: entered", of.is_hit);
        tally.add("outer: hit", answers[i].0);
        if !is_outer(answers[i]) {
            let entry = of.entry.to_f64();
            tally.fail(|| format!("{case:?}, box {i} in {bits} bits: {:?}, exact entry {entry:e}", answers[i]));
        }
        // The interval grows by at most six roundings. Relative errors have no meaning where distances underflow.
        if answers[i].0 && !of.is_hit && of.gap.is_finite() && of.entry.to_f64() > 2_f64.powi(-120) {
            tally.add_value("outer: gap", of.gap.abs() * 2_f64.powi(bits as i32 - 1));
        }
        faulty.iter().for_each(|(name, answers)| tally.add(*name, !is_outer(answers[i])));
    }
}

/// Whether the claim's conditions hold: no difference underflows or overflows, and no inverse is flushed to zero.
fn is_in_range(case: &Case, [low, high]: [[f32; 3]; 2]) -> bool {
    let [origin, dir, inv] = [case.ray.origin, case.ray.dir, case.ray.inv].map(<[f32; 3]>::from);
    (0..3).all(|axis| {
        let differences = [low, high].map(|bound| f64::from(bound[axis]) - f64::from(origin[axis]));
        let is_difference = |x: f64| x == 0.0 || (2_f64.powi(-125)..2_f64.powi(127)).contains(&x.abs());
        let is_inverse = dir[axis] == 0.0 || (2_f32.powi(-124)..2_f32.powi(126)).contains(&inv[axis].abs());
        differences.into_iter().all(is_difference) && is_inverse
    })
}

/// A ray and four boxes, each as its lower and upper corner.
#[derive(Debug, Clone, Copy)]
struct Case {
    ray: Ray<Binary32>,
    boxes: [[[f32; 3]; 2]; 4],
}

/// The magnitudes of directions' components whose inverses are normal numbers.
const INVERTIBLE: std::ops::RangeInclusive<f32> = f32::from_bits(1 << 23)..=f32::from_bits(253 << 23);

/// A random case: rays in faces, along edges and through corners, along axes with ±0, from far away; boxes that are
/// flat, empty or around the origin; extents near the box's entry.
fn draw(rng: &mut ChaCha8Rng) -> Case {
    loop {
        let numbers = Numbers::draw(rng);
        let mut origin: [f32; 3] = std::array::from_fn(|_| (numbers.size * numbers.coordinate(rng)) as f32);
        if rng.random_range(0..8) == 0 {
            origin = origin.map(|x| x * 2_f32.powi(20));
        }
        let direction: [f32; 3] = std::array::from_fn(|_| (numbers.length * numbers.component(rng)) as f32);
        if direction.iter().any(|d| *d != 0.0 && !INVERTIBLE.contains(&d.abs())) {
            continue;
        }
        let reach = [0.0, 0.5, 1.0, 1.0, 3.0, -1.0][rng.random_range(0..6)] * numbers.size / numbers.length;
        let extent = extent(rng, reach);
        let Ok(ray) = Ray::new(origin, direction, extent) else { continue };
        let boxes = std::array::from_fn(|i| {
            let reach = if i < 2 { reach } else { reach * rng.random_range(0.0..2.0) };
            numbers.aabb(rng, origin, direction, reach)
        });
        return Case { ray, boxes };
    }
}

/// The numbers that a case is made of.
struct Numbers {
    /// Whether they are small multiples of 1/2 and powers of two, so that no operation rounds.
    lattice: bool,
    /// The unit of coordinates.
    size: f64,
    /// The unit of the direction's components.
    length: f64,
}

impl Numbers {
    fn draw(rng: &mut ChaCha8Rng) -> Self {
        let is_wide = rng.random_range(0..4) == 0;
        let mut power = |low: i32, high: i32| if is_wide { f64::from(rng.random_range(low..high)).exp2() } else { 1.0 };
        let (size, length) = (power(-100, 60), power(-60, 100));
        Self { lattice: rng.random_range(0..4) == 0, size, length }
    }

    fn coordinate(&self, rng: &mut ChaCha8Rng) -> f64 {
        if self.lattice { f64::from(rng.random_range(-8..=8)) / 2.0 } else { rng.random_range(-4.0..4.0) }
    }

    fn component(&self, rng: &mut ChaCha8Rng) -> f64 {
        let size = match rng.random_range(0..16) {
            0..3 => 0.0,
            3 => rng.random_range(-40.0..-10.0_f64).exp2(),
            _ if self.lattice => [0.5, 1.0, 2.0, 4.0][rng.random_range(0..4)],
            _ => rng.random_range(0.01..4.0),
        };
        if rng.random() { -size } else { size }
    }

    /// A box near the ray's point at the distance `reach`. The point lies in some of the box's faces, so that the ray
    /// enters or leaves there, touches an edge or corner, or runs in a face.
    fn aabb(&self, rng: &mut ChaCha8Rng, origin: [f32; 3], direction: [f32; 3], reach: f64) -> [[f32; 3]; 2] {
        let slabs: [[f32; 2]; 3] = std::array::from_fn(|axis| {
            let at = (f64::from(origin[axis]) + reach * f64::from(direction[axis])) as f32;
            let mut beside = || (self.size * self.coordinate(rng).abs()) as f32;
            let (below, above) = (at - beside(), at + beside());
            let [low, high] = match rng.random_range(0..6) {
                0 | 1 => [at, above],
                2 | 3 => [below, at],
                4 => [below, above],
                _ => [above, above + (self.size * rng.random_range(0.0..1.0)) as f32],
            };
            match rng.random_range(0..16) {
                0 | 1 => [low, low],
                2 => [high, low],
                _ => [low, high],
            }
        });
        [slabs.map(|[low, _]| low), slabs.map(|[_, high]| high)]
    }
}

/// A random extent: infinity, near the distance `reach`, or any.
fn extent(rng: &mut ChaCha8Rng, reach: f64) -> f32 {
    let about = (reach.abs() as f32).max(0.0);
    match rng.random_range(0..8) {
        0 => f32::from_bits(about.to_bits() + rng.random_range(0..4)),
        1 => f32::from_bits(about.to_bits().saturating_sub(rng.random_range(0..4))),
        2 => [0.0, f32::MAX, f32::MIN_POSITIVE][rng.random_range(0..3)],
        3 => about * rng.random_range(0.0..4.0),
        _ => f32::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::{FAULTY, OUTER, Tally, run};
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;

    /// The campaign passes the datapath, finds each deliberate fault, and has cases of every kind.
    #[test]
    fn faults_are_found() {
        let (mut tally, mut rng) = (Tally::default(), ChaCha8Rng::seed_from_u64(5));
        (0..5000).for_each(|_| run(&mut rng, &mut tally));
        for (name, least) in FAULTY.map(|(name, _)| (name, 50)).into_iter().chain(OUTER.map(|(name, _)| (name, 3))) {
            assert!(tally.count(name) > least, "{name}: {tally:?}");
        }
        for kind in ["hit", "undetermined", "flat", "empty", "along a slab", "in a plane", "touched"] {
            assert!(tally.count(kind) > 150, "{kind}: {tally:?}");
        }
        assert!(tally.count("differing") > 10 && tally.count("checked") > 19_000, "{tally:?}");
        assert!(tally.largest("tmin in u") > 1.5 && tally.largest("gap") > 1.0, "{tally:?}");
        assert_eq!(tally.failures(), 0, "{tally:?}");
    }
}
