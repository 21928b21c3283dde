//! The errors of the accumulated sums.

use super::triangle_distances::truncate;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_model::Functional;
use raypath_ops::{Beat, BeatInput, Binary32, Flags, Job, Outcome, Rounding, Rules};
use raypath_oracle::geometry::dyadic::{Dyadic, U, within_gamma};
use raypath_verify::campaign::{Campaign, Tally};
use raypath_verify::{Error, Request, Verdict};

/// One case of this many also runs on the wrong implementations.
const CONTROL_INTERVAL: u64 = 16;
/// The number of sums after which each wrong implementation must have been refuted.
const ENOUGH: u64 = 3_000;

/// Compares sums over vectors of 1 to 64 beats, at every number of lanes, with exact arithmetic.
pub fn verify(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let cases = request.jobs.unwrap_or(request.level.pick(20_000, 250_000, 20_000_000));
    let checks = [check::<2, 1>, check::<4, 2>, check::<8, 4>, check::<16, 8>, check::<32, 16>, check::<64, 32>];
    let (tally, is_stopped) = Campaign::new(3, cases)
        .run_cases(request, |rng, tally| checks[rng.random_range(0..checks.len())](tally, rng))?;
    Ok(verdict(tally, is_stopped))
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
        let [x, y] = [(); 2].map(|()| rng.random_range(-1.0..=1.0_f64));
        match self {
            Self::Unit => [x as f32, y as f32],
            Self::Positive => [(1.0 + x / 2.0) as f32, (3.0 + y / 2.0) as f32],
            Self::Near => [x as f32, (x + y / 4096.0) as f32],
            Self::Wide => [x, y].map(|sign| (rng.random_range(-80.0..40.0_f64).exp2().copysign(sign)) as f32),
        }
    }

    fn beats<const N: usize>(self, count: usize, rng: &mut ChaCha8Rng) -> Vec<Beat<Binary32, N>> {
        let beat = |number| {
            let pairs: [[f32; 2]; N] = std::array::from_fn(|_| self.pair(rng));
            let mask = if rng.random() { u64::MAX } else { rng.random() };
            Beat {
                a: pairs.map(|[a, _]| a.into()),
                b: pairs.map(|[_, b]| b.into()),
                mask: Flags::from_mask(mask),
                reset_accum: (number == count).into(),
            }
        };
        (1..=count).map(beat).collect()
    }
}

/// An exact sum, with the magnitudes that bound its error.
#[derive(Default)]
struct Sum {
    value: Dyadic,
    magnitude: Dyadic,
    terms: u32,
}

impl Sum {
    /// The sum of a function of each enabled lane.
    fn of<const N: usize>(beats: &[Beat<Binary32, N>], term: impl Fn([Dyadic; 2]) -> Dyadic) -> Self {
        let mut sum = Self::default();
        beats.iter().flat_map(lanes).for_each(|pair| sum.add(term(pair.map(Dyadic::from))));
        sum
    }

    fn add(&mut self, term: Dyadic) {
        self.magnitude = &self.magnitude + &term.abs();
        self.value = &self.value + &term;
        self.terms += 1;
    }
}

/// The kinds of sums: those of trees of adders, and those of beats that round once. For each, the largest error in u of
/// the sum of magnitudes counts, and relative to its bound.
const KINDS: [(&str, &str); 6] = [
    ("Euclidean sums", "part of a Euclidean sum's bound"),
    ("dot products", "part of a dot product's bound"),
    ("norms", "part of a norm's bound"),
    ("Euclidean sums, rounding sum", "part of the bound of a Euclidean sum with rounding sum"),
    ("dot products, rounding sum", "part of the bound of a dot product with rounding sum"),
    ("norms, rounding sum", "part of the bound of a norm with rounding sum"),
];

/// The roundings with the first of their kinds of sums.
const ROUNDINGS: [(Rounding, usize); 2] = [(Rounding::Unit, 0), (Rounding::Sum, 3)];

/// The roundings to which a sum of `terms` terms counts, relative to the sum of its terms' magnitudes.
fn roundings_of(rounding: Rounding, terms: usize) -> u32 {
    match (rounding, terms) {
        (Rounding::Unit, _) => terms.ilog2(),
        // One term is no sum, and two are an addition.
        (Rounding::Sum, 1..4) => terms as u32 - 1,
        (Rounding::Sum, _) => 3,
    }
}

