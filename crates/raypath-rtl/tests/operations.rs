//! Operations that are not in the paper: their elaboration, and errors.

use crate::common::drive::drive;
use raypath_float::Format;
use raypath_ops::{Bit, Circuit, Flags, Num, Operation, Word, bundle};
use raypath_rtl::{Config, Control, DatapathNetlist, Encoding, Error, Operations, Sharing, UnitLatency};

bundle! {
    /// Two numbers, a flag and a small word.
    pub struct Input<C> {
        /// A number.
        pub a: Num<C>,
        /// Another.
        pub b: Num<C>,
        /// A flag.
        pub flag: Bit<C>,
        /// A word.
        pub word: Word<C, 3>,
    }

    /// One of each.
    pub struct Output<C> {
        /// A number.
        pub number: Num<C>,
        /// A flag.
        pub is_so: Bit<C>,
        /// A word.
        pub code: Word<C, 3>,
    }

    /// One number from job to job.
    pub struct State<C> {
        /// The number.
        pub kept: Num<C>,
    }
}

/// Configurations that build the same operations differently.
fn configurations() -> Vec<Config> {
    let default = Config::DEFAULT;
    let mut all = Vec::new();
    for control in Control::ALL.iter().copied() {
        for unit_latency in UnitLatency::REPRESENTATIVES {
            all.push(default.control(control).unit_latency(unit_latency));
        }
        all.push(default.control(control).io(Encoding::Recoded));
        all.push(default.control(control).registers(Encoding::Ieee).sharing(Sharing::Segregated));
        all.push(default.control(control).io(Encoding::Recoded).registers(Encoding::Ieee));
    }
    all
}

/// Runs jobs (a, b, flag, word) in order and returns (number, is_so, code) of each, which are the same in every
/// configuration.
fn answers(operation: &impl Operation, jobs: &[(f32, f32, bool, u64)]) -> Vec<(f32, bool, u64)> {
    let expected = answers_of(operation, jobs, Config::DEFAULT);
    for config in configurations() {
        let found = answers_of(operation, jobs, config);
        let bits = |(number, is_so, code): &(f32, bool, u64)| (number.to_bits(), *is_so, *code);
        assert!(found.iter().map(bits).eq(expected.iter().map(bits)), "{config}: {found:?}, expected {expected:?}");
    }
    expected
}

/// The outcomes of one configuration. The first one appears after the latency of the configuration.
fn answers_of(operation: &impl Operation, jobs: &[(f32, f32, bool, u64)], config: Config) -> Vec<(f32, bool, u64)> {
    let operations = Operations::new().with(operation, 2).expect("an operation");
    let datapath = DatapathNetlist::build(operations, config.microarchitecture).expect("a datapath");
    let recoded = config.microarchitecture.io == Encoding::Recoded;
    let to_port =
        |value: f32| if recoded { Format::BINARY32.encode(value.to_bits().into()) } else { value.to_bits().into() };
    let from_port = |bits: u64| if recoded { Format::BINARY32.decode(bits) } else { bits };
    let given = jobs.iter().map(|&(a, b, flag, word)| {
        let ports = [("opcode", 2), ("a", to_port(a)), ("b", to_port(b)), ("flag", flag.into()), ("word", word)];
        ports.map(|(name, value)| (name.to_string(), value)).into()
    });
    let (answers, first) = drive(&datapath, &given.collect::<Vec<_>>());
    assert_eq!(first, datapath.latency(), "{config}");
    let number = |bits: u64| f32::from_bits(u32::try_from(from_port(bits)).expect("32 bits"));
    answers.iter().map(|ports| (number(ports["number"]), ports["is_so"] == 1, ports["code"])).collect()
}

fn flip_flops(operation: &impl Operation) -> u64 {
    let operations = Operations::new().with(operation, 0).expect("an operation");
    DatapathNetlist::of(operations).expect("a datapath").top().register_bits()
}

operation!(Mixed = "mixed", |c, i| {
    c.stage(2, "a + b, compared with a");
    let sum = i.a + i.b;
    let order = i.a.compare(i.b);
    c.stage(5, "times a");
    let product = sum * i.a;
    c.stage(9, "a relation, late; negation");
    Output { number: -product, is_so: order.greater_or_equal() | i.flag, code: i.word }
});

