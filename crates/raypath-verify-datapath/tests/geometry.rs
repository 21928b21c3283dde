//! A few cases of each geometry item; `raypath verify` runs more.

use raypath_verify::{Request, Verdict};
use raypath_verify_datapath::ITEMS;

fn verify(item: &str, jobs: u64, seed: u64, shard: &str, go_on: bool) -> Verdict {
    let item = ITEMS.iter().find(|entry| entry.name == item).expect("an item");
    let shard = shard.parse().expect("a shard");
    let watch = &mut |_| go_on;
    (item.run)(&mut Request { jobs: Some(jobs), seed, shard, ..Request::new(watch) }).expect("a verdict")
}

/// The numbers of jobs are large enough that the campaigns must also find their deliberate faults.
#[test]
fn the_claims_hold() {
    for (item, jobs) in [("watertight", 100_000), ("boxes", 12_000), ("triangle-distance", 10_000), ("sums", 1000)] {
        let verdict = verify(item, jobs, 11, "1/1", true);
        assert_eq!(verdict.failures, Vec::<String>::new(), "{item}");
        assert!(!verdict.is_stopped && verdict.remarks.len() >= 3, "{item}: {verdict:?}");
    }
}

#[test]
fn a_seed_is_a_reproduction_and_shards_differ() {
    for item in ["watertight", "boxes", "triangle-distance", "sums"] {
        let verdict = verify(item, 1200, 1, "1/2", true);
        assert_eq!(verify(item, 1200, 1, "1/2", true), verdict, "{item}");
        assert_ne!(verify(item, 1200, 2, "1/2", true), verdict, "{item}");
        assert_ne!(verify(item, 1200, 1, "2/2", true), verdict, "{item}");
    }
}

#[test]
fn a_stopped_run_is_reported() {
    for item in ["watertight", "boxes", "triangle-distance", "sums"] {
        assert!(verify(item, 1_000_000_000, 1, "1/1", false).is_stopped, "{item}");
    }
}
