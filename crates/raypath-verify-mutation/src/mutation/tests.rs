use super::trial::compared;
use super::*;
use raypath_float::Format;
use raypath_hdl::Builder;
use raypath_rtl::{Config, Interval, Lanes};
use raypath_verify::equivalence::Equivalence;

fn killed() -> Fate {
    Fate::Killed("lockstep".to_string())
}

#[test]
fn every_module_is_represented_and_the_larger_ones_more() {
    let subjects = subjects(&CONFIGS).expect("modules");
    let names: Vec<&str> = subjects.iter().map(|subject| subject.module.name()).collect();
    for name in ["raypath", "raypath_skid", "raypath_credit", "raypath_exit", "raypath_input", "raypath_output"] {
        assert!(names.contains(&name), "{name}: {names:?}");
    }
    assert!(names.iter().any(|name| name.contains("part_1_of_2")));
    let mutants = choose(&subjects, 2400, 1);
    assert!(mutants.len() >= 2000, "{}", mutants.len());
    let of = |subject: &FaultyModule| mutants.iter().filter(|mutant| std::ptr::eq(mutant.subject, subject)).count();
    for subject in &subjects {
        let (chosen, all) = (of(subject), subject.faults.len());
        assert!(chosen >= all.min(5) && chosen <= all, "{}: {chosen} of {all}", subject.module.name());
    }
    assert_eq!(choose(&subjects, 60, 1).len(), 60);
}

#[test]
fn shards_divide_the_mutants_and_the_user_can_stop() {
    let subjects = subjects(&[Config::DEFAULT.lanes(Lanes::None)]).expect("modules");
    let mutants = choose(&subjects, 100, 1);
    let mut judged = 0;
    for part in 1..=3 {
        let (mut watch, shard) = (|_| true, format!("{part}/3").parse().expect("a shard"));
        let mut request = Request::new(&mut watch);
        judged +=
            check_all(&subjects, &mutants, &mut request, shard, &|_| Ok(killed())).expect("a report").judged.len();
    }
    assert_eq!(judged, mutants.len());
    let mut watch = |step: raypath_verify::Progress| step.done < 3;
    let slow: Check<'_> = &|_| {
        std::thread::sleep(std::time::Duration::from_millis(20));
        Ok(killed())
    };
    let report = check_all(&subjects, &mutants, &mut Request::new(&mut watch), Shard::ALL, slow).expect("a report");
    assert!(report.is_stopped && report.judged.len() < mutants.len());
}

/// Runs `judge` on the faults of a configuration in these modules with these descriptions.
fn each(config: Config, faults: &[(&str, &str)], judge: impl Fn(&Trial<'_>) -> Fate) {
    let subjects = subjects(&[config]).expect("modules");
    for (module, description) in faults {
        let subject = subjects.iter().find(|subject| subject.module.name().starts_with(module)).expect("a module");
        let is_it = |fault: &&raypath_hdl::mutate::Fault| fault.to_string().contains(description);
        let fault = subject.faults.iter().find(is_it).unwrap_or_else(|| panic!("no fault {description} in {module}"));
        let fate = judge(&trial(&Mutant { subject, fault }).expect("a mutant"));
        assert!(!matches!(fate, Fate::Equivalent(_)), "{module}, {description}: {fate}");
    }
}

/// One obvious fault of each kind of module: the item's checks find it.
#[test]
fn the_checks_kill_obvious_faults() {
    let faults = [
        ("raypath_fp_add", "Add becomes Sub"),
        ("raypath_skid", "front_full_q: resets to 1"),
        ("raypath_output", "an arm left out"),
    ];
    each(Config::DEFAULT, &faults, |trial| {
        let fate = trial.run().expect("a fate");
        assert!(matches!(fate, Fate::Killed(_)), "{fate}");
        fate
    });
}

/// A wrong proof would hide faults that tests should kill. Those of control are not even asked about.
#[test]
fn visible_faults_are_not_proven_equivalent() {
    let config = Config::DEFAULT.lanes(Lanes::Two);
    let faults = [
        ("raypath_stage_9", "u_add_0.a_i: replaced by zero"),
        ("raypath_output", "Constant"),
        ("raypath_stage_4", "num_0_spare_q: never loads"),
        ("raypath_stage_10", "euclidean_advances: And becomes Or"),
    ];
    each(config, &faults, |trial| trial.proof().expect("a proof"));
    let faults = [("raypath_stage_4", "num_0_q: never loads"), ("raypath_stage_10", "u_add_0.a_i: replaced by zero")];
    each(config.interval(Interval::Four), &faults, |trial| {
        assert!(!trial.computes_the_operations().expect("a proof"), "other rounds have jobs too");
        trial.proof().expect("a proof")
    });
}

/// Faults that exchange the operands of adders are left out, because sums do not depend on the order.
#[test]
fn sums_do_not_depend_on_the_order_of_operands() {
    for format in [Format::BINARY32, Format::TF32, Format::BFLOAT16, Format::BINARY16] {
        let add = raypath_float::add(format, false).expect("an adder");
        let in_order = |names: [&str; 2]| {
            let m = Builder::new("sum");
            let [a, b] = ["a_i", "b_i"].map(|name| m.input(name, format.recoded_width()));
            m.output("sum_o", m.instance("u_add", &add, &[(names[0], a), (names[1], b)])[0]);
            m.finish().expect("a module")
        };
        let [sum, exchanged] = [["a_i", "b_i"], ["b_i", "a_i"]].map(in_order);
        assert_eq!(compared(&sum, &exchanged).expect("a result"), Equivalence::Proved, "{format}");
    }
}
