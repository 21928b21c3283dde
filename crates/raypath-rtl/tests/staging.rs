//! Automatic staging: the paper's operations without their marks, compared with manual staging, and errors.

mod unread;

use crate::common::driver::compare;
use raypath_float::Format;
use raypath_ops::{Angular, Bit, Circuit, Euclidean, Num, Operation, RayBox, RayTriangle, Rounding, Rules, bundle};
use raypath_rtl::{
    Budget, Config, Control, DatapathNetlist, Error, Operations, STAGES, Sharing, UnitKind, UnitLatency, Units,
};
use raypath_sim::{Datapath, Words, jobs};
use std::collections::{BTreeMap, BTreeSet};

/// Adds the operations with these opcodes: triangles, boxes, Euclidean and angular distances.
fn with<const E: usize, const A: usize>(set: Operations, which: &[u64], rules: Rules) -> Result<Operations, Error> {
    let rounding = Rounding::Unit;
    which.iter().try_fold(set, |set, &which| match which {
        0 => set.with(&RayTriangle { rules, rounding }, which),
        1 => set.with(&RayBox { rules, is_conservative: false }, which),
        2 => set.with(&Euclidean::<E> { rounding }, which),
        _ => set.with(&Angular::<A> { rounding }, which),
    })
}

#[test]
fn sums_that_round_once_are_not_staged_automatically() {
    let set = Operations::new().auto().with(&Euclidean::<16> { rounding: Rounding::Sum }, 2);
    let error = set.expect_err("no automatic stages").to_string();
    assert!(error.contains("euclidean, which is staged automatically; expected marked stages"), "{error}");
}

/// A sum of three terms takes two stages, the marked one and the one before.
struct Early(u32);

impl Operation for Early {
    const NAME: &'static str = "early";
    type Input<C: Circuit> = Terms<C>;
    type Output<C: Circuit> = Total<C>;
    type State<C: Circuit> = ();

    fn run<C: Circuit>(&self, c: C, input: Terms<C>, _state: ()) -> (Total<C>, ()) {
        c.stage(self.0, "sum");
        (Total { total: Num::sum(input.term) }, ())
    }
}

bundle! {
    /// Three terms.
    pub struct Terms<C> {
        /// The terms.
        pub term: [Num<C>; 3],
    }

    /// The sum.
    pub struct Total<C> {
        /// The sum.
        pub total: Num<C>,
    }
}

#[test]
fn a_sum_begins_one_stage_before_it_is_available() {
    assert!(Operations::new().with(&Early(2), 0).and_then(DatapathNetlist::of).is_ok());
    let error = Operations::new().with(&Early(1), 0).expect_err("no stage 0").to_string();
    assert!(error.contains("is in stage 0, expected 1 to 10"), "{error}");
}

fn build<const E: usize, const A: usize>(set: Operations, which: &[u64], rules: Rules) -> DatapathNetlist {
    with::<E, A>(set, which, rules).and_then(DatapathNetlist::of).expect("a datapath")
}

const ALL: [u64; 4] = [1, 0, 2, 3];
const SETS: [(&str, &[u64]); 5] =
    [("quadbox", &[1]), ("triangle", &[0]), ("euclidean", &[2]), ("angular", &[3]), ("all four", &ALL)];

fn budget_of(datapath: &DatapathNetlist) -> Budget {
    Budget::by_stage(|stage| datapath.units(stage as usize))
}

fn live(datapath: &DatapathNetlist) -> u64 {
    (0..=STAGES as usize).map(|step| datapath.registers(step).live).sum()
}

fn assert_within(datapath: &DatapathNetlist, budget: &Budget) {
    for stage in 1..=STAGES {
        let (units, allowed) = (datapath.units(stage as usize), budget.units(stage));
        for kind in [UnitKind::Add, UnitKind::Multiply, UnitKind::Compare] {
            assert!(units.of(kind) <= allowed.of(kind), "stage {stage}: {units:?}, allowed {allowed:?}");
        }
    }
}

