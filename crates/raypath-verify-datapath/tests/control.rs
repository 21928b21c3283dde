//! Proofs of the control: they hold for the design, and the same commands find deliberate faults.

use raypath_hdl::Builder;
use raypath_hdl::mutate::{Fault, faults};
use raypath_rtl::{Config, Control, DatapathNetlist, Interval, Lanes, UnitLatency};
use raypath_verify::safety::{CheckResult, ModelChecker, ModuleTexts, TextFault};
use raypath_verify_datapath::control::{data_faults, never_leaves, problems, structural_faults, together};
use std::sync::atomic::AtomicBool;

static GO: AtomicBool = AtomicBool::new(false);

fn config(control: Control) -> Config {
    Config::DEFAULT.control(control).lanes(Lanes::Two).unit_latency(UnitLatency::TWO)
}

/// A pipeline with a memory at its exit.
fn deep() -> Config {
    config(Control::Credit).lanes(Lanes::None).unit_latency(UnitLatency { sums: 5, products: 4 })
}

/// The result of the problem whose name begins with `name`, of a design with a fault.
fn result(config: Config, name: &str, fault: TextFault) -> Option<CheckResult> {
    let datapath = DatapathNetlist::new(config).expect("a datapath");
    let mut texts = ModuleTexts::new(datapath.top()).expect("text");
    assert!(texts.insert(fault), "{fault:?}");
    let all = problems(&datapath, config, &texts).expect("the text of a pipeline");
    let problem = all.iter().find(|problem| problem.name.starts_with(name)).expect("a problem");
    ModelChecker::find().expect("pyosys").check(problem, &GO).expect("a verdict")
}

/// The item proves that these problems hold without the fault.
#[test]
fn faults_are_found() {
    let (skid, credit) = (config(Control::Skid), config(Control::Credit));
    let deep = deep();
    let one = credit.unit_latency(UnitLatency::ONE);
    let folded = |control| Config::DEFAULT.control(control).lanes(Lanes::None).interval(Interval::Four);
    let (folded_skid, folded_credit) = (folded(Control::Skid), folded(Control::Credit));
    for (config, problem, module, from, to) in [
        // A job that arrives without ready.
        (skid, "raypath_input: ", "raypath_skid", "valid_i & spare_empty_q", "valid_i"),
        // A register that loads while it waits.
        (skid, "raypath_input: ", "raypath_skid", "= leaves & refill", "= refill"),
        // A ready that is the sink's.
        (skid, "raypath_input: ", "raypath_skid", "assign ready_o = spare_empty_q", "assign ready_o = ready_i"),
        // An accumulator that is written while it waits.
        (skid, "raypath_stage_9_2: ", "raypath_stage_9_2", "= advance & (data_i.opcode", "= valid_i & (data_i.opcode"),
        // A credit too many.
        (credit, "raypath_credit: ", "raypath_credit", "available_q <= |count_d", "available_q <= 1'b1"),
        // A job that enters a folded pipeline too early.
        (folded_credit, "raypath: raypath_order", "raypath_credit", "recent_q[1:0]", "2'b0"),
        // A job that moves on while the one before it waits.
        (folded_skid, "raypath_rounds: ", "raypath_rounds", "= ~(at_q[10] & ~free_10)", "= 1'b1"),
        // An opcode that is not loaded.
        (folded_skid, "raypath: raypath_order", "raypath_stage_2", "if (at_1_i)", "if (1'b0)"),
        // A job that overtakes those that wait at the exit.
        (one, "raypath_stage_11: raypath_order", "raypath_exit", "valid_i & (stored | ~leaves)", "valid_i & ~leaves"),
        // A job that passes those in the memory.
        (deep, "raypath_stage_11: raypath_order", "raypath_stage_11", "& ~is_any_waiting & (takes", "& (takes"),
        // A job that is read twice.
        (
            deep,
            "raypath_stage_11: raypath_order",
            "raypath_stage_11",
            "read_q      <= read_q + {5'd0, fetches}",
            "read_q <= read_q",
        ),
        // An output that changes while it is stalled.
        (one, "raypath: raypath_stall", "raypath_exit", "= leaves & (stored | valid_i)", "= stored | valid_i"),
        // A beat that reads before the one before has written.
        (skid, "raypath: raypath_beats", "raypath_stage_9_1", "= angular_pending_q & is_angular", "= 1'b0"),
    ] {
        let fault = TextFault { module, from, to };
        assert_eq!(result(config, problem, fault), Some(CheckResult::Fails), "{config}: {problem}, {fault:?}");
    }
}

