use super::*;
use rand::RngExt;
use raypath_model::WordModel;
use raypath_ops::{Binary32, Circuit, Narrowing, Single};
use raypath_verify_datapath::datapaths::TestedDatapath;
use raypath_verify_datapath::oracle::Mistake;

/// Otherwise the outcomes would not be compared, or a fault could be found by a wrong oracle. The item itself asks for
/// every operation that the oracle without a mistake refuses nothing.
#[test]
fn only_an_oracle_with_a_mistake_refuses_a_job_without_a_fault() {
    let wrong = |tested: &TestedDatapath, model: &WordModel| exact(tested, model).with(Mistake::TiesAway);
    for planned in plan().iter().filter(|planned| planned.tested.options().is_empty()) {
        assert_eq!(planned.subject(256, 1, &exact).refused, None);
        assert!(planned.subject(256, 1, &wrong).refused.is_some(), "{}", planned.flow.graph.name);
    }
}

/// A wrong proof would hide faults that oracles should find.
#[test]
fn faults_that_oracles_find_are_not_proven_equivalent() {
    let (z3, stop) = (SmtSolver::z3().expect("Z3"), AtomicBool::new(false));
    let small = ["triangle", "angular", "key_compare", "point_in_box", "sphere"];
    let all = plan();
    let mut asked = 0;
    for planned in all.iter().filter(|planned| small.contains(&planned.flow.graph.name)).step_by(5) {
        let (subject, flow) = (planned.subject(256, 1, &exact), &planned.flow);
        let is_killed = |fault: &usize| matches!(subject.judged(*fault).fate, Fate::Killed(_));
        let fault = (0..planned.faults.len()).rev().filter(is_killed).nth(20).expect("a fault");
        let faulty = planned.faults[fault].apply(flow);
        let known = Known::new(&z3, flow, subject.values.never_nan(flow), &stop).expect("lemmas");
        let questions = [true, false].map(|is_near| known.question(&faulty, is_near));
        let proved = question::answers(&z3, &questions, &stop).expect("answers");
        assert_eq!(proved, [false; 2], "{}: {}", subject.name, planned.faults[fault].text);
        asked += 1;
    }
    assert!(asked >= 3, "{asked}");
}

/// The laws by which questions know roundings, for the datapath's own rounding.
#[test]
fn roundings_without_margin_keep_the_order_and_rounded_numbers() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let narrow = |number: f32, to| Binary32.narrow(Single(number), to).0;
    for bits in 3..=24 {
        let both = [Narrowing::toward_zero(bits), Narrowing::away_from_zero(bits)];
        for to in both {
            for _ in 0..2000 {
                let a: u32 = random.random();
                // The other number is often next to a rounding of the first.
                let b = narrow(f32::from_bits(a), to).to_bits().wrapping_add_signed(random.random_range(-2..=2));
                let [a, b] = [a, if random.random() { b } else { random.random() }].map(f32::from_bits);
                let rounded = narrow(b, to);
                assert_eq!(narrow(rounded, to).to_bits(), rounded.to_bits(), "{b:e} {to:?}");
                assert!(a > rounded || narrow(a, to) <= rounded || a.is_nan() || b.is_nan(), "{a:e} {b:e} {to:?}");
                assert!(a < rounded || narrow(a, to) >= rounded || a.is_nan() || b.is_nan(), "{a:e} {b:e} {to:?}");
                if bits == 24 {
                    assert_eq!(narrow(a, both[0]).to_bits(), narrow(a, both[1]).to_bits(), "{a:e}");
                }
            }
        }
    }
}
