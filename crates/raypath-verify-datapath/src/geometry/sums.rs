//! The errors of the accumulated sums.

use super::campaign::{self, Tally};
use super::pipeline::{self, Pair, Pipeline, SAMPLED};
use super::triangle_distances::truncate;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_model::Functional;
use raypath_ops::{Beat, BeatInput, Binary32, Flags, Job, Outcome, Rounding, Rules};
use raypath_rtl::Config;
use raypath_verify::dyadic::{Dyadic, U, within_gamma};
use raypath_verify::{Error, Request, Verdict};

/// One case of this many also runs on the wrong implementations.
const CONTROL_INTERVAL: u64 = 16;
/// The number of sums after which each wrong implementation must have been refuted.
const ENOUGH: u64 = 3_000;

/// Compares sums over vectors of 1 to 64 beats, at every number of lanes, with exact arithmetic.
pub fn verify(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let cases = request.jobs.unwrap_or(request.level.pick(20_000, 500_000, 20_000_000));
    let (tally, is_stopped) = campaign::run(request, 3, cases, |rng, tally| match rng.random_range(0..6) {
        0 => check::<2, 1>(tally, rng),
        1 => check::<4, 2>(tally, rng),
        2 => check::<8, 4>(tally, rng),
        3 => check::<16, 8>(tally, rng),
        4 => check::<32, 16>(tally, rng),
        _ => check::<64, 32>(tally, rng),
    })?;
    let verdict = verdict(tally, is_stopped);
    if is_stopped {
        return Ok(verdict);
    }
    let pairs = || {
        let pair = |(rounding, _)| Pair::new(Config::DEFAULT.rounding(rounding), FAULT);
        let [unit, sum] = ROUNDINGS.map(pair);
        Ok([unit?, sum?])
    };
    let on_netlist = campaign::run_with(request, 13, cases.div_ceil(SAMPLED), pairs, |pairs, rng, tally| {
        let (numbers, beats) = shape(rng);
        let distance = Distance::<16>::draw(rng, numbers, beats);
        let product = Product::<8>::draw(rng, numbers, beats);
        for (kind, pair) in ROUNDINGS.into_iter().zip(pairs) {
            let judge = |tally: &mut Tally, pipeline: &Pipeline| {
                let run = |job: &Job| pipeline.run(job);
                distance.check(tally, kind, euclidean_by(run, &distance.beats));
                product.check(tally, kind, angular_by(run, &product.beats));
            };
            judge(tally, &pair.right);
            let mut control = Tally::default();
            judge(&mut control, &pair.faulty);
            tally.add(pipeline::FAULTY, control.failures());
        }
    })?;
    Ok(pipeline::joined(verdict, on_netlist, "sums"))
}

/// The fault of the netlists that are the negative control: a step of an alignment.
const FAULT: &str = "raypath_fp_add_e8s24, aligned_4:";

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
#[derive(Default)]
struct Sum {
    value: Dyadic,
    magnitude: Dyadic,
    terms: u32,
}

impl Sum {
    fn add(&mut self, term: Dyadic) {
        self.magnitude = &self.magnitude + &term.abs();
        self.value = &self.value + &term;
        self.terms += 1;
    }
}

/// The kinds of sums: those of trees of adders, and those of beats that round once. For each, the largest error in u of
/// the sum of magnitudes counts, and relative to its bound.
const NAMES: [&str; 6] = [
    "Euclidean sums",
    "dot products",
    "norms",
    "Euclidean sums, rounding sum",
    "dot products, rounding sum",
    "norms, rounding sum",
];
const PARTS: [&str; 6] = [
    "part of a Euclidean sum's bound",
    "part of a dot product's bound",
    "part of a norm's bound",
    "part of the bound of a Euclidean sum with rounding sum",
    "part of the bound of a dot product with rounding sum",
    "part of the bound of a norm with rounding sum",
];

/// The roundings to which a sum of `terms` terms counts, relative to the sum of its terms' magnitudes.
fn roundings_of(rounding: Rounding, terms: usize) -> u32 {
    match (rounding, terms) {
        (Rounding::Unit, _) => terms.ilog2(),
        // One term is no sum, and two are an addition.
        (Rounding::Sum, 1) => 0,
        (Rounding::Sum, 2) => 1,
        (Rounding::Sum, 3) => 2,
        (Rounding::Sum, _) => 3,
    }
}

/// The roundings with the first of their kinds of sums.
const ROUNDINGS: [(Rounding, usize); 2] = [(Rounding::Unit, 0), (Rounding::Sum, 3)];

/// A pair of vectors, and their exact squared distance.
struct Distance<const E: usize> {
    beats: Vec<Beat<Binary32, E>>,
    exact: Sum,
}