#[test]
fn values_arrive_wherever_they_are_read() {
    let jobs = [(1.5, 2.0, false, 5), (3.0, -2.0, false, 0), (-1.0, 4.0, true, 7), (f32::NAN, 1.0, false, 1)];
    let found = answers(&Mixed, &jobs);
    assert_eq!(found[..3], [(-5.25, false, 5), (-3.0, true, 0), (3.0, true, 7)]);
    // A negated NaN is canonical again at the port; no relation with it holds.
    assert_eq!((found[3].0.to_bits(), found[3].1, found[3].2), (0x7fc0_0000, false, 1));
}

operation!(Straight = "straight", |_c, i| Output { number: i.a, is_so: i.flag, code: i.word });

#[test]
fn inputs_may_be_outputs() {
    // No stage and no unit except conversions; subnormals and infinities pass unchanged.
    let jobs = [(1e-40, 0.0, true, 2), (f32::NEG_INFINITY, 0.0, false, 3), (-0.0, 0.0, true, 6)];
    let found = answers(&Straight, &jobs);
    assert_eq!(found.iter().map(|f| f.0.to_bits()).collect::<Vec<_>>(), jobs.map(|j| j.0.to_bits()));
    assert_eq!(found.iter().map(|f| (f.1, f.2)).collect::<Vec<_>>(), jobs.map(|j| (j.2, j.3)));
}

operation!(Constants = "constants", |c, i| {
    c.stage(3, "a test of a constant, read late");
    let is_so = c.infinity().is_above_zero();
    c.stage(9, "chosen by the flag");
    Output { number: i.flag.select(c.infinity(), c.zero()), is_so, code: c.word(5) }
});

operation!(ConstantBit = "constant_bit", |c, i| {
    c.stage(9, "the same, with no test");
    Output { number: i.flag.select(c.infinity(), c.zero()), is_so: c.bit(true), code: c.word(5) }
});

/// A test of a constant is a constant.
#[test]
fn constants_cost_no_registers() {
    let found = answers(&Constants, &[(0.0, 0.0, true, 0), (0.0, 0.0, false, 0)]);
    assert_eq!(found, [(f32::INFINITY, true, 5), (0.0, true, 5)]);
    assert_eq!(flip_flops(&Constants), flip_flops(&ConstantBit));
}

operation!(Scaled = "scaled", |c, i| {
    c.stage(2, "the word's value times a");
    let value = i.word.number();
    let product = value * i.a;
    c.stage(6, "of a constant, and of a word late");
    let late = c.word::<3>(5).number() + i.word.number();
    Output { number: product, is_so: late.compare(i.b).equal(), code: i.word }
});

#[test]
fn words_may_be_numbers() {
    let jobs: [(f32, f32, bool, u64); 8] = std::array::from_fn(|i| (-1.5, 9.0, false, i as u64));
    let expected: Vec<_> = (0..8).map(|i| (-1.5 * i as f32, i == 4, i as u64)).collect();
    let found = answers(&Scaled, &jobs);
    assert_eq!(found, expected);
    assert!(found[0].0.is_sign_negative(), "0 times a negative number");
}

bundle! {
    /// A word that narrow formats do not have.
    pub struct NineBits<C> {
        /// The word.
        pub word: Word<C, 9>,
    }
}

#[test]
fn words_that_the_format_does_not_have_are_refused() {
    operation!(Wide = "wide", |c, i| {
        c.stage(2, "the word's value");
        Output { number: i.word.number() * i.a, is_so: i.flag, code: i.word }
    });
    let wide = |s| Operations::new().format(Format::new(3, s).expect("a format")).with(&Wide, 0);
    let build = |s| DatapathNetlist::of(wide(s).expect("an operation"));
    assert!(build(3).is_ok());

    operation!(Nine = "nine", NineBits<C> => One<C>, |c, i| {
        c.stage(2, "the word's value");
        One { num: i.word.number() }
    });
    let nine = || Operations::new().with(&Nine, 0).expect("an operation");
    let error = DatapathNetlist::of(nine().format(Format::new(8, 8).expect("a format")));
    let said = error.expect_err("bfloat16 has no 257").to_string();
    assert!(said.contains("has 9 bits, expected 1 to 8"), "{said}");
}