/// Prints the table of `docs/extending/staging.md`.
#[test]
fn registers_are_no_more_than_by_hand() {
    println!("| rules | operations | by hand | the same units | Table VIII | any units |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for rules in [Rules::Paper, Rules::Chisel] {
        let same = budget_of(&build::<16, 8>(Operations::new(), &ALL, rules));
        for (name, which) in SETS {
            let hand = build::<16, 8>(Operations::new(), which, rules);
            let cell = |datapath: &DatapathNetlist| format!("{} ({})", datapath.top().register_bits(), live(datapath));
            let mut row = vec![rules.to_string(), name.to_string(), cell(&hand)];
            for budget in [same, Budget::TABLE_VIII, Budget::UNLIMITED] {
                let auto = build::<16, 8>(Operations::new().auto().within(budget), which, rules);
                assert_eq!(auto.latency(), 12);
                assert!(auto.loops().is_empty(), "one job a cycle");
                assert_within(&auto, &budget);
                assert!(auto.top().register_bits() <= hand.top().register_bits(), "{rules}, {name}");
                assert!(live(&auto) <= live(&hand), "{rules}, {name}");
                row.push(cell(&auto));
            }
            println!("| {} |", row.join(" | "));
        }
    }
}

#[test]
fn other_lanes_need_no_more_either() {
    fn check<const E: usize, const A: usize>() {
        let hand = build::<E, A>(Operations::new(), &ALL, Rules::Paper);
        let budget = budget_of(&hand);
        let auto = build::<E, A>(Operations::new().auto().within(budget), &ALL, Rules::Paper);
        println!("{E} lanes: {} by hand, {} automatically", hand.top().register_bits(), auto.top().register_bits());
        assert_within(&auto, &budget);
        assert!(auto.top().register_bits() <= hand.top().register_bits(), "{E}");
    }
    check::<2, 1>();
    check::<4, 2>();
    check::<8, 4>();
    check::<32, 16>();
    check::<64, 32>();
}

/// Distances of few lanes need no units besides those of manually staged boxes and triangles.
#[test]
fn without_a_budget_others_units_are_used() {
    let hand = build::<4, 2>(Operations::new(), &[1, 0], Rules::Paper);
    let mixed = with::<4, 2>(Operations::new(), &[1, 0], Rules::Paper).map(Operations::auto);
    let mixed = mixed.and_then(|set| with::<4, 2>(set, &[2, 3], Rules::Paper)).and_then(DatapathNetlist::of);
    let mixed = mixed.expect("a datapath");
    assert!(mixed.loops().is_empty());
    assert_within(&mixed, &budget_of(&hand));
    // In the manual schedule, Euclidean distances have an adder of their own for the accumulator.
    let by_hand = build::<4, 2>(Operations::new(), &ALL, Rules::Paper);
    assert_eq!((by_hand.units(10).add, mixed.units(10).add), (1, 0));
}

#[test]
fn schedules_are_always_the_same() {
    let notes = || {
        let auto = build::<16, 8>(Operations::new().auto(), &ALL, Rules::Paper);
        (0..=STAGES as usize).map(|step| auto.schedule(step)).collect::<Vec<_>>()
    };
    assert_eq!(notes(), notes());
}

#[test]
fn stages_say_what_they_do() {
    let auto = build::<16, 8>(Operations::new().auto().within(Budget::TABLE_VIII), &ALL, Rules::Paper);
    let what = |stage: usize| auto.schedule(stage).into_iter().map(|note| note.what).collect::<Vec<_>>();
    assert_eq!(what(2), ["relative", "relative", "difference", ""]);
    assert_eq!(what(5)[1], "u_plus, u_minus, v_plus, v_minus, w_plus, 1 more");
    assert_eq!(what(9)[2], "sum");
}

#[test]
fn answers_are_those_of_the_operations() {
    let default = Config::DEFAULT;
    let configs = [
        (default, 4000),
        (default.unit_latency(UnitLatency::TWO), 500),
        (default.control(Control::Credit).unit_latency(UnitLatency::THREE), 500),
        (default.sharing(Sharing::Segregated), 500),
    ];
    let mut seen: BTreeMap<String, BTreeSet<u64>> = BTreeMap::new();
    let default_alone = &configs[..1];
    for (rules, budget, configs) in [
        (Rules::Paper, Budget::TABLE_VIII, &configs[..]),
        (Rules::Paper, Budget::UNLIMITED, default_alone),
        (Rules::Chisel, Budget::TABLE_VIII, default_alone),
    ] {
        for &(config, count) in configs {
            let set = with::<16, 8>(Operations::new().auto().within(budget), &ALL, rules).expect("operations");
            let datapath = DatapathNetlist::build(set, config.microarchitecture).expect("a datapath");
            let model = Datapath::paper(config.rules(rules)).model();
            let jobs: Vec<Words> = jobs::random(&model, Format::BINARY32, 1, config.kinds()).take(count).collect();
            for (port, values) in compare(config, &datapath, &model, &jobs) {
                seen.entry(port).or_default().extend(values);
            }
        }
    }
    // Triangles are hit and missed; zero to four boxes are hit, at many distances and in every order.
    assert_eq!((seen["is_intersect"].len(), seen["triangle_hit"].len()), (5, 2));
    assert!((0..4).all(|place| seen[&format!("tmin_{place}")].len() > 10));
    assert!((0..4).all(|place| seen[&format!("box_index_{place}")].len() == 4));
}