/// A pair of vectors, their exact dot product, and the squared norm of the second.
struct Product<const A: usize> {
    beats: Vec<Beat<Binary32, A>>,
    dot: Sum,
    norm: Sum,
}

impl<const E: usize> Distance<E> {
    fn draw(rng: &mut ChaCha8Rng, numbers: Numbers, beats: usize) -> Self {
        let beats: Vec<_> = (0..beats).map(|beat| draw::<E>(rng, numbers, beat + 1 == beats)).collect();
        let mut exact = Sum::default();
        for [a, b] in beats.iter().flat_map(lanes) {
            let difference = Dyadic::from(a) - Dyadic::from(b);
            exact.add(&difference * &difference);
        }
        Self { beats, exact }
    }

    fn check(&self, tally: &mut Tally, (rounding, first): (Rounding, usize), sum: f32) {
        // The difference, which counts twice, and the square; the sum of each half, and that of both; and the beats
        // after the first.
        let roundings = 3 + roundings_of(rounding, E / 2) + self.beats.len() as u32;
        add(tally, first, sum, &self.exact, roundings);
    }
}

impl<const A: usize> Product<A> {
    fn draw(rng: &mut ChaCha8Rng, numbers: Numbers, beats: usize) -> Self {
        let beats: Vec<_> = (0..beats).map(|beat| draw::<A>(rng, numbers, beat + 1 == beats)).collect();
        let (mut dot, mut norm) = (Sum::default(), Sum::default());
        for [a, b] in beats.iter().flat_map(lanes).map(|pair| pair.map(Dyadic::from)) {
            dot.add(&a * &b);
            norm.add(&b * &b);
        }
        Self { beats, dot, norm }
    }

    fn check(&self, tally: &mut Tally, (rounding, first): (Rounding, usize), [dot, norm]: [f32; 2]) {
        let roundings = roundings_of(rounding, A) + self.beats.len() as u32;
        add(tally, first + 1, dot, &self.dot, roundings);
        add(tally, first + 2, norm, &self.norm, roundings);
    }
}

/// The distribution of numbers, and how many beats there are.
fn shape(rng: &mut ChaCha8Rng) -> (Numbers, usize) {
    let numbers = [Numbers::Unit, Numbers::Positive, Numbers::Near, Numbers::Wide][rng.random_range(0..4)];
    (numbers, [1, 1, 2, 3, 8, 64][rng.random_range(0..6)])
}

fn check<const E: usize, const A: usize>(tally: &mut Tally, rng: &mut ChaCha8Rng) {
    let (numbers, beats) = shape(rng);
    let case = tally.count("sums") / NAMES.len() as u64;
    let is_control = case.is_multiple_of(CONTROL_INTERVAL);
    let distance = Distance::<E>::draw(rng, numbers, beats);
    for kind in ROUNDINGS {
        distance.check(tally, kind, euclidean::<E, A>(kind.0, &distance.beats));
        if is_control {
            refute(tally, |wrong, control| {
                distance.check(control, kind, wrong.euclidean::<E, A>(kind.0, &distance.beats));
            });
        }
    }
    let product = Product::<A>::draw(rng, numbers, beats);
    for kind in ROUNDINGS {
        product.check(tally, kind, angular::<E, A>(kind.0, &product.beats));
        if is_control {
            refute(tally, |wrong, control| product.check(control, kind, wrong.angular::<E, A>(kind.0, &product.beats)));
        }
    }
}

/// Checks the wrong implementations, and counts their wrong sums.
fn refute(tally: &mut Tally, check: impl Fn(Wrong, &mut Tally)) {
    for (wrong, name) in WRONG {
        let mut control = Tally::default();
        check(wrong, &mut control);
        tally.add(name, control.failures());
    }
}

/// Checks |sum − exact| ≤ γₙ Σ|term| + terms · 2⁻¹⁴⁹. The last term bounds the underflow of products.
fn add(tally: &mut Tally, kind: usize, sum: f32, exact: &Sum, roundings: u32) {
    tally.add("sums", true);
    if !sum.is_finite() {
        return tally.fail(|| format!("{}: {sum}, expected a number", NAMES[kind]));
    }
    let off = (Dyadic::from(sum) - &exact.value).abs();
    let beyond_underflow = &off - &(Dyadic::from(exact.terms) * Dyadic::power_of_two(-149));
    if exact.magnitude.sign().is_gt() {
        let units = beyond_underflow.to_f64() / exact.magnitude.to_f64() / U;
        tally.add_value(NAMES[kind], units);
        tally.add_value(PARTS[kind], units / f64::from(roundings));
    }
    if !within_gamma(roundings, &beyond_underflow, &exact.magnitude) {
        tally.fail(|| {
            let (value, name) = (exact.value.to_f64(), NAMES[kind]);
            format!("{name}: {sum:e}, expected {value:e}, of {} terms, within {roundings} roundings", exact.terms)
        });
    }
}