// Keeps the largest number so far, and restarts if it was negative or the flag is set.
operation!(Largest = "largest", |c, i, state| {
    c.stage(6, "the larger of a and what is kept");
    let was_negative = state.kept.sign_bit();
    let larger = i.a.compare(state.kept).greater();
    let kept = (larger | was_negative).select(i.a, state.kept);
    (Output { number: kept, is_so: was_negative, code: i.word }, State { kept: i.flag.select(-i.b, kept) })
});

#[test]
fn state_may_be_compared_and_tested() {
    let jobs =
        [(1.0, 0.0, false, 0), (3.0, 0.0, false, 1), (2.0, 7.0, true, 2), (-9.0, 0.0, false, 3), (-8.0, 0.0, false, 4)];
    let expected = [(1.0, false, 0), (3.0, false, 1), (3.0, false, 2), (-9.0, true, 3), (-8.0, true, 4)];
    assert_eq!(answers(&Largest, &jobs), expected);
}

// A sum; jobs with the flag add to the previous sum: a loop through an adder.
operation!(Sum = "sum", |c, i, state| {
    c.stage(3, "a b");
    let product = i.a * i.b;
    c.stage(7, "accumulated");
    let kept = state.kept + product;
    (Output { number: kept, is_so: i.flag, code: i.word }, State { kept: i.flag.select(kept, c.zero()) })
});

#[test]
fn state_may_go_through_an_adder_of_several_steps() {
    let jobs =
        [(1.0, 2.0, true, 0), (3.0, 5.0, true, 1), (2.0, 7.0, false, 2), (9.0, 3.0, true, 3), (8.0, 1.0, true, 4)];
    let expected = [(2.0, true, 0), (17.0, true, 1), (31.0, false, 2), (27.0, true, 3), (35.0, true, 4)];
    assert_eq!(answers(&Sum, &jobs), expected);
    for config in configurations() {
        let operations = Operations::new().with(&Sum, 2).expect("an operation");
        let loops = DatapathNetlist::build(operations, config.microarchitecture).expect("a datapath").loops();
        let spacing = loops.first().map_or(1, |found| found.last - found.first + 1);
        assert_eq!(spacing, config.microarchitecture.unit_latency.sums, "{config}");
    }
}

/// Operations share adders, multipliers and registers: a second operation adds multiplexers only.
#[test]
fn operations_share_units_and_registers() {
    operation!(Double = "double", |c, i| {
        c.stage(2, "a - b");
        let difference = i.a - i.b;
        c.stage(5, "squared");
        Output { number: difference * difference, is_so: difference.sign_bit(), code: c.word(0) }
    });
    let both = Operations::new().with(&Mixed, 0).and_then(|set| set.with(&Double, 1)).expect("operations");
    let both = DatapathNetlist::of(both).expect("a datapath");
    let units = (both.units(2).add, both.units(2).compare, both.units(5).multiply);
    assert_eq!(units, (1, 1, 1));
    assert!(both.top().register_bits() <= flip_flops(&Mixed) + 2 * 12, "{}", both.top().register_bits());
}

