use super::symbolic::{Effect, effect};
use super::*;
use raypath_float::Format;
use raypath_hdl::Builder;
use raypath_hdl::mutate::{Fault, without_text};
use raypath_rtl::{Config, Control, Datapath, Interval, Lanes};
use raypath_verify::equivalence::Equivalence;
use raypath_verify_datapath::dataflow::still_computes;
use std::time::Duration;

/// The interval of 2,346 killed of 2,359, and its limits.
#[test]
fn the_interval_is_wilsons() {
    let interval = |faults, killed, equivalent| raypath_verify::score::Count { faults, killed, equivalent }.interval();
    let near = |[low, high]: [f64; 2], expected: [f64; 2]| {
        (low - expected[0]).abs() < 5e-5 && (high - expected[1]).abs() < 5e-5
    };
    assert!(near(interval(2441, 2346, 82), [0.9906, 0.9968]), "{:?}", interval(2441, 2346, 82));
    assert!(near(interval(10, 10, 0), [0.7225, 1.0]) && near(interval(10, 0, 0), [0.0, 0.2775]));
    assert_eq!(interval(3, 0, 3), [0.0, 1.0]);
}

/// Without checks the score is 0.
#[test]
fn without_checks_nothing_is_killed() {
    let subjects = subjects(&[Config::DEFAULT.lanes(Lanes::None)]).expect("modules");
    let mutants = choose(&subjects, 100, 1);
    let mut watch = |_| true;
    let report =
        check_all(&subjects, &mutants, &mut Request::new(&mut watch), &|_| Ok(MutantResult::Survived(String::new())))
            .expect("a report");
    let all = report.all();
    assert_eq!((all.killed, all.equivalent, all.survivors(), all.score()), (0, 0, mutants.len(), 0));
    let verdict = report.verdict();
    assert!(
        verdict.failures[0].contains("kill 0.00 % of the mutants, expected at least 99.00 %"),
        "{:?}",
        verdict.failures
    );
    assert_eq!(verdict.remarks.iter().filter(|remark| remark.starts_with("survivor: ")).count(), mutants.len());
}

#[test]
fn every_module_is_represented_and_the_larger_ones_more() {
    let subjects = subjects(&CONFIGS).expect("modules");
    let names: Vec<&str> = subjects.iter().map(|subject| subject.module.name()).collect();
    for name in ["raypath", "raypath_skid", "raypath_credit", "raypath_exit", "raypath_input", "raypath_output"] {
        assert!(names.contains(&name), "{name}: {names:?}");
    }
    assert!(
        names.contains(&"raypath_fp_add_e8s24_part_1_of_2") || names.iter().any(|name| name.contains("part_1_of_2"))
    );
    let mutants = choose(&subjects, 2400, 1);
    assert!(mutants.len() >= 2000, "{}", mutants.len());
    let of = |subject: &Subject| mutants.iter().filter(|mutant| std::ptr::eq(mutant.subject, subject)).count();
    for subject in &subjects {
        let (chosen, all) = (of(subject), subject.faults.len());
        assert!(chosen >= all.min(5) && chosen <= all, "{}: {chosen} of {all}", subject.module.name());
    }
    assert_eq!(choose(&subjects, 60, 1).len(), 60);
}

#[test]
fn the_user_can_stop() {
    let subjects = subjects(&[Config::DEFAULT.lanes(Lanes::None)]).expect("modules");
    let mutants = choose(&subjects, 1000, 1);
    let mut watch = |step: raypath_verify::Progress| step.done < 3;
    let slow: Check<'_> = &|_| {
        std::thread::sleep(Duration::from_millis(5));
        Ok(MutantResult::Killed("lockstep".into()))
    };
    let verdict = check_all(&subjects, &mutants, &mut Request::new(&mut watch), slow).expect("a report").verdict();
    assert!(verdict.is_stopped && verdict.failures.is_empty(), "{verdict:?}");
}

/// One obvious fault of each kind of module: the item's checks find it.
#[test]
fn the_checks_kill_obvious_faults() {
    let subjects = subjects(&CONFIGS[..1]).expect("modules");
    for (module, fault) in [
        ("raypath_fp_add", "Add becomes Sub"),
        ("raypath_skid", "front_full_q: resets to 1"),
        ("raypath_output", "an arm left out"),
    ] {
        let subject = subjects.iter().find(|subject| subject.module.name().starts_with(module)).expect("a module");
        let fault = subject.faults.iter().find(|found| found.to_string().contains(fault)).expect("a fault");
        let result = trial(&Mutant { subject, fault }).and_then(|trial| trial.run(false)).expect("a fate");
        assert!(matches!(result, MutantResult::Killed(_)), "{fault}: {result:?}");
    }
}