bundle! {
    /// A few numbers and a flag.
    pub struct Input<C> {
        /// The numbers.
        pub n: [Num<C>; 4],
        /// A flag.
        pub flag: Bit<C>,
    }

    /// One number.
    pub struct Output<C> {
        /// A number.
        pub number: Num<C>,
    }

    /// One number from job to job, and a flag.
    pub struct State<C> {
        /// The number.
        pub kept: Num<C>,
        /// The flag.
        pub was: Bit<C>,
    }
}

fn of<O: Operation>(operation: &O) -> DatapathNetlist {
    Operations::new().with(operation, 0).and_then(DatapathNetlist::of).expect("a datapath")
}

/// Compares the netlist of an operation with its model.
fn run(operation: impl Operation + Send + Sync + 'static, config: Config) {
    let datapath = Datapath::new().built_as(config.microarchitecture).with(operation);
    let model = datapath.model();
    let jobs: Vec<Words> = jobs::any_jobs(model.clone(), 1).take(500).collect();
    compare(config, &datapath.elaborate().expect("a datapath"), &model, &jobs);
}

fn arithmetic(datapath: &DatapathNetlist) -> Vec<(usize, usize, usize)> {
    let stages = (1..=STAGES as usize).map(|stage| datapath.units(stage));
    stages.map(|units| (units.add, units.multiply, units.compare)).collect()
}

fn units(add: usize, multiply: usize, compare: usize) -> Units {
    Units { add, multiply, compare, ..Units::default() }
}

operation!(Chained = "chained", |c, i| {
    c.auto();
    let n = i.n;
    let sum = n[0] + n[1];
    let largest = n.iter().fold(sum, |largest, n| largest.larger(*n));
    Output { number: largest * n[2] }
});

/// An adder depends on no other unit in its stage, and at most three comparators are in a chain.
#[test]
fn units_follow_the_rules_of_chaining() {
    let used = arithmetic(&of(&Chained));
    let first = used.iter().position(|units| units.0 == 1).expect("an adder");
    assert_eq!(used[first], (1, 0, 0));
    let compares: Vec<(usize, usize, usize)> = used.into_iter().filter(|units| units.2 > 0).collect();
    assert_eq!(compares.iter().map(|units| units.2).sum::<usize>(), 4);
    assert!(compares.len() >= 2 && compares.iter().all(|units| (units.0, units.1) == (0, 0)), "{compares:?}");
    run(Chained, Config::DEFAULT);
}

// State that passes through two units, a flag that becomes a constant, and units before and after.
operation!(Filter = "filter", |c, input, state| {
    c.auto();
    let [a, b, d, _] = input.n;
    let first = state.was.select(a, b);
    let kept = state.kept * d + (first + a) * b;
    let number = input.flag.select(state.kept, first * first);
    (Output { number }, State { kept: input.flag.select(c.zero(), kept), was: c.bit(true) })
});

#[test]
fn state_is_read_where_it_is_written() {
    for unit_latency in UnitLatency::REPRESENTATIVES {
        run(Filter, Config::DEFAULT.unit_latency(unit_latency));
    }
}

/// Stages 9 and 10 have an adder each, enough for the two sums, but then a job would have to wait.
#[test]
fn states_stay_together() {
    let set = with::<16, 8>(Operations::new(), &[2], Rules::Paper).map(Operations::auto);
    let beside = set.and_then(|set| with::<16, 8>(set, &[3], Rules::Paper)).and_then(DatapathNetlist::of);
    assert!(beside.expect("a datapath").loops().is_empty());
}

#[test]
fn stages_are_marked_or_not() {
    operation!(Mixed = "mixed", |c, i| {
        c.auto();
        let sum = i.n[0] + i.n[1];
        c.stage(4, "product");
        Output { number: sum * i.n[2] }
    });
    let error = Operations::new().with(&Mixed, 0).expect_err("both");
    assert!(matches!(error, Error::StagesMixed { stage: 4, .. }), "{error}");
    assert!(
        error.to_string().contains("marks stage 4") && error.to_string().contains("all stages marked or none"),
        "{error}"
    );
    // If marks are ignored, there is no conflict.
    assert!(Operations::new().auto().with(&Mixed, 0).and_then(DatapathNetlist::of).is_ok());
}

