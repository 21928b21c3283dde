//! Ray against box: the hit is exact unless it depends on rounding, and tmin has an error of at most three roundings.

use super::box_cases::{Case, draw};
use super::box_intersection::ExactIntersection;
use super::campaign::{self, Tally};
use super::dyadic::{U, ulps_of};
use crate::error::Error;
use crate::request::Request;
use crate::verdict::Verdict;
use rand::rngs::ChaCha8Rng;
use raypath_model::Functional;
use raypath_ops::{Aabb, Job, Outcome, RayBoxInput, Rules};

/// The number of boxes after which each deliberate fault must have been found.
const ENOUGH: u64 = 40_000;

/// Compares random rays and boxes that touch or nearly touch with exact arithmetic.
pub fn verify(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let cases = request.jobs.unwrap_or(request.level.pick(100_000, 3_000_000, 50_000_000));
    let (blocks, is_stopped) = campaign::run(request, 4, cases, run)?;
    Ok(verdict(Tally::joined(blocks), is_stopped))
}

/// Whether the box is hit, and tmin.
type Answer = (bool, f32);

/// The datapath's result for each box.
fn datapath(rules: Rules, case: &Case) -> [Answer; 4] {
    let aabb = case.boxes.map(|[low, high]| Aabb::new(low, high));
    let Outcome::Quadbox(output) =
        Functional::<16, 8>::new(rules).run(&Job::Quadbox(RayBoxInput { ray: case.ray, aabb }))
    else {
        unreachable!("a quadbox job has a quadbox outcome")
    };
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
    ("inverses of 22 bits", |case| with_inverses(case, |_, inv| f32::from_bits(inv.to_bits() & !3))),
    ("slabs ignored that the ray runs along", |case| {
        with_inverses(case, |d, inv| if d == 0.0 { f32::NAN } else { inv })
    }),
];

/// The datapath's results for a ray with a different inverse direction.
fn with_inverses(case: &Case, inverse: impl Fn(f32, f32) -> f32) -> [Answer; 4] {
    let (mut case, dir) = (*case, <[f32; 3]>::from(case.ray.dir));
    let inv = <[f32; 3]>::from(case.ray.inv);
    case.ray.inv = std::array::from_fn::<f32, 3, _>(|i| inverse(dir[i], inv[i])).into();
    datapath(Rules::Paper, &case)
}

/// Checks the results for a random ray and four boxes.
fn run(rng: &mut ChaCha8Rng, tally: &mut Tally) {
    let case = draw(rng);
    let geometry = case.boxes.map(|aabb| ExactIntersection::new(&case.ray, aabb));
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
    ];
    let is_enough = count("checked") >= ENOUGH;
    let controls = ("wrong results of faulty implementations", FAULTY.map(|(name, _)| name), is_enough);
    tally.verdict(is_stopped, covered, remarks, controls)
}

/// Whether rounding allows a result.
fn is_right(geometry: &ExactIntersection, (hit, tmin): Answer) -> bool {
    geometry.required_hit.is_none_or(|required_hit| hit == required_hit) && (!hit || geometry.entry.may_round_to(tmin))
}

#[cfg(test)]
mod tests {
    use super::{FAULTY, Tally, run};
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;

    /// The campaign passes the datapath, finds each deliberate fault, and has cases of every kind.
    #[test]
    fn faults_are_found() {
        let (mut tally, mut rng) = (Tally::default(), ChaCha8Rng::seed_from_u64(5));
        (0..2500).for_each(|_| run(&mut rng, &mut tally));
        for (name, _) in FAULTY {
            assert!(tally.count(name) > 50, "{name}: {tally:?}");
        }
        for kind in ["hit", "undetermined", "flat", "empty", "along a slab", "in a plane", "touched"] {
            assert!(tally.count(kind) > 150, "{kind}: {tally:?}");
        }
        assert!(tally.count("differing") > 10 && tally.count("checked") > 9_500, "{tally:?}");
        assert!(tally.largest("tmin in u") > 1.5 && tally.largest("gap") > 1.0, "{tally:?}");
        assert_eq!(tally.failures(), 0, "{tally:?}");
    }
}