#[test]
fn what_does_not_fit_is_refused() {
    operation!(TooEarly = "too_early", |c, i| {
        c.stage(5, "late");
        let late = i.a + i.b;
        c.label(format_args!("late"), &late);
        c.stage(3, "early");
        Output { number: late * late, is_so: i.flag, code: i.word }
    });
    let error = Operations::new().with(&TooEarly, 0).expect_err("used before made");
    assert!(matches!(error, Error::UsedBeforeMade { stage: 3, made: 5, .. }), "{error}");
    assert!(error.to_string().contains("late, which stage 5 computes"), "{error}");

    operation!(TooLate = "too_late", |c, i| {
        c.stage(11, "where numbers are decoded");
        Output { number: i.a + i.b, is_so: i.flag, code: i.word }
    });
    let error = Operations::new().with(&TooLate, 0).expect_err("no such stage");
    assert!(matches!(error, Error::NoSuchStage { stage: 11, last: 10, .. }), "{error}");

    operation!(Stageless = "stageless", |_c, i| Output { number: i.a + i.b, is_so: i.flag, code: i.word });
    assert!(matches!(Operations::new().with(&Stageless, 0), Err(Error::NoSuchStage { stage: 0, .. })));

    operation!(Apart = "apart", |c, i, state| {
        c.stage(4, "reads");
        let sum = state.kept + i.a;
        c.stage(7, "writes");
        (Output { number: sum, is_so: i.flag, code: i.word }, State { kept: sum * sum })
    });
    let error = Operations::new().with(&Apart, 0).expect_err("state apart");
    assert!(matches!(error, Error::StateApart { read: 4, made: 7, .. }), "{error}");

    let error = Operations::new().with(&Mixed, 1).and_then(|set| set.with(&Straight, 1)).expect_err("taken");
    assert_eq!(error.to_string(), "operation straight: opcode 1 is taken by mixed");
    let error = Operations::new().with(&Mixed, 64).expect_err("too large");
    assert_eq!(error.to_string(), "operation mixed: opcode 64 is too large, expected 0 to 63");
}

/// Each operation alone is valid. Together, the stage's adder would feed its multiplier, and the multiplier the adder.
#[test]
fn units_in_a_circle_are_refused() {
    operation!(SumFirst = "sum_first", |c, i| {
        c.stage(3, "(a + b) a");
        Output { number: (i.a + i.b) * i.a, is_so: i.flag, code: i.word }
    });
    operation!(ProductFirst = "product_first", |c, i| {
        c.stage(3, "a b + a");
        Output { number: i.a * i.b + i.a, is_so: i.flag, code: i.word }
    });
    assert_eq!(answers(&SumFirst, &[(2.0, 3.0, false, 0)])[0].0, 10.0);
    assert_eq!(answers(&ProductFirst, &[(2.0, 3.0, false, 0)])[0].0, 8.0);
    let both = Operations::new().with(&SumFirst, 0).and_then(|set| set.with(&ProductFirst, 1)).expect("operations");
    let error = DatapathNetlist::of(both).expect_err("a loop");
    assert!(
        error.to_string().starts_with("stage 3: the operations use its units in orders that form a combinational loop"),
        "{error}"
    );
}

bundle! {
    /// A port that [`Output`] has as one bit.
    pub struct Wider<C> {
        /// Four flags.
        pub is_so: Flags<C, 4>,
    }
}

// Has a port with the name of another operation's port, but another width.
operation!(FourFlags = "four_flags", Input<C> => Wider<C>, |_c, i| Wider { is_so: Flags([i.flag; 4]) });

bundle! {
    /// Two ports of one name.
    pub struct Twice<C> {
        /// `t_num`.
        pub t: One<C>,
        /// `t_num` again.
        pub t_num: Num<C>,
    }

    /// A number.
    pub struct One<C> {
        /// The number.
        pub num: Num<C>,
    }
}

operation!(TwoOfAName = "two_of_a_name", Input<C> => Twice<C>, |_c, i| Twice { t: One { num: i.a }, t_num: i.b });

/// Ports of one name are one port. Other types or widths are an error.
#[test]
fn ports_of_one_name_are_alike() {
    let straight = || Operations::new().with(&Straight, 0).expect("an operation");
    let error = straight().with(&FourFlags, 1).expect_err("other widths");
    let words = "operation four_flags: its port is_so_o is 4 bits, and that of straight 1 bit";
    assert!(error.to_string().starts_with(words), "{error}");
    assert!(straight().with(&Mixed, 1).is_ok(), "the same ports");
    let error = Operations::new().with(&TwoOfAName, 0).expect_err("a name twice");
    assert!(error.to_string().contains("its port t_num_o is a number, and that of two_of_a_name a number"), "{error}");
}

/// Assertions refer to states by name, with and without labels in the operation.
#[test]
fn assertions_of_a_state_without_labels_look_at_it() {
    for config in configurations() {
        let operations = Operations::new().with(&Sum, 2).expect("an operation");
        let text =
            DatapathNetlist::build(operations, config.microarchitecture).expect("a datapath").properties().to_string();
        assert!(text.contains("sum_kept_state") && !text.contains("()"), "{config}: an open port\n{text}");
    }
}