#[test]
fn the_structure_holds_and_jobs_leave() {
    let checker = ModelChecker::find().expect("pyosys");
    for &control in Control::ALL {
        let config = config(control);
        let datapath = DatapathNetlist::new(config).expect("a datapath");
        assert_eq!(structural_faults(&datapath, config).expect("no loop"), Vec::<String>::new());
        let texts = ModuleTexts::new(datapath.top()).expect("text");
        let mut never = never_leaves(&datapath, config, &texts, "raypath_input");
        assert_eq!(checker.check(&never, &GO).expect("a verdict"), Some(CheckResult::Fails));
        let exit = datapath.module(datapath.steps().count() - 1).expect("a last step");
        let leaves = never_leaves(&datapath, config, &texts, exit.name());
        assert_eq!(checker.check(&leaves, &GO).expect("a verdict"), Some(CheckResult::Fails));
        // A wrong number of assertions is an error.
        never.assertions = 2;
        checker.check(&never, &GO).expect_err("one assertion and not two");
    }
}

/// Each fault of what loads and selects a word's registers, in a skid buffer, an exit of registers, and one of a memory.
#[test]
fn a_word_that_loads_without_the_opcode_is_found() {
    let credit = config(Control::Credit);
    for (config, from_last) in [(config(Control::Skid), 2), (credit, 1), (deep(), 1)] {
        let datapath = DatapathNetlist::new(config).expect("a datapath");
        let step = datapath.module(datapath.steps().count() - from_last).expect("a step");
        assert_eq!(together(step), Vec::<String>::new());
        let loads = |fault: &Fault| {
            let text = fault.to_string();
            let place = text.split(": ").next().unwrap_or_default();
            place.contains(" num_0_") && !place.ends_with("_d")
        };
        let all: Vec<Fault> = faults(step).into_iter().filter(loads).collect();
        assert!(all.len() > 10, "{all:?}");
        for fault in all {
            assert_ne!(together(&fault.apply(step).expect("a faulty step")), Vec::<String>::new(), "{fault}");
        }
    }
}

/// A valid that waits for a bit of the data, one cycle later.
#[test]
fn control_that_depends_on_data_is_found() {
    let faults = |reads_data: bool| {
        let m = Builder::new("raypath");
        let (valid, opcode, ready) =
            (m.input("input_valid_i", 1), m.input("opcode_i", 2), m.input("output_ready_i", 1));
        let data = m.input("data_i", 1);
        let (valid_q, data_q) = (m.register("valid_q", 1).reset_to(0), m.register("data_q", 1));
        let opcode_q = m.register("opcode_q", 2);
        let free = (!valid_q.wire() | ready).named("free");
        valid_q.next_when(free, if reads_data { valid & data } else { valid });
        data_q.next_when(free, data);
        opcode_q.next_when(free, opcode);
        m.output("input_ready_o", free);
        m.output("output_valid_o", valid_q.wire());
        m.output("opcode_o", opcode_q.wire());
        m.output("data_o", data_q.wire());
        data_faults(&m.finish().expect("a module")).expect("ports of the control")
    };
    assert_eq!(faults(false), Vec::<String>::new());
    assert_eq!(faults(true), ["the control depends on data_i"]);
}
