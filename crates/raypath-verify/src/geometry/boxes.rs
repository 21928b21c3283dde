//! Ray against box: the hit is exact unless it depends on rounding, and tmin has an error of at most three roundings.

use super::box_cases::{Case, draw};
use super::box_intersection::ExactIntersection;
use super::campaign::{self, Failures, Largest, add_controls, tally_of_fields};
use super::error_units::{U, ulps_of};
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
    let (tally, is_stopped) = campaign::run(request, 4, cases, |rng, tally: &mut Boxes| tally.run(rng))?;
    Ok(tally.verdict(is_stopped))
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

#[derive(Default)]
struct Boxes {
    checked: u64,
    hits: u64,
    /// Boxes whose hit may depend on rounding, and those of them with another result than exact arithmetic.
    undetermined: u64,
    differing: u64,
    /// Boxes with distances beyond the range of binary32, which the claim excludes.
    out_of_range: u64,
    flat: u64,
    empty: u64,
    /// Boxes with a slab that the ray runs along, and those of them with the ray in the slab's plane.
    along: u64,
    in_plane: u64,
    /// Boxes that the ray touches in exactly one point.
    touched: u64,
    /// The error of tmin, and the largest gap in u of a box with a differing result.
    tmin_ulps: Largest,
    tmin_units: Largest,
    gap: Largest,
    /// Wrong results of each faulty implementation.
    found: [u64; FAULTY.len()],
    failures: Failures,
}

impl Boxes {
    /// Checks the results for a random ray and four boxes.
    fn run(&mut self, rng: &mut ChaCha8Rng) {
        let case = draw(rng);
        let geometry = case.boxes.map(|aabb| ExactIntersection::new(&case.ray, aabb));
        let answers = datapath(Rules::Paper, &case);
        let faulty = FAULTY.map(|(_, fault)| fault(&case));
        for i in 0..4 {
            if geometry[i].is_out_of_range {
                self.out_of_range += 1;
                continue;
            }
            self.count(&case, case.boxes[i], &geometry[i], answers[i]);
            if !is_right(&geometry[i], answers[i]) {
                let (origin, dir): ([f32; 3], [f32; 3]) = (case.ray.origin.into(), case.ray.dir.into());
                let (extent, aabb, answer) = (f32::from(case.ray.extent), case.boxes[i], answers[i]);
                let entry = geometry[i].entry.to_f64();
                self.failures.add(|| {
                    format!(
                        "ray from {origin:?} along {dir:?} to {extent:e}, box {aabb:?}: {answer:?}, exact entry \
                         {entry:e}"
                    )
                });
            }
            for (found, answers) in self.found.iter_mut().zip(&faulty) {
                *found += u64::from(!is_right(&geometry[i], answers[i]));
            }
        }
    }

    fn count(&mut self, case: &Case, [low, high]: [[f32; 3]; 2], geometry: &ExactIntersection, (hit, tmin): Answer) {
        let (origin, dir) = (<[f32; 3]>::from(case.ray.origin), <[f32; 3]>::from(case.ray.dir));
        let some_axis = |is: &dyn Fn(usize) -> bool| u64::from((0..3).any(is));
        self.checked += 1;
        self.flat += some_axis(&|i| low[i] == high[i]);
        self.empty += some_axis(&|i| low[i] > high[i]);
        self.along += some_axis(&|i| dir[i] == 0.0);
        self.in_plane += some_axis(&|i| dir[i] == 0.0 && (origin[i] == low[i] || origin[i] == high[i]));
        self.touched += u64::from(geometry.is_hit && geometry.gap == 0.0);
        self.undetermined += u64::from(geometry.required_hit.is_none());
        self.hits += u64::from(hit);
        if hit != geometry.is_hit {
            self.differing += 1;
        }
        // Relative errors have no meaning where distances underflow.
        let entry = geometry.entry.to_f64();
        let is_large = entry > 2_f64.powi(-120);
        if hit != geometry.is_hit && is_large {
            self.gap.add(geometry.gap.abs() / U);
        }
        if hit && is_large {
            let off = geometry.entry.distance(tmin) / entry;
            self.tmin_units.add(off / U);
            self.tmin_ulps.add(off * ulps_of(entry));
        }
    }

    fn verdict(self, is_stopped: bool) -> Verdict {
        let Self { checked, hits, flat, empty, along, in_plane, touched, .. } = self;
        let covered = format!(
            "{checked} boxes, {hits} hit; {touched} touched in one point, {flat} flat, {empty} empty, {along} with the \
             ray along a slab, {in_plane} in its plane"
        );
        let remarks = vec![
            format!("error of tmin: at most {:.3} ulps, {:.3} u; bound 3", self.tmin_ulps.0, self.tmin_units.0),
            format!(
                "within the rounding bound, so that either result is right: {} boxes, {} of them with another result \
                 than exact arithmetic, at a gap of at most {:.3} u; bound 6",
                self.undetermined, self.differing, self.gap.0
            ),
            format!("beyond the range of binary32, which the claim excludes: {} boxes", self.out_of_range),
        ];
        let mut verdict = Verdict { covered, remarks, failures: self.failures.lines(), is_stopped };
        let names = FAULTY.map(|(name, _)| name);
        add_controls(&mut verdict, "wrong results of faulty implementations", names, self.found, checked >= ENOUGH);
        verdict
    }
}

/// Whether rounding allows a result.
fn is_right(geometry: &ExactIntersection, (hit, tmin): Answer) -> bool {
    geometry.required_hit.is_none_or(|required_hit| hit == required_hit) && (!hit || geometry.entry.may_round_to(tmin))
}

tally_of_fields!(Boxes {
    checked,
    hits,
    undetermined,
    differing,
    out_of_range,
    flat,
    empty,
    along,
    in_plane,
    touched,
    tmin_ulps,
    tmin_units,
    gap,
    found,
    failures
});

#[cfg(test)]
mod tests {
    use super::{Boxes, FAULTY};
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;

    /// The campaign passes the datapath, finds each deliberate fault, and has cases of every kind.
    #[test]
    fn faults_are_found() {
        let (mut boxes, mut rng) = (Boxes::default(), ChaCha8Rng::seed_from_u64(5));
        (0..2500).for_each(|_| boxes.run(&mut rng));
        for ((name, _), found) in FAULTY.iter().zip(boxes.found) {
            assert!(found > 50, "{name}: {found}");
        }
        let Boxes { hits, undetermined, differing, flat, empty, along, in_plane, touched, .. } = boxes;
        let met = [hits, undetermined, flat, empty, along, in_plane, touched];
        assert!(met.iter().all(|&n| n > 150) && differing > 10, "{met:?} {differing}");
        assert!(boxes.checked > 9_500 && boxes.tmin_units.0 > 1.5 && boxes.gap.0 > 1.0);
        assert_eq!(boxes.failures.lines(), Vec::<String>::new());
    }
}
