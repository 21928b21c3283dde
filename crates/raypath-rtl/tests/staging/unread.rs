//! Dead values are not in the hardware, unless their exceptions are an output.

use crate::common::drive::drive;
use crate::staging::{Input, Output, arithmetic, assert_within, units};
use raypath_float::flags;
use raypath_ops::{Circuit, Num, Operation, bundle};
use raypath_rtl::{Budget, DatapathNetlist, Error, Microarchitecture, Operations, UnitLatency, Units};

bundle! {
    /// One number from job to job.
    pub struct State<C> {
        pub kept: Num<C>,
    }
}

/// A running sum of products, with optional dead values: one of the previous state and one of the product.
struct Sum {
    has_unread: bool,
    is_auto: bool,
}

impl Operation for Sum {
    const NAME: &'static str = "sum";
    type Input<C: Circuit> = Input<C>;
    type Output<C: Circuit> = Output<C>;
    type State<C: Circuit> = State<C>;
    fn run<C: Circuit>(
        &self,
        c: C,
        Input { n: [a, b, d, e], flag }: Input<C>,
        state: State<C>,
    ) -> (Output<C>, State<C>) {
        if self.is_auto {
            c.auto();
        } else {
            c.stage(3, "product");
        }
        let product = a * b;
        if !self.is_auto {
            c.stage(4, "sum");
        }
        let sum = flag.select(state.kept, state.kept + product);
        if self.has_unread {
            let _before = flag.select(state.kept, d);
            let _after = ((sum + d) * e + product).compare(state.kept);
        }
        (Output { number: sum }, State { kept: sum })
    }
}

#[test]
fn dead_values_change_nothing() {
    for is_auto in [false, true] {
        for unit_latency in UnitLatency::REPRESENTATIVES {
            let microarchitecture = Microarchitecture { unit_latency, ..Microarchitecture::DEFAULT };
            let [without, with] = [false, true].map(|has_unread| {
                let set = Operations::new().with(&Sum { has_unread, is_auto }, 0).expect("an operation");
                DatapathNetlist::build(set, microarchitecture)
                    .unwrap_or_else(|error| panic!("automatic {is_auto}: {error}"))
            });
            assert_eq!(with.latency(), without.latency());
            assert_eq!(with.loops(), without.loops());
            for step in 0..=with.steps().count() {
                assert_eq!(with.units(step), without.units(step), "automatic {is_auto}, step {step}");
                assert_eq!(with.registers(step), without.registers(step), "automatic {is_auto}, step {step}");
            }
        }
    }
}

// Three of its four units are needed for their exceptions only.
operation!(Sums = "sums", |c, i| {
    c.auto();
    let [a, b, d, e] = i.n;
    let _unread = [a + d, b + e, d * e];
    Output { number: i.flag.select(a + b, a) }
});

/// Elaborates an operation with exception flags and a budget of `limits` in every stage.
fn flagged<O: Operation>(operation: &O, limits: Units) -> Result<DatapathNetlist, Error> {
    let set = Operations::new().within(Budget::by_stage(|_| limits)).exception_flags(true);
    set.with(operation, 0).and_then(DatapathNetlist::of)
}

#[test]
fn values_kept_for_their_exceptions_respect_the_budget() {
    let one = units(1, 1, 1);
    let datapath = flagged(&Sums, one).expect("room in ten stages");
    assert_within(&datapath, &Budget::by_stage(|_| one));
    let all = arithmetic(&datapath).into_iter().reduce(|a, b| (a.0 + b.0, a.1 + b.1, a.2 + b.2));
    assert_eq!(all, Some((3, 1, 0)));

    let error = flagged(&Sums, units(1, 0, 1)).expect_err("the product's exceptions are an output");
    assert!(matches!(error, Error::TooManyUnits { .. }), "{error}");
}

#[test]
fn exceptions_of_dead_values_are_an_output() {
    let datapath = flagged(&Sums, units(1, 1, 1)).expect("a datapath");
    for (numbers, expected) in [
        ([1.0, 2.0, 3.0, 4.0], 0),
        ([1.0, 2.0, f32::MAX, 4.0], flags::OVERFLOW | flags::INEXACT),
        ([f32::INFINITY, 2.0, f32::NEG_INFINITY, 4.0], flags::INVALID),
    ] {
        let numbers = numbers.into_iter().enumerate();
        let job = numbers.map(|(index, number)| (format!("n_{index}"), f32::to_bits(number).into())).collect();
        let (answers, _) = drive(&datapath, &[job]);
        assert_eq!(answers[0]["exception_flags"], expected, "{answers:?}");
    }
}

#[test]
fn too_long_a_chain_counts_where_its_exceptions_do() {
    operation!(Long = "long", |c, i| {
        c.auto();
        let _power = (0..12).fold(i.n[0], |power, _| power * i.n[1]);
        Output { number: i.n[2] + i.n[3] }
    });
    let set = |are_there| Operations::new().exception_flags(are_there).with(&Long, 0).and_then(DatapathNetlist::of);
    assert!(set(false).is_ok());
    let error = set(true).expect_err("12 units in 10 stages");
    assert!(matches!(error, Error::TooLong { needed: 12, last: 10, .. }), "{error}");
}
