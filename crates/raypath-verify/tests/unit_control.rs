//! Proofs of the control of the traversal unit: what the item does not run at its least level.

use raypath_verify::Shard;
use raypath_verify::unit::proofs::{Obligation, Setting, Variant, check};

#[test]
fn the_proofs_refute_every_fault() {
    let faults = |variant| Setting::least(variant, false).expect("a unit").faults().expect("texts");
    let obligations: Vec<Obligation> = Variant::ALL.into_iter().flat_map(faults).collect();
    assert!(obligations.len() > 60);
    let results = check(&obligations, Shard::ALL, &mut |_| true).expect("results");
    for (obligation, result) in obligations.iter().zip(results) {
        let (is_proof, failure) = result.expect("a result");
        assert!(!is_proof && failure.is_none(), "{}: {failure:?}", obligation.problem.name);
    }
}
