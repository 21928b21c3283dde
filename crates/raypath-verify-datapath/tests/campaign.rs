//! Campaigns: they pass the datapath and the models, are reproducible by seed, and report their coverage when stopped.

use raypath_verify::{Progress, Request, Verdict};
use raypath_verify_datapath::{ITEMS, campaign, models};
use std::path::Path;
use tempfile::TempDir;

fn request<'a>(jobs: u64, seed: u64, proceed: &'a mut dyn FnMut(Progress) -> bool) -> Request<'a> {
    Request { jobs: Some(jobs), seed, ..Request::new(proceed) }
}

fn verdict(seed: u64, folder: &Path) -> Verdict {
    campaign::verify(&mut request(8192, seed, &mut |_| true), folder).expect("a verdict")
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

#[test]
fn the_datapath_is_as_claimed_and_a_seed_reproduces() {
    let first = folder();
    let second = folder();
    let [a, b] = [&first, &second].map(|folder| verdict(1, folder.path()));
    assert_eq!(a.failures, [""; 0]);
    assert_eq!(a.covered, b.covered);
    let table = |folder: &TempDir| std::fs::read_to_string(folder.path().join("coverage.txt")).expect("a table");
    assert_eq!(table(&first), table(&second));
    let other = folder();
    verdict(2, other.path());
    assert_ne!(table(&first), table(&other));
}

#[test]
fn a_stopped_campaign_reports_its_coverage() {
    let folder = folder();
    for item in ITEMS.iter().filter(|item| ["campaign", "models"].contains(&item.name)) {
        let mut looks = 0;
        let mut watch = |step: Progress| {
            looks += 1;
            assert!(step.done <= step.total);
            looks < 3
        };
        let request = &mut request(1 << 40, 1, &mut watch);
        let verdict = match item.name {
            "models" => models::verify(request, folder.path()),
            _ => campaign::verify(request, folder.path()),
        };
        let verdict = verdict.expect("a verdict");
        assert!(verdict.is_stopped && verdict.failures.is_empty(), "{verdict:?}");
        assert!(verdict.covered.contains("jobs") && verdict.remarks[0].contains("coverage"), "{verdict:?}");
    }
}

#[test]
fn the_models_answer_as_the_oracle_and_all_rules_are_exercised() {
    let folder = folder();
    let verdict = models::verify(&mut request(2_000_000, 3, &mut |_| true), folder.path()).expect("a verdict");
    assert_eq!(verdict.failures, [""; 0]);
    assert!(verdict.covered.starts_with("2097152 jobs"), "{}", verdict.covered);
}
