//! The errors of the accumulated sums.

use super::campaign::{self, Failures, Largest, add_controls, tally_of_fields};
use super::dyadic::{Dyadic, within_gamma};
use super::error_units::U;
use super::wrong_sums::Wrong;
use crate::error::Error;
use crate::request::Request;
use crate::verdict::Verdict;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_model::Functional;
use raypath_ops::{Beat, BeatInput, Binary32, Flags, Job, Outcome, Rules};

/// One case of this many also runs on the wrong implementations.
const CONTROL_INTERVAL: u64 = 16;
/// The number of sums after which each wrong implementation must have been refuted.
const ENOUGH: u64 = 3_000;

/// Compares sums over vectors of 1 to 64 beats, at every number of lanes, with exact arithmetic.
pub fn verify(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let cases = request.jobs.unwrap_or(request.level.pick(20_000, 500_000, 20_000_000));
    let (tally, is_stopped) =
        campaign::run(request, 3, cases, |rng, tally: &mut SumErrors| match rng.random_range(0..6) {
            0 => tally.check::<2, 1>(rng),
            1 => tally.check::<4, 2>(rng),
            2 => tally.check::<8, 4>(rng),
            3 => tally.check::<16, 8>(rng),
            4 => tally.check::<32, 16>(rng),
            _ => tally.check::<64, 32>(rng),
        })?;
    Ok(tally.verdict(is_stopped))
}

/// The distribution of a vector's numbers.
#[derive(Debug, Clone, Copy)]
enum Numbers {
    /// Uniform in [-1, 1].
    Unit,
    /// Positive and near 1: every addition rounds, nothing cancels.
    Positive,
    /// The second vector is near the first.
    Near,
    /// Of very different magnitudes; some products underflow.
    Wide,
}

impl Numbers {
    fn pair(self, rng: &mut ChaCha8Rng) -> [f32; 2] {
        let mut unit = || rng.random_range(-1.0..=1.0_f64);
        match self {
            Self::Unit => [unit() as f32, unit() as f32],
            Self::Positive => [(1.0 + unit() / 2.0) as f32, (3.0 + unit() / 2.0) as f32],
            Self::Near => {
                let (x, difference) = (unit(), unit());
                [x as f32, (x + difference / 4096.0) as f32]
            }
            Self::Wide => std::array::from_fn(|_| {
                let sign = if rng.random() { 1.0 } else { -1.0 };
                (sign * rng.random_range(-80.0..40.0_f64).exp2()) as f32
            }),
        }
    }
}

/// An exact sum, with the magnitudes that bound its error.
struct Sum {
    value: Dyadic,
    magnitude: Dyadic,
    terms: u32,
}

impl Sum {
    fn new() -> Self {
        Self { value: Dyadic::zero(), magnitude: Dyadic::zero(), terms: 0 }
    }

    fn add(&mut self, term: Dyadic) {
        self.magnitude = &self.magnitude + &term.abs();
        self.value = &self.value + &term;
        self.terms += 1;
    }
}

#[derive(Default)]
struct SumErrors {
    sums: u64,
    /// For Euclidean sums, dot products and norms: the largest error in u of the sum of magnitudes, and relative to its
    /// bound.
    units: [Largest; 3],
    parts: [Largest; 3],
    /// Wrong sums of each wrong implementation.
    refuted: [u64; Wrong::ALL.len()],
    failures: Failures,
}

const NAMES: [&str; 3] = ["Euclidean sums", "dot products", "norms"];

impl SumErrors {
    fn check<const E: usize, const A: usize>(&mut self, rng: &mut ChaCha8Rng) {
        let numbers = [Numbers::Unit, Numbers::Positive, Numbers::Near, Numbers::Wide][rng.random_range(0..4)];
        let beats = [1, 1, 2, 3, 8, 64][rng.random_range(0..6)];
        let last = beats - 1;
        let vectors: Vec<_> = (0..beats).map(|beat| draw::<E>(rng, numbers, beat == last)).collect();
        let mut exact = Sum::new();
        for [a, b] in vectors.iter().flat_map(lanes) {
            let difference = Dyadic::from(a) - Dyadic::from(b);
            exact.add(&difference * &difference);
        }
        // The difference, which counts twice, and the square; the tree; and the beats after the first.
        let roundings = 3 + E.ilog2() + last;
        let case = self.sums / NAMES.len() as u64;
        let is_control = case.is_multiple_of(CONTROL_INTERVAL);
        self.add(0, euclidean::<E, A>(&vectors), &exact, roundings);
        if is_control {
            self.refute(|wrong, control| control.add(0, wrong.euclidean::<E, A>(&vectors), &exact, roundings));
        }

        let vectors: Vec<_> = (0..beats).map(|beat| draw::<A>(rng, numbers, beat == last)).collect();
        let (mut dot, mut norm) = (Sum::new(), Sum::new());
        for [a, b] in vectors.iter().flat_map(lanes).map(|pair| pair.map(Dyadic::from)) {
            dot.add(&a * &b);
            norm.add(&b * &b);
        }
        let roundings = 1 + A.ilog2() + last;
        let add = |errors: &mut Self, sums: [f32; 2]| {
            for (kind, (sum, exact)) in (1..).zip(sums.into_iter().zip([&dot, &norm])) {
                errors.add(kind, sum, exact, roundings);
            }
        };
        add(self, angular::<E, A>(&vectors));
        if is_control {
            self.refute(|wrong, control| add(control, wrong.angular::<E, A>(&vectors)));
        }
    }

