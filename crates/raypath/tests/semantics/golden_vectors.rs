//! The golden vectors under the rules `paper`: the same numbers, and other hits only where the rules differ.

use crate::recorded::golden;
use crate::semantics::answers::answers;
use crate::semantics::oracle::Oracle;
use raypath::model::Words;
use raypath::ops::{Job, Outcome, Rules};
use raypath::sim::transactions::Transaction;

fn jobs(golden: &[Transaction]) -> Vec<Job> {
    let job = |words: &Words| Job::from_ports(words.kind().paper().unwrap(), |name| words.port(name));
    golden.iter().map(|transaction| job(&transaction.job)).collect()
}

/// Rules decide hits, order and distances of boxes; they do not change the arithmetic.
#[test]
fn rules_paper_change_hits_and_no_arithmetic() {
    let golden = golden();
    let (mut triangles, mut boxes) = (0, 0);
    for (transaction, outcome) in golden.iter().zip(answers(Rules::Paper, &jobs(&golden))) {
        match (outcome, transaction.expected.paper_outcome().unwrap()) {
            (Outcome::Triangle(ours), Outcome::Triangle(theirs)) => {
                assert_eq!((ours.t_num, ours.t_denom), (theirs.t_num, theirs.t_denom), "seq {:x}", transaction.seq);
                triangles += usize::from(ours.triangle_hit != theirs.triangle_hit);
                // The condition of `paper` is the stricter one.
                assert!(bool::from(theirs.triangle_hit) || !bool::from(ours.triangle_hit));
            }
            (Outcome::Quadbox(ours), Outcome::Quadbox(theirs)) => boxes += usize::from(ours != theirs),
            (ours, theirs) => assert_eq!(ours, theirs, "seq {:x}: no rule touches a sum", transaction.seq),
        }
    }
    assert!(triangles > 100 && boxes > 500, "the rules differ in {triangles} triangles and {boxes} boxes");
}

/// The oracle of these tests equals the recorded numbers where the rules do not matter.
#[test]
fn the_oracle_agrees_with_the_original_arithmetic() {
    let mut oracle = Oracle::default();
    let golden = golden();
    for (job, transaction) in jobs(&golden).iter().zip(&golden) {
        match (oracle.run(job), transaction.expected.paper_outcome().unwrap()) {
            (Outcome::Triangle(ours), Outcome::Triangle(theirs)) => {
                assert_eq!((ours.t_num, ours.t_denom), (theirs.t_num, theirs.t_denom));
            }
            (Outcome::Quadbox(_), _) => {}
            (ours, theirs) => assert_eq!(ours, theirs),
        }
    }
}