/// Checks the sums of a pair of vectors of each operation; in some cases also on the wrong implementations.
fn check<const E: usize, const A: usize>(tally: &mut Tally, rng: &mut ChaCha8Rng) {
    let numbers = [Numbers::Unit, Numbers::Positive, Numbers::Near, Numbers::Wide][rng.random_range(0..4)];
    let count = [1, 1, 2, 3, 8, 64][rng.random_range(0..6)];
    let is_control = (tally.count("sums") / KINDS.len() as u64).is_multiple_of(CONTROL_INTERVAL);
    let (distance, product) = (numbers.beats::<E>(count, rng), numbers.beats::<A>(count, rng));
    let square = |[a, b]: [Dyadic; 2]| (&a - &b) * (&a - &b);
    let exact = [Sum::of(&distance, square), Sum::of(&product, |[a, b]| a * &b), Sum::of(&product, |[_, b]| &b * &b)];
    for (rounding, first) in ROUNDINGS {
        // The difference, which counts twice, and the square; the sum of each half, and that of both; and the beats
        // after the first.
        let of_distance = 3 + roundings_of(rounding, E / 2) + count as u32;
        let of_product = roundings_of(rounding, A) + count as u32;
        let judge = |tally: &mut Tally, sums: [f32; 3]| {
            for (i, roundings) in [of_distance, of_product, of_product].into_iter().enumerate() {
                judge(tally, first + i, sums[i], &exact[i], roundings);
            }
        };
        judge(tally, sums(rounding, &distance, &product));
        for (wrong, name) in WRONG.into_iter().filter(|_| is_control) {
            let mut control = Tally::default();
            judge(&mut control, wrong.sums(rounding, &distance, &product));
            tally.add(name, control.failures());
        }
    }
}

/// Checks |sum − exact| ≤ γₙ Σ|term| + terms · 2⁻¹⁴⁹. The last term bounds the underflow of products.
fn judge(tally: &mut Tally, kind: usize, sum: f32, exact: &Sum, roundings: u32) {
    let (name, part) = KINDS[kind];
    tally.add("sums", true);
    if !sum.is_finite() {
        return tally.fail(|| format!("{name}: {sum}, expected a number"));
    }
    let off = (Dyadic::from(sum) - &exact.value).abs();
    let beyond_underflow = &off - &(Dyadic::from(exact.terms) * Dyadic::power_of_two(-149));
    if exact.magnitude.sign().is_gt() {
        let units = beyond_underflow.to_f64() / exact.magnitude.to_f64() / U;
        tally.add_value(name, units);
        tally.add_value(part, units / f64::from(roundings));
    }
    if !within_gamma(roundings, &beyond_underflow, &exact.magnitude) {
        tally.fail(|| {
            let (value, terms) = (exact.value.to_f64(), exact.terms);
            format!("{name}: {sum:e}, expected {value:e}, of {terms} terms, within {roundings} roundings")
        });
    }
}

fn verdict(tally: Tally, is_stopped: bool) -> Verdict {
    let remark = |(name, part)| {
        let (units, parts) = (tally.largest(name), tally.largest(part));
        format!("{name}: at most {units:.2} u of the sum of magnitudes, and {parts:.2} of the bound")
    };
    let remarks = KINDS.into_iter().map(remark).collect();
    let sums = tally.count("sums");
    let covered = format!("{sums} sums of 1 to 64 beats with 2 to 64 lanes");
    let label = format!("wrong sums found of each wrong implementation, tried in one case in {CONTROL_INTERVAL}");
    tally.verdict(is_stopped, covered, remarks, (&label, WRONG.map(|(_, name)| name), sums >= ENOUGH))
}

/// The functional model's Euclidean sum, dot product and norm; NaN without beats.
fn sums<const E: usize, const A: usize>(
    rounding: Rounding,
    distance: &[Beat<Binary32, E>],
    product: &[Beat<Binary32, A>],
) -> [f32; 3] {
    let mut model = Functional::<E, A>::new(Rules::Paper).rounding(rounding);
    let mut sums = [f32::NAN; 3];
    let jobs = distance.iter().map(|beat| Job::Euclidean(BeatInput { euclidean: *beat }));
    for job in jobs.chain(product.iter().map(|beat| Job::Angular(BeatInput { euclidean: *beat }))) {
        match model.run(&job) {
            Outcome::Euclidean(output) => sums[0] = output.euclidean_accumulator.into(),
            Outcome::Angular(output) => {
                sums[1..].copy_from_slice(&[output.angular_dot_product, output.angular_norm].map(f32::from));
            }
            other => unreachable!("a beat's outcome is no {other:?}"),
        }
    }
    sums
}

/// The enabled lanes' numbers.
fn lanes<const N: usize>(beat: &Beat<Binary32, N>) -> impl Iterator<Item = [f32; 2]> {
    let pairs = beat.a.iter().zip(&beat.b).map(|(&a, &b)| [a.into(), b.into()]);
    pairs.zip(beat.mask.to_array()).filter(|(_, on)| *on).map(|(pair, _)| pair)
}

