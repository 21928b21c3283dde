//! Transaction files of added operations, whose columns are their ports.

use raypath_cli::prelude::*;
use raypath_model::Model;
use raypath_rtl::Config;
use raypath_sim::transactions::{Transaction, kind_named, read_from, text};
use raypath_sim::{InputError, OperationId, WordModel};
use std::path::Path;

bundle! {
    /// Two numbers with a tag.
    pub struct Tagged<C> {
        /// The tag.
        pub tag: Word<C, 5>,
        /// The numbers that are added.
        pub used: Flags<C, 2>,
        /// The numbers.
        pub number: [Num<C>; 2],
    }
}

bundle! {
    /// The sum.
    pub struct Total<C> {
        /// The sum of the selected numbers.
        pub total: Num<C>,
        /// Whether the sum is above 0.
        pub is_above: Bit<C>,
        /// The tag of the numbers.
        pub total_tag: Word<C, 5>,
    }
}

/// Two operations that add. The name of one is a prefix of the other's.
struct Sum<const IS_OF_TWO: bool>;

impl<const IS_OF_TWO: bool> Operation for Sum<IS_OF_TWO> {
    const NAME: &'static str = if IS_OF_TWO { "sum_of_two" } else { "sum" };
    type Input<C: Circuit> = Tagged<C>;
    type Output<C: Circuit> = Total<C>;
    type State<C: Circuit> = ();

    fn run<C: Circuit>(&self, c: C, Tagged { tag, used, number }: Tagged<C>, _: ()) -> (Total<C>, ()) {
        c.stage(2, "+");
        let counted = [0, 1].map(|i| used.0[i].select(number[i], c.zero()));
        let total = counted[0] + counted[1];
        c.stage(3, "above 0");
        (Total { total, is_above: total.is_above_zero(), total_tag: tag }, ())
    }
}

const CONFIG: Config = Config::DEFAULT;

fn model() -> WordModel {
    Datapath::paper(CONFIG).with(Sum::<false>).with(Sum::<true>).model()
}

fn read(name: &str, text: &str) -> Result<Vec<Transaction>, InputError> {
    read_from(text.as_bytes(), Path::new(name), None::<OperationId>, &model(), CONFIG)
}

fn fails(name: &str, text: &str) -> String {
    read(name, text).expect_err("a fault").to_string()
}

/// Computed by hand: 1.5 + 2.5 = 4 with the tag 1f; -1 alone; and a sum that is NaN, with a payload.
const LINES: &str = "0 7 1f 3 3fc00000 40200000 40800000 1 1f\n\
                     1 7 0 2 3fc00000 bf800000 bf800000 0 0\n\
                     2 7 3 3 7f800000 ff800000 ffc12345 0 3\n";

#[test]
fn columns_are_the_ports_in_their_order() {
    let mut model = model();
    let jobs = read("sum.txt", LINES).expect("transactions");
    assert_eq!(jobs.len(), 3);
    for Transaction { seq, category, job, expected } in &jobs {
        assert_eq!((job.kind().name(), *category), ("sum", 7));
        assert_eq!(model.run(job), *expected, "seq {seq}");
    }
    let names: Vec<String> = jobs[0].job.ports().into_iter().map(|port| port.name).collect();
    assert_eq!(names, ["tag", "used", "number_0", "number_1"]);
    // NaNs are written as the canonical NaN.
    let kind = kind_named("sum", &model).expect("an operation");
    assert_eq!(text(&model, kind, &jobs, CONFIG), LINES.replace("ffc12345", "7fc00000"));
}

#[test]
fn one_changed_digit_is_another_transaction() {
    let whole = read("sum.txt", LINES).expect("transactions");
    let mut model = model();
    for (digit, _) in LINES.lines().next().expect("a line").char_indices().filter(|(_, digit)| *digit != ' ') {
        let mut changed = LINES.to_string();
        let other = if &LINES[digit..=digit] == "1" { "0" } else { "1" };
        changed.replace_range(digit..=digit, other);
        match read("sum.txt", &changed) {
            Ok(jobs) => assert_ne!(jobs, whole, "digit {digit}"),
            Err(error) => panic!("digit {digit}: {error}"),
        }
    }
    // A changed outcome is found by comparison with the model.
    let changed = LINES.replacen("40800000 1 1f", "40800001 1 1f", 1);
    let jobs = read("sum.txt", &changed).expect("transactions");
    let differ: Vec<u64> =
        jobs.iter().filter(|wrong| model.run(&wrong.job) != wrong.expected).map(|wrong| wrong.seq).collect();
    assert_eq!(differ, [0]);
}

#[test]
fn a_file_has_the_operation_with_the_longest_matching_name() {
    let kind = |name: &str| read(name, LINES).map(|jobs| jobs[0].job.kind().name()).map_err(|error| error.to_string());
    assert_eq!(kind("sum.txt"), Ok("sum"));
    assert_eq!(kind("somewhere/sum_of_twelve.txt.gz"), Ok("sum"));
    assert_eq!(kind("Sum_of_two-3.txt"), Ok("sum_of_two"));
    let all = "expected triangle, quadbox, euclidean, angular, sum or sum_of_two";
    assert_eq!(
        kind("total.txt"),
        Err(format!("total.txt: the name begins with no kind of job, {all} (or give --kind)"))
    );
    let model = model();
    assert_eq!(kind_named("sum_of_two", &model).map(OperationId::name).ok(), Some("sum_of_two"));
    let error = kind_named("sum_of", &model).expect_err("a name");
    assert_eq!(error.to_string(), format!("'sum_of' is not a valid kind of job, {all}"));
}

#[test]
fn faults_name_field_value_and_what_was_expected() {
    let digits = "expected hexadecimal digits, at most";
    assert_eq!(
        fails("sum.txt", &LINES.replacen("1f", "20", 1)),
        format!("sum.txt:1: field 3 (tag) is '20', {digits} 1f")
    );
    assert_eq!(
        fails("sum.txt", &LINES.replacen(" 2 ", " 4 ", 1)),
        format!("sum.txt:2: field 4 (used) is '4', {digits} 3")
    );
    assert_eq!(
        fails("sum.txt", &LINES.replacen("40800000", "140800000", 1)),
        format!("sum.txt:1: field 7 (total) is '140800000', {digits} ffffffff")
    );
    assert_eq!(fails("sum.txt", "0 0 1 3 0\n"), "sum.txt:1: 5 fields, expected 9 for sum");

    // An operation that this datapath does not have.
    let alone = Datapath::new().with(Sum::<false>).model();
    let error =
        read_from(&b""[..], Path::new("angular.txt"), None::<OperationId>, &alone, CONFIG).expect_err("no such jobs");
    let error = error.to_string();
    assert!(error.starts_with("angular.txt: angular jobs, but the datapath (lanes 16, rules paper)"), "{error}");
    assert!(error.ends_with("expected sum"), "{error}");
}