#[test]
fn too_long_a_chain_is_named() {
    operation!(Long = "long", |c, i| {
        c.auto();
        let n = i.n;
        let mut power = n[0] - n[1];
        for exponent in 2..13 {
            power = power * n[0];
            c.label(format_args!("power_{exponent}"), &power);
        }
        Output { number: power + n[2] }
    });
    let error = Operations::new().with(&Long, 0).expect_err("13 units in 10 stages");
    let Error::TooLong { chain, needed: 13, last: 10, .. } = &error else { panic!("{error}") };
    assert_eq!((chain.len(), chain[1].as_str(), chain[11].as_str()), (13, "power_2", "power_12"));
    assert!(error.to_string().contains("needs 13 stages, and there are 10: "), "{error}");
    assert!(error.to_string().contains("power_2 -> power_3"), "{error}");
}

#[test]
fn too_many_units_are_counted_where_they_are() {
    operation!(Sums = "sums", |c, i| {
        c.stage(2, "sums");
        let (a, b) = (i.n[0] + i.n[1], i.n[2] + i.n[3]);
        c.stage(3, "their product");
        Output { number: a * b }
    });
    let one = Budget::by_stage(|_| units(1, 1, 1));
    let marked = |budget| Operations::new().within(budget).with(&Sums, 0).and_then(DatapathNetlist::of);
    let error = marked(one).expect_err("two adders in stage 2");
    let Error::TooManyUnits { operation: "sums", shortages } = &error else { panic!("{error}") };
    let found: Vec<_> = shortages.iter().map(|s| (s.stage, s.kind, s.needed, s.allowed)).collect();
    assert_eq!(found, [(2, UnitKind::Add, 2, 1)]);
    assert!(error.to_string().contains("stage 2 needs 2 adders, 1 allowed; widen the budget or reduce"), "{error}");
    // It fits with automatic staging, and with a wider budget also with marks.
    let auto = Operations::new().auto().within(one).with(&Sums, 0).and_then(DatapathNetlist::of).expect("a datapath");
    assert_within(&auto, &one);
    let wider = Budget::by_stage(|stage| if stage == 2 { units(2, 1, 1) } else { one.units(stage) });
    assert!(marked(wider).is_ok());

    // No stage has two multipliers.
    let few = Budget::by_stage(|stage| if stage == 2 { units(2, 0, 0) } else { Units::default() });
    let error =
        Operations::new().auto().within(few).with(&Sums, 0).and_then(DatapathNetlist::of).expect_err("no multiplier");
    let Error::TooManyUnits { shortages, .. } = &error else { panic!("{error}") };
    let found: Vec<_> = shortages.iter().map(|s| (s.kind, s.needed, s.allowed)).collect();
    assert_eq!(found, [(UnitKind::Multiply, 1, 0)]);
    assert!(error.to_string().contains("needs 1 multiplier, 0 allowed"), "{error}");
    // The numbers in the message are sufficient.
    let offered = Budget::by_stage(|stage| {
        let more = shortages.iter().filter(|shortage| shortage.stage == stage).map(|shortage| shortage.needed).sum();
        Units { multiply: more, ..few.units(stage) }
    });
    let auto =
        Operations::new().auto().within(offered).with(&Sums, 0).and_then(DatapathNetlist::of).expect("a datapath");
    assert_within(&auto, &offered);
}

/// The units that Table VIII lacks for 64 lanes; a budget with these units is sufficient.
#[test]
fn what_is_offered_is_enough() {
    let wide = |budget| {
        let set = Operations::new().auto().within(budget).with(&Euclidean::<64> { rounding: Rounding::Unit }, 2);
        set.and_then(DatapathNetlist::of)
    };
    let error = wide(Budget::TABLE_VIII).expect_err("64 lanes");
    let Error::TooManyUnits { shortages, .. } = error else { panic!("{error}") };
    assert!(shortages.iter().any(|s| (s.stage, s.kind, s.needed, s.allowed) == (3, UnitKind::Multiply, 64, 24)));
    let offered = Budget::by_stage(|stage| {
        let mut units = Budget::TABLE_VIII.units(stage);
        for shortage in shortages.iter().filter(|shortage| shortage.stage == stage) {
            match shortage.kind {
                UnitKind::Add => units.add = shortage.needed,
                UnitKind::Multiply => units.multiply = shortage.needed,
                _ => units.compare = shortage.needed,
            }
        }
        units
    });
    assert_within(&wide(offered).expect("a datapath"), &offered);
}
