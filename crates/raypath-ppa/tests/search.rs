//! Searches of spaces whose metrics are all known, compared with the front of all configurations.

use raypath_ppa::explore::{
    Candidate, Goal, LinearPredictor, Metric, Outcome, Predicted, Predictor, Search, Status, Terms, Values,
};
use std::collections::BTreeSet;
use std::convert::Infallible;

/// A number from -1 to 1 that depends on all of these (SplitMix64).
fn random(numbers: &[u64]) -> f64 {
    let mixed = numbers.iter().fold(0_u64, |state, number| {
        let mut mixed = (state ^ number).wrapping_add(0x9e37_79b9_7f4a_7c15);
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    });
    (mixed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Candidates with their true metrics.
struct Space {
    candidates: Vec<Candidate>,
    truth: Vec<Values>,
}

/// Pipelines of 1 to 8 units of 1 to 4 steps with 0 to 3 rounds of registers, in boxes of 4 widths. Areas and periods
/// are linear in what is counted, but for noise of this relative size.
fn space(seed: u64, noise: f64) -> Space {
    let (mut candidates, mut truth) = (Vec::new(), Vec::new());
    for interval in [1.0, 2.0, 4.0, 8.0] {
        for steps in 1..=4 {
            for registers in 0..=3 {
                for bits in [10.0, 12.0, 14.0, 24.0] {
                    let (steps, registers) = (f64::from(steps), f64::from(registers));
                    let units = bits / interval;
                    let bits_of_registers = 3.0 * steps + registers * bits;
                    let depth = 20.0 / steps + bits / 12.0 + 2.0 * registers;
                    let area = Terms { known: units, terms: vec![bits_of_registers, interval, 1.0] };
                    let period = Terms { known: 0.0, terms: vec![depth, 1.0] };
                    let visits = 2000.0 / f64::powf(2.0, bits);
                    let exact = [(Metric::Throughput, 1.0 / interval), (Metric::Visits, visits)];
                    let place = truth.len() as u64;
                    let noisy = |of: u64, value: f64| value * (1.0 + noise * random(&[seed, place, of]));
                    let measured = [
                        (Metric::Area, noisy(0, units + 0.3 * bits_of_registers + 0.5 * interval + 2.0)),
                        (Metric::Period, noisy(1, 0.6 * depth + 1.0)),
                    ];
                    truth.push(measured.into_iter().chain(exact).collect());
                    candidates.push(Candidate {
                        name: format!("{interval} {steps} {registers} {bits}"),
                        options: String::new(),
                        exact: exact.into_iter().collect(),
                        terms: [(Metric::Area, area), (Metric::Period, period)].into_iter().collect(),
                    });
                }
            }
        }
    }
    Space { candidates, truth }
}

const OBJECTIVES: [Metric; 4] = [Metric::Area, Metric::Period, Metric::Throughput, Metric::Visits];

impl Space {
    /// The front of all configurations, by the definition: no other one that meets the goals is as good in every metric
    /// and better in one.
    fn front(&self, goals: &[Goal], objectives: &[Metric]) -> BTreeSet<usize> {
        let meets = |values: &Values| {
            goals.iter().all(|goal| match goal.metric {
                Metric::Throughput => values[&goal.metric] >= goal.limit,
                metric => values[&metric] <= goal.limit,
            })
        };
        let better = |a: &Values, b: &Values| {
            let compared = objectives.iter().map(|metric| match metric {
                Metric::Throughput => b[metric].total_cmp(&a[metric]),
                _ => a[metric].total_cmp(&b[metric]),
            });
            let compared: Vec<_> = compared.collect();
            compared.iter().all(|order| order.is_le()) && compared.iter().any(|order| order.is_lt())
        };
        let fit: Vec<usize> = (0..self.truth.len()).filter(|place| meets(&self.truth[*place])).collect();
        let is_best = |place: &usize| !fit.iter().any(|other| better(&self.truth[*other], &self.truth[*place]));
        fit.iter().copied().filter(is_best).collect()
    }

    fn search(&self, predictor: &dyn Predictor, goals: &[Goal], objectives: &[Metric]) -> (Outcome, Vec<usize>) {
        self.search_within(predictor, goals, objectives, usize::MAX)
    }

    /// Searches with a budget. Returns the outcome, and the measured configurations in their order.
    fn search_within(
        &self,
        predictor: &dyn Predictor,
        goals: &[Goal],
        objectives: &[Metric],
        budget: usize,
    ) -> (Outcome, Vec<usize>) {
        let search = Search { candidates: &self.candidates, predictor, goals, objectives, first: 8, batch: 4 };
        let mut measured = Vec::new();
        let outcome = search.run(|wanted| {
            let mut one = |candidate: &usize| {
                assert!(!measured.contains(candidate), "{candidate} is measured twice");
                (measured.len() < budget).then(|| {
                    measured.push(*candidate);
                    let values = self.truth[*candidate].iter().filter(|(metric, _)| metric.is_measured());
                    values.map(|(metric, value)| (*metric, *value)).collect()
                })
            };
            Ok::<_, Infallible>(wanted.iter().map(&mut one).collect())
        });
        let Ok(outcome) = outcome;
        assert_eq!(outcome.measured(), measured.len());
        (outcome, measured)
    }
}

fn front(outcome: &Outcome) -> BTreeSet<usize> {
    outcome.with(Status::Front).into_iter().collect()
}

fn goals(texts: &[&str]) -> Vec<Goal> {
    texts.iter().map(|text| text.parse().expect("a goal")).collect()
}

#[test]
fn the_front_is_that_of_all_configurations_with_fewer_measurements() {
    let space = space(0, 0.0);
    let predictor = LinearPredictor { candidates: &space.candidates };
    for (texts, objectives, most) in [
        (&[][..], &OBJECTIVES[..], 80),
        (&["area<=15mm2", "throughput>=0.5", "visits<=1%"], &OBJECTIVES, 20),
        (&["period<=9ns"], &[Metric::Area], 15),
        (&[], &[Metric::Area, Metric::Period], 30),
    ] {
        let goals = goals(texts);
        let (outcome, measured) = space.search(&predictor, &goals, objectives);
        let expected = space.front(&goals, objectives);
        assert!(!expected.is_empty());
        assert_eq!(front(&outcome), expected, "{texts:?}");
        let (measured, all) = (measured.len(), space.truth.len());
        assert!(measured <= most, "{texts:?}: {measured} of {all} measured");
    }
}

/// A predictor that is as wrong as it states, in directions that a seed chooses.
struct Wrong<'s> {
    space: &'s Space,
    seed: u64,
    part: f64,
}

impl Predictor for Wrong<'_> {
    fn predict(&self, metric: Metric, _: &[(usize, f64)], wanted: &[usize]) -> Vec<Predicted> {
        let predict = |candidate: &usize| {
            let sign = random(&[self.seed, *candidate as u64, metric as u64]).signum();
            let error = self.part * self.space.truth[*candidate][&metric];
            // A little less than the stated error, because sums are rounded.
            Predicted { value: self.space.truth[*candidate][&metric] + 0.999_999 * sign * error, error }
        };
        wanted.iter().map(predict).collect()
    }
}

