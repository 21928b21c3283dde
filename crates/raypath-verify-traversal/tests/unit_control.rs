//! Proofs of the control of the traversal unit: what the item does not run at level `regression`.

use raypath_verify_traversal::proofs::{Obligation, Setting, Variant, check};

/// A fourth of the faults. At level `full` the item refutes all of them.
#[test]
fn the_proofs_refute_faults() {
    let faults = |variant| Setting::least(variant, false).expect("a unit").faults().expect("texts");
    let obligations: Vec<Obligation> = Variant::ALL.into_iter().flat_map(faults).collect();
    assert!(obligations.len() > 60);
    let results = check(&obligations, "1/4".parse().expect("a shard"), &mut |_| true).expect("results");
    assert!(results.len() > 15, "{}", results.len());
    // A failure names the fault.
    results.into_iter().for_each(|result| assert_eq!(result, Some((false, None))));
}