/// A wrong implementation: the negative control.
#[derive(Debug, Clone, Copy)]
enum Wrong {
    MasksIgnored,
    /// The operands have significands of 16 bits.
    ShortOperands,
    LastBeatAlone,
    /// Euclidean sums by (a - b)² = a² - 2ab + b², which cancels if a is near b.
    Expanded,
    /// Sums that round once, with a window of 18 bits.
    ShortWindow,
}

/// All wrong implementations, with their names in reports.
const WRONG: [(Wrong, &str); 5] = [
    (Wrong::MasksIgnored, "masks ignored"),
    (Wrong::ShortOperands, "operands of 16 bits"),
    (Wrong::LastBeatAlone, "the last beat alone"),
    (Wrong::Expanded, "squares of differences expanded"),
    (Wrong::ShortWindow, "a window of 18 bits"),
];

impl Wrong {
    fn sums<const E: usize, const A: usize>(
        self,
        rounding: Rounding,
        distance: &[Beat<Binary32, E>],
        product: &[Beat<Binary32, A>],
    ) -> [f32; 3] {
        let expanded = |[a, b]: [f32; 2]| a * a - 2.0 * a * b + b * b;
        match self {
            Self::ShortWindow => [
                in_short_window(distance, |[a, b]| (a - b) * (a - b)),
                in_short_window(product, |[a, b]| a * b),
                in_short_window(product, |[_, b]| b * b),
            ],
            Self::Expanded => {
                let [_, dot, norm] = sums(rounding, distance, product);
                [distance.iter().flat_map(lanes).map(expanded).sum(), dot, norm]
            }
            _ => sums(rounding, &self.changed(distance), &self.changed(product)),
        }
    }

    /// The beats to run on the datapath instead of these.
    fn changed<const N: usize>(self, beats: &[Beat<Binary32, N>]) -> Vec<Beat<Binary32, N>> {
        let short = |number: [_; N]| number.map(|number| truncate(f32::from(number), 16).into());
        let change = |beat: &Beat<Binary32, N>| match self {
            Self::MasksIgnored => Beat { mask: Flags::from_mask(u64::MAX), ..*beat },
            Self::ShortOperands => Beat { a: short(beat.a), b: short(beat.b), ..*beat },
            Self::LastBeatAlone | Self::Expanded | Self::ShortWindow => *beat,
        };
        let first = if matches!(self, Self::LastBeatAlone) { beats.len() - 1 } else { 0 };
        beats[first..].iter().map(change).collect()
    }
}

/// The sum of the beats' terms, those of a beat truncated to 18 places below the greatest of their exponents.
fn in_short_window<const N: usize>(beats: &[Beat<Binary32, N>], term: impl Fn([f32; 2]) -> f32) -> f32 {
    let sum = |beat: &Beat<Binary32, N>| {
        let terms: Vec<f64> = lanes(beat).map(|pair| f64::from(term(pair))).collect();
        let greatest = terms.iter().fold(0.0_f64, |greatest, term| greatest.max(term.abs()));
        let last_place = f64::from_bits(greatest.to_bits() & 0x7ff << 52) * 2_f64.powi(-17);
        let kept = |term: &f64| if last_place == 0.0 { 0.0 } else { (term / last_place).trunc() * last_place };
        terms.iter().map(kept).sum::<f64>() as f32
    };
    beats.iter().map(sum).sum()
}

#[cfg(test)]
mod tests {
    use super::{Dyadic, KINDS, Sum, Tally, WRONG, check, judge};
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;

    #[test]
    fn the_datapaths_sums_are_within_the_bound() {
        let (mut tally, mut rng) = (Tally::default(), ChaCha8Rng::seed_from_u64(1));
        for _ in 0..200 {
            check::<64, 32>(&mut tally, &mut rng);
            check::<16, 8>(&mut tally, &mut rng);
            check::<2, 1>(&mut tally, &mut rng);
        }
        assert_eq!(tally.failures(), 0, "{tally:?}");
        assert!(KINDS.iter().all(|(_, part)| tally.largest(part) > 0.3), "{tally:?}");
        assert!(WRONG.iter().all(|(_, name)| tally.count(name) > 0), "{tally:?}");
    }

    /// Twelve thirds, and a sum with an error of one rounding more than the bound.
    #[test]
    fn wrong_sums_are_found() {
        let mut exact = Sum::default();
        (0..12).for_each(|_| exact.add(Dyadic::from(1.0 / 3.0)));
        let mut tally = Tally::default();
        let ulp = 2_f32.powi(-21);
        judge(&mut tally, 0, 4.0 + 2.0 * ulp, &exact, 4);
        assert_eq!(tally.failures(), 0);
        judge(&mut tally, 0, 4.0 + 3.0 * ulp, &exact, 4);
        assert_eq!(tally.failures(), 1);
    }
}
