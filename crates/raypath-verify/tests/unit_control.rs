//! Proofs of the control of the traversal unit: what the item does not run at its least level.

use raypath_verify::Shard;
use raypath_verify::unit::proofs::{Setting, check};

#[test]
fn the_proofs_refute_every_fault() {
    let setting = Setting::least(false).expect("a unit");
    let obligations = setting.faults().expect("texts");
    assert!(obligations.len() > 40);
    let results = check(&obligations, Shard::ALL, &mut |_| true).expect("results");
    for (obligation, result) in obligations.iter().zip(results) {
        let (is_proof, failure) = result.expect("a result");
        assert!(!is_proof && failure.is_none(), "{}: {failure:?}", obligation.problem.name);
    }
}