fn verdict(tally: Tally, is_stopped: bool) -> Verdict {
    let remark = |(name, part)| {
        let (units, parts) = (tally.largest(name), tally.largest(part));
        format!("{name}: at most {units:.2} u of the sum of magnitudes, and {parts:.2} of the bound")
    };
    let remarks = NAMES.into_iter().zip(PARTS).map(remark).collect();
    let sums = tally.count("sums");
    let covered = format!("{sums} sums of 1 to 64 beats with 2 to 64 lanes");
    let label = format!("wrong sums found of each wrong implementation, tried in one case in {CONTROL_INTERVAL}");
    tally.verdict(is_stopped, covered, remarks, (&label, WRONG.map(|(_, name)| name), sums >= ENOUGH))
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

/// The functional model's Euclidean sum over beats.
fn euclidean<const E: usize, const A: usize>(rounding: Rounding, beats: &[Beat<Binary32, E>]) -> f32 {
    let mut model = Functional::<E, A>::new(Rules::Paper).rounding(rounding);
    euclidean_by(|job: &Job<E, A>| Some(model.run(job)), beats)
}

/// The functional model's dot product and norm over beats.
fn angular<const E: usize, const A: usize>(rounding: Rounding, beats: &[Beat<Binary32, A>]) -> [f32; 2] {
    let mut model = Functional::<E, A>::new(Rules::Paper).rounding(rounding);
    angular_by(|job: &Job<E, A>| Some(model.run(job)), beats)
}

/// The Euclidean sum over beats of a datapath that runs jobs; NaN without an outcome.
fn euclidean_by<const E: usize, const A: usize>(
    mut run: impl FnMut(&Job<E, A>) -> Option<Outcome>,
    beats: &[Beat<Binary32, E>],
) -> f32 {
    let sum = |beat: &Beat<Binary32, E>| match run(&Job::Euclidean(BeatInput { euclidean: *beat })) {
        Some(Outcome::Euclidean(output)) => output.euclidean_accumulator.into(),
        _ => f32::NAN,
    };
    beats.iter().map(sum).last().unwrap_or(f32::NAN)
}

/// The dot product and the norm over beats of a datapath that runs jobs; NaN without an outcome.
fn angular_by<const E: usize, const A: usize>(
    mut run: impl FnMut(&Job<E, A>) -> Option<Outcome>,
    beats: &[Beat<Binary32, A>],
) -> [f32; 2] {
    let sums = |beat: &Beat<Binary32, A>| match run(&Job::Angular(BeatInput { euclidean: *beat })) {
        Some(Outcome::Angular(output)) => [output.angular_dot_product.into(), output.angular_norm.into()],
        _ => [f32::NAN; 2],
    };
    beats.iter().map(sums).last().unwrap_or([f32::NAN; 2])
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
    fn euclidean<const E: usize, const A: usize>(self, rounding: Rounding, beats: &[Beat<Binary32, E>]) -> f32 {
        match self {
            Self::ShortWindow => in_short_window(beats, |[a, b]| (a - b) * (a - b)),
            Self::Expanded => beats.iter().flat_map(lanes).map(|[a, b]| a * a - 2.0 * a * b + b * b).sum(),
            _ => euclidean::<E, A>(rounding, &self.changed(beats)),
        }
    }

    fn angular<const E: usize, const A: usize>(self, rounding: Rounding, beats: &[Beat<Binary32, A>]) -> [f32; 2] {
        match self {
            Self::ShortWindow => [in_short_window(beats, |[a, b]| a * b), in_short_window(beats, |[_, b]| b * b)],
            _ => angular::<E, A>(rounding, &self.changed(beats)),
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
    use super::{Dyadic, PARTS, Sum, Tally, WRONG, add, check};
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
        assert!(PARTS.iter().all(|part| tally.largest(part) > 0.3), "{tally:?}");
        assert!(WRONG.iter().all(|(_, name)| tally.count(name) > 0), "{tally:?}");
    }

    /// Twelve thirds, and a sum with an error of one rounding more than the bound.
    #[test]
    fn wrong_sums_are_found() {
        let mut exact = Sum::default();
        (0..12).for_each(|_| exact.add(Dyadic::from(1.0 / 3.0)));
        let mut tally = Tally::default();
        let ulp = 2_f32.powi(-21);
        add(&mut tally, 0, 4.0 + 2.0 * ulp, &exact, 4);
        assert_eq!(tally.failures(), 0);
        add(&mut tally, 0, 4.0 + 3.0 * ulp, &exact, 4);
        assert_eq!(tally.failures(), 1);
    }
}
