use super::replay::Replayed;
use super::staging::{StagingFate, check};
use super::*;
use rand::RngExt;
use raypath_ops::{Binary32, Circuit, Narrowing, RayBox, Rules, Single};
use raypath_sim::Datapath;
use raypath_sim::jobs::any_jobs;
use raypath_sim::lockstep::lockstep;
use raypath_sim::traffic::Traffic;
use raypath_verify_datapath::oracle::Mistake;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn all() -> Vec<Subject> {
    let mut watch = |_| true;
    subjects::all(&mut Request::new(&mut watch), 256, &right).expect("subjects")
}

fn right(tested: &Tested, model: &WordModel) -> Oracle {
    Oracle::new(tested.config.semantics, model)
}

/// Otherwise a fault could be found by a wrong oracle.
#[test]
fn no_oracle_refuses_a_job_without_a_fault() {
    for subject in all() {
        assert_eq!(subject.refused, None, "{}", subject.name);
    }
}

/// Otherwise the outcomes would not be compared.
#[test]
fn an_oracle_with_a_mistake_refuses_jobs() {
    let mut watch = |_| true;
    let wrong = |tested: &Tested, model: &WordModel| right(tested, model).with(Mistake::TiesAway);
    let subjects = subjects::all(&mut Request::new(&mut watch), 256, &wrong).expect("subjects");
    // Operations without roundings cannot show the mistake.
    let is_refused = |name: &str| subjects.iter().any(|subject| subject.name == name && subject.refused.is_some());
    assert!(["quadbox", "triangle", "euclidean", "angular"].into_iter().all(is_refused));
}

/// Without jobs nothing is killed, and the claim does not hold.
#[test]
fn without_jobs_nothing_is_killed() {
    let mut subjects = all();
    subjects.iter_mut().for_each(|subject| subject.jobs.steps.clear());
    let mut watch = |_| true;
    let report =
        check_all(&subjects, 20, &mut Request::new(&mut watch), &Solver::find().expect("Z3")).expect("a report");
    assert_eq!((report.count().faults, report.count().killed), (20, 0));
    let failures = report.verdict().failures;
    assert!(failures[0].contains("finds 0.00 % of the faults, expected at least 99.00 %"), "{failures:?}");
}

/// A wrong proof would hide faults that oracles should find.
#[test]
fn faults_that_oracles_find_are_not_proven_equivalent() {
    let (solver, stop) = (Solver::find().expect("Z3"), AtomicBool::new(false));
    let mut questions = Vec::new();
    let small = ["triangle", "angular", "key_compare", "point_in_box", "sphere"];
    for subject in all().iter().filter(|subject| small.iter().any(|name| subject.name.starts_with(name))) {
        let mut killed = (0..subject.faults.len()).rev().filter(|&fault| subject.fate(fault) == Fate::Killed);
        let faulty = subject.faults[killed.nth(20).expect("a fault")].apply(&subject.graph);
        let lemmas = solver.lemmas(&subject.graph, subject.values.never_nan(&subject.graph), &stop).expect("lemmas");
        let known = Known { graph: &subject.graph, lemmas: &lemmas };
        let ask = |scope| question::question(known, &faulty, scope);
        questions.extend(Scope::ALL.iter().filter_map(|&scope| ask(scope)));
    }
    assert!(questions.len() >= 12, "{}", questions.len());
    let proved = solver.prove(questions.clone(), &stop).expect("answers").expect("not stopped");
    let wrong = questions.iter().zip(proved).find(|(_, proved)| *proved);
    assert!(wrong.is_none(), "{wrong:?}");
}

/// The reason for this item: netlist and model agree about a fault of the source, and the oracle does not.
#[test]
fn netlist_and_model_agree_about_a_fault_that_the_oracle_finds() {
    let subjects = all();
    let subject = subjects.iter().find(|subject| subject.name == "quadbox").expect("a subject");
    let is_it = |fault: &faults::Fault| fault.text == "inside_0_tmin (Select(Number)): condition inverted";
    let fault = subject.faults.iter().position(is_it).expect("a fault");
    assert_eq!(subject.fate(fault), Fate::Killed);
    let graph = Arc::new(subject.faults[fault].apply(&subject.graph));
    let faulty = Datapath::new().with(Replayed { operation: RayBox { rules: Rules::Paper }, graph });
    let mut netlist = faulty.netlist(&faulty.elaborate().expect("a datapath")).expect("a netlist");
    let jobs = any_jobs(faulty.model(), 1).take(500);
    let found = lockstep(&mut netlist, faulty.model(), jobs, &mut Traffic::random(1), |_| true);
    assert_eq!((found.jobs, found.different), (500, 0), "{:?}", found.differences);
}

/// A dataflow that is run again is the operation.
#[test]
fn a_replayed_operation_is_the_operation() {
    let operation = RayBox { rules: Rules::Paper };
    let graph = Arc::new(graph::Graph::of(&operation));
    let replayed = Datapath::new().with(Replayed { operation, graph }).elaborate().expect("a datapath");
    let right = Datapath::new().with(operation).elaborate().expect("a datapath");
    let shape = |datapath: &raypath_rtl::Datapath| {
        let steps = 0..datapath.steps().count();
        steps.map(|step| (datapath.units(step), datapath.registers(step))).collect::<Vec<_>>()
    };
    assert_eq!(shape(&replayed), shape(&right));
}

#[test]
fn faults_of_staging_are_refused_or_harmless() {
    let mut watch = |_| true;
    let fates = check(&mut Request::new(&mut watch)).expect("fates");
    assert!(fates.iter().any(|(_, fate)| *fate == StagingFate::Refused), "{fates:?}");
    assert!(fates.iter().all(|(_, fate)| !matches!(fate, StagingFate::Wrong(_))), "{fates:?}");
}

/// The laws by which questions know roundings, for the datapath's own rounding.
#[test]
fn roundings_without_margin_keep_the_order_and_rounded_numbers() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let narrow = |number: f32, to| Binary32.narrow(Single(number), to).0;
    for bits in 3..=24 {
        for to in [Narrowing::toward_zero(bits), Narrowing::away_from_zero(bits)] {
            for _ in 0..2000 {
                let a: u32 = random.random();
                // The other number is often next to a rounding of the first.
                let b = narrow(f32::from_bits(a), to).to_bits().wrapping_add_signed(random.random_range(-2..=2));
                let [a, b] = [a, if random.random() { b } else { random.random() }].map(f32::from_bits);
                let rounded = narrow(b, to);
                assert_eq!(narrow(rounded, to).to_bits(), rounded.to_bits(), "{b:e} {to:?}");
                if a <= rounded {
                    assert!(narrow(a, to) <= rounded, "{a:e} {b:e} {to:?}");
                }
                if a >= rounded {
                    assert!(narrow(a, to) >= rounded, "{a:e} {b:e} {to:?}");
                }
                if bits == 24 {
                    let other = [Narrowing::toward_zero(bits), Narrowing::away_from_zero(bits)];
                    assert_eq!(narrow(a, other[0]).to_bits(), narrow(a, other[1]).to_bits(), "{a:e}");
                }
            }
        }
    }
}