    /// Checks the wrong implementations, and counts their wrong sums.
    fn refute(&mut self, check: impl Fn(Wrong, &mut Self)) {
        for (refuted, wrong) in self.refuted.iter_mut().zip(Wrong::ALL) {
            let mut control = Self::default();
            check(wrong, &mut control);
            *refuted += control.failures.count();
        }
    }

    /// Checks |sum − exact| ≤ γₙ Σ|term| + terms · 2⁻¹⁴⁹. The last term bounds the underflow of products.
    fn add(&mut self, kind: usize, sum: f32, exact: &Sum, roundings: u32) {
        self.sums += 1;
        let off = (Dyadic::from(sum) - &exact.value).abs();
        let beyond_underflow = &off - &(Dyadic::from(exact.terms) * Dyadic::power_of_two(-149));
        if exact.magnitude.sign().is_gt() {
            let units = beyond_underflow.to_f64() / exact.magnitude.to_f64() / U;
            self.units[kind].add(units);
            self.parts[kind].add(units / f64::from(roundings));
        }
        if !within_gamma(roundings, &beyond_underflow, &exact.magnitude) {
            self.failures.add(|| {
                let (value, name) = (exact.value.to_f64(), NAMES[kind]);
                format!("{name}: {sum:e}, expected {value:e}, of {} terms, within {roundings} roundings", exact.terms)
            });
        }
    }

    fn verdict(self, is_stopped: bool) -> Verdict {
        let remark = |kind: usize| {
            let ([units, parts], name) = ([self.units[kind].0, self.parts[kind].0], NAMES[kind]);
            format!("{name}: at most {units:.2} u of the sum of magnitudes, and {parts:.2} of the bound")
        };
        let remarks = (0..NAMES.len()).map(remark).collect();
        let covered = format!("{} sums of 1 to 64 beats with 2 to 64 lanes", self.sums);
        let mut verdict = Verdict { covered, remarks, failures: self.failures.lines(), is_stopped };
        let label = format!("wrong sums found of each wrong implementation, tried in one case in {CONTROL_INTERVAL}");
        add_controls(&mut verdict, &label, Wrong::ALL.map(Wrong::name), self.refuted, self.sums >= ENOUGH);
        verdict
    }
}

fn draw<const N: usize>(rng: &mut ChaCha8Rng, numbers: Numbers, last: bool) -> Beat<Binary32, N> {
    let pairs: [[f32; 2]; N] = std::array::from_fn(|_| numbers.pair(rng));
    let mask = if rng.random() { u64::MAX } else { rng.random() };
    Beat {
        a: pairs.map(|[a, _]| a.into()),
        b: pairs.map(|[_, b]| b.into()),
        mask: Flags::from_mask(mask),
        reset_accum: last.into(),
    }
}

/// The datapath's Euclidean sum over beats.
pub fn euclidean<const E: usize, const A: usize>(beats: &[Beat<Binary32, E>]) -> f32 {
    let mut datapath = Functional::<E, A>::new(Rules::Paper);
    let sum = |beat: &Beat<Binary32, E>| match datapath.run(&Job::Euclidean(BeatInput { euclidean: *beat })) {
        Outcome::Euclidean(output) => output.euclidean_accumulator.into(),
        other => unreachable!("a Euclidean outcome is no {other:?}"),
    };
    beats.iter().map(sum).last().unwrap_or(f32::NAN)
}

/// The datapath's dot product and norm over beats.
pub fn angular<const E: usize, const A: usize>(beats: &[Beat<Binary32, A>]) -> [f32; 2] {
    let mut datapath = Functional::<E, A>::new(Rules::Paper);
    let sums = |beat: &Beat<Binary32, A>| match datapath.run(&Job::Angular(BeatInput { euclidean: *beat })) {
        Outcome::Angular(output) => [output.angular_dot_product.into(), output.angular_norm.into()],
        other => unreachable!("an angular outcome is no {other:?}"),
    };
    beats.iter().map(sums).last().unwrap_or([f32::NAN; 2])
}

/// The enabled lanes' numbers.
pub fn lanes<const N: usize>(beat: &Beat<Binary32, N>) -> impl Iterator<Item = [f32; 2]> {
    let pairs = beat.a.iter().zip(&beat.b).map(|(&a, &b)| [a.into(), b.into()]);
    pairs.zip(beat.mask.to_array()).filter(|(_, on)| *on).map(|(pair, _)| pair)
}

tally_of_fields!(SumErrors { sums, units, parts, refuted, failures });

#[cfg(test)]
mod tests {
    use super::{Dyadic, Sum, SumErrors};
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;

    #[test]
    fn the_datapaths_sums_are_within_the_bound() {
        let (mut errors, mut rng) = (SumErrors::default(), ChaCha8Rng::seed_from_u64(1));
        for _ in 0..200 {
            errors.check::<16, 8>(&mut rng);
            errors.check::<2, 1>(&mut rng);
        }
        assert_eq!(errors.failures.lines(), Vec::<String>::new());
        assert!(errors.parts.iter().all(|part| part.0 > 0.3), "{:?}", errors.parts);
        assert!(errors.refuted.iter().all(|&refuted| refuted > 0), "{:?}", errors.refuted);
    }

    /// Twelve thirds, and a sum with an error of one rounding more than the bound.
    #[test]
    fn wrong_sums_are_found() {
        let mut exact = Sum::new();
        (0..12).for_each(|_| exact.add(Dyadic::from(1.0 / 3.0)));
        let mut errors = SumErrors::default();
        let ulp = 2_f32.powi(-21);
        errors.add(0, 4.0 + 2.0 * ulp, &exact, 4);
        assert_eq!(errors.failures.count(), 0);
        errors.add(0, 4.0 + 3.0 * ulp, &exact, 4);
        assert_eq!(errors.failures.count(), 1);
    }
}