#[test]
fn a_predictor_that_is_wrong_within_its_error_finds_the_front() {
    let goals = goals(&["area<=20mm2", "visits<=1%"]);
    for seed in 0..20 {
        let space = space(seed, 0.2);
        for part in [0.02, 0.1, 0.3] {
            let (outcome, measured) = space.search(&Wrong { space: &space, seed, part }, &goals, &OBJECTIVES);
            assert_eq!(front(&outcome), space.front(&goals, &OBJECTIVES), "seed {seed}, {part}");
            assert!(measured.len() < space.truth.len());
            assert_eq!(outcome.within_errors(Metric::Area).0, outcome.within_errors(Metric::Area).1);
        }
    }
}

/// A check of the test above: if the stated errors are too small, the front is not found.
#[test]
fn a_predictor_that_understates_its_error_misses_the_front() {
    struct Sure<'s>(Wrong<'s>);
    impl Predictor for Sure<'_> {
        fn predict(&self, metric: Metric, known: &[(usize, f64)], wanted: &[usize]) -> Vec<Predicted> {
            let found = self.0.predict(metric, known, wanted).into_iter();
            found.map(|predicted| Predicted { error: 0.01 * predicted.error, ..predicted }).collect()
        }
    }
    let missed = (0..20).filter(|seed| {
        let space = space(*seed, 0.2);
        let sure = Sure(Wrong { space: &space, seed: *seed, part: 0.3 });
        let (outcome, _) = space.search(&sure, &[], &OBJECTIVES);
        let (within, compared) = outcome.within_errors(Metric::Area);
        assert!(within < compared);
        front(&outcome) != space.front(&[], &OBJECTIVES)
    });
    let missed = missed.count();
    assert!(missed > 5, "{missed} of 20");
}

/// Within a budget, the search ends with open configurations; with a larger one it measures the same ones first.
#[test]
fn a_budget_ends_a_search_that_goes_on_from_there() {
    let space = space(1, 0.05);
    let predictor = LinearPredictor { candidates: &space.candidates };
    let (whole, order) = space.search(&predictor, &[], &OBJECTIVES);
    assert!(whole.with(Status::Open).is_empty());
    for budget in [0, 3, 8, 21] {
        let (outcome, measured) = space.search_within(&predictor, &[], &OBJECTIVES, budget);
        assert_eq!(measured, order[..budget]);
        assert!(!outcome.with(Status::Open).is_empty());
        // What is on the whole front is open, or measured and on the front.
        let open: BTreeSet<usize> = outcome.with(Status::Open).into_iter().chain(front(&outcome)).collect();
        assert!(front(&whole).is_subset(&open) || budget > 8);
    }
}

#[test]
fn exact_goals_exclude_without_measurement() {
    let space = space(2, 0.0);
    let predictor = LinearPredictor { candidates: &space.candidates };
    let limits = goals(&["throughput>=1", "visits<=0.2%"]);
    let (outcome, measured) = space.search(&predictor, &limits, &OBJECTIVES);
    let exact = |place: &usize| &space.candidates[*place].exact;
    let meets = |place: &usize| exact(place)[&Metric::Throughput] >= 1.0 && exact(place)[&Metric::Visits] <= 0.2;
    assert!(measured.iter().all(meets));
    let excluded = outcome.with(Status::Excluded);
    assert_eq!(excluded.len(), (0..space.truth.len()).filter(|place| !meets(place)).count());
    assert!(outcome.found[excluded[0]].predicted.is_empty());
    // Goals that nothing meets.
    let (outcome, measured) = space.search(&predictor, &goals(&["throughput>=2"]), &OBJECTIVES);
    assert_eq!((measured.len(), outcome.with(Status::Excluded).len()), (0, space.truth.len()));
    let (outcome, _) = space.search(&predictor, &goals(&["area<=0.1mm2"]), &OBJECTIVES);
    assert!(front(&outcome).is_empty() && outcome.with(Status::Open).is_empty());
}
