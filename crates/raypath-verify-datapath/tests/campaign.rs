//! Campaigns and geometry: they pass the datapath, follow from the seed, find deliberate faults, and say when stopped.

use raypath_verify::{Request, Verdict};
use raypath_verify_datapath::{ITEMS, campaign, models};
use std::path::Path;
use tempfile::TempDir;

/// The items, with numbers of jobs that suffice to find their deliberate faults.
const JOBS: [(&str, u64); 6] = [
    ("campaign", 8_192),
    ("models", 20_000),
    ("watertight", 100_000),
    ("boxes", 12_000),
    ("triangle-distance", 10_000),
    ("sums", 1_000),
];

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

fn verify(item: &str, jobs: u64, seed: u64, shard: &str, folder: &Path, goes_on: bool) -> Verdict {
    let shard = shard.parse().expect("a shard");
    let proceed = &mut |_| goes_on;
    let request = &mut Request { jobs: Some(jobs), seed, shard, ..Request::new(proceed) };
    let verdict = match item {
        "campaign" => campaign::verify(request, folder),
        "models" => models::verify(request, folder),
        item => (ITEMS.iter().find(|entry| entry.name == item).expect("an item").run)(request),
    };
    verdict.expect("a verdict")
}

#[test]
fn the_claims_hold() {
    let folder = folder();
    for (item, jobs) in JOBS {
        let verdict = verify(item, jobs, 11, "1/1", folder.path(), true);
        assert_eq!(verdict.failures, [""; 0], "{item}");
        assert!(!verdict.is_stopped && !verdict.remarks.is_empty(), "{item}: {verdict:?}");
    }
}

#[test]
fn a_seed_reproduces_shards_differ_and_a_stop_is_reported() {
    let folder = folder();
    for (item, _) in JOBS {
        let run = |seed, shard| verify(item, 1200, seed, shard, folder.path(), true);
        let table = || std::fs::read_to_string(folder.path().join("coverage.txt")).unwrap_or_default();
        let (first, points) = (run(1, "1/2"), table());
        assert_eq!((&run(1, "1/2"), table()), (&first, points.clone()), "{item}");
        // The covered work of `models` is a number of jobs and mistakes.
        if item != "models" {
            assert_ne!((run(2, "1/2"), table()), (first.clone(), points.clone()), "{item}");
            assert_ne!((run(1, "2/2"), table()), (first, points), "{item}");
        }
        assert!(verify(item, 1 << 40, 1, "1/1", folder.path(), false).is_stopped, "{item}");
    }
}