/// A wrong proof would hide faults that tests should kill.
#[test]
fn mutants_proven_equivalent_survive_every_check() {
    let config = Config::DEFAULT.lanes(Lanes::Two);
    let credit = config.control(Control::Credit);
    let all = subjects(&[config, credit]).expect("modules");
    proven_mutants_survive(&choose(&all, 300, 2));
    // In folded pipelines, many of these faults are constants beside the flags of operations that have few.
    let mut folded = subjects(&[config.interval(Interval::Four), credit.interval(Interval::Two)]).expect("modules");
    folded.retain(|subject| subject.module.name() == "raypath_stage_11");
    let is_beside_flags =
        |fault: &Fault| ["Constant", "in flags_d"].iter().all(|part| fault.to_string().contains(part));
    folded.iter_mut().for_each(|subject| subject.faults.retain(is_beside_flags));
    proven_mutants_survive(&choose(&folded, 12, 2));
}

fn proven_mutants_survive(mutants: &[Mutant<'_>]) {
    let mut proven = 0;
    for mutant in mutants {
        let trial = trial(mutant).expect("a mutant");
        if effect(trial.subject, &trial.module, &trial.top).expect("a proof") != Effect::None {
            continue;
        }
        let result = trial.run(false).expect("a fate");
        // The proof covers outcomes, not the words in registers that no job reads.
        let is_alike = match &result {
            MutantResult::Killed(check) => check == "canonical words",
            MutantResult::Equivalent(_) => true,
            MutantResult::Survived(_) => false,
        };
        assert!(is_alike, "{}: {result:?}", mutant.fault);
        proven += 1;
        if proven == 6 {
            break;
        }
    }
    assert!(proven >= 5, "{proven}");
}

/// Faults that change outcomes are not proven equivalent.
#[test]
fn visible_faults_are_not_proven_equivalent() {
    let faults = [
        ("raypath", "u_stage_3.num_0_i: replaced by zero"),
        ("raypath", "u_stage_3.opcode_i: replaced by zero"),
        ("raypath_input", "num_0_spare_q: never loads"),
        ("raypath_input", "num_0_q: loads in every cycle"),
        ("raypath_stage_4", "num_0_spare_q: never loads"),
        ("raypath_stage_9", "u_add_0.a_i: replaced by zero"),
        ("raypath_stage_10", "euclidean_advances: And becomes Or"),
        ("raypath_output", "Constant"),
    ];
    let config = Config::DEFAULT.lanes(Lanes::Two);
    not_proven(config, &faults);
    // In a folded pipeline: operands of a round, the round in which a register loads, and the exit.
    let faults = [
        ("raypath", "u_stage_3.num_0_i: replaced by zero"),
        ("raypath", "u_stage_3.opcode_i: replaced by zero"),
        ("raypath", "u_stage_3.at_5_i: replaced by zero"),
        ("raypath_input", "num_21_q: loads in every cycle"),
        ("raypath_stage_4", "num_0_q: never loads"),
        ("raypath_stage_10", "u_add_0.a_i: replaced by zero"),
        ("raypath_stage_11", "u_decode_num_0.recoded_i: replaced by zero"),
        ("raypath_output", "Constant"),
    ];
    not_proven(config.interval(Interval::Four), &faults);
}

fn not_proven(config: Config, faults: &[(&str, &str)]) {
    let subjects = subjects(&[config]).expect("modules");
    for (module, fault) in faults {
        let subject = subjects.iter().find(|subject| subject.module.name() == *module).expect("a module");
        let all: Vec<String> = subject.faults.iter().map(|fault| fault.to_string()).collect();
        let place = all.iter().position(|found| found.contains(fault)).unwrap_or_else(|| panic!("{fault}: {all:#?}"));
        let trial = trial(&Mutant { subject, fault: &subject.faults[place] }).expect("a mutant");
        assert_ne!(effect(trial.subject, &trial.module, &trial.top).expect("a proof"), Effect::None, "{}", all[place]);
        assert!(!trial.still_computes().expect("a proof"), "{}", all[place]);
    }
}

/// The netlist without a fault is proven, so that a proof can succeed at all.
#[test]
fn a_datapath_without_a_fault_still_computes() {
    for config in [CONFIGS[3], CONFIGS[8]] {
        let datapath = Datapath::new(config).expect("a datapath");
        let proof = still_computes(config, &without_text(datapath.top()), Duration::from_secs(60));
        assert!(proof.expect("a proof"), "{config}");
    }
}

/// Faults that exchange the operands of adders are left out, because sums do not depend on the order.
#[test]
fn sums_do_not_depend_on_the_order_of_operands() {
    for format in [Format::BINARY32, Format::TF32, Format::BFLOAT16, Format::BINARY16] {
        let add = raypath_float::add(format).expect("an adder");
        let in_order = |names: [&str; 2]| {
            let m = Builder::new("sum");
            let [a, b] = ["a_i", "b_i"].map(|name| m.input(name, format.recoded_width()));
            m.output("sum_o", m.instance("u_add", &add, &[(names[0], a), (names[1], b)])[0]);
            m.finish().expect("a module")
        };
        let [sum, exchanged] = [["a_i", "b_i"], ["b_i", "a_i"]].map(in_order);
        let found = trial::compared(&sum, &exchanged).expect("a result");
        assert_eq!(found, Equivalence::Proved, "{format}");
    }
}
