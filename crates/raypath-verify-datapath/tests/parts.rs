//! The verdict that is merged from the parts of shards is that of one machine.

use raypath_ops::Rules;
use raypath_rtl::{Config, DatapathNetlist};
use raypath_sim::engine::shape;
use raypath_verify::{Error, Request, Verdict};
use raypath_verify_datapath::campaign::verify_module;
use raypath_verify_datapath::{ITEMS, campaign, models};
use raypath_work::parts::{Part, Parts};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const SHARDS: u64 = 3;

/// The verdict of one machine, and the one that is merged.
fn verdicts(jobs: u64, run: &dyn Fn(&mut Request<'_>, bool) -> Result<Verdict, Error>) -> [Verdict; 2] {
    let verdict = |shard: &str, parts: Parts, is_whole: bool| {
        let watch = &mut |_| true;
        let shard = shard.parse().expect("a shard");
        let mut request = Request { jobs: Some(jobs), seed: 4, shard, parts, ..Request::new(watch) };
        let verdict = run(&mut request, is_whole).expect("a verdict");
        (verdict, request.parts)
    };
    let parts: Vec<(PathBuf, Part)> = (1..=SHARDS)
        .map(|number| {
            let shard = format!("{number}/{SHARDS}");
            let (_, parts) = verdict(&shard, Parts::saved(), false);
            let tasks = BTreeMap::from([("item".to_string(), parts.into_task(2.0).expect("a task"))]);
            (PathBuf::from(number.to_string()), Part { version: String::new(), work: String::new(), shard, tasks })
        })
        .collect();
    let merged = Parts::merged(&parts, "item", Path::new("parts")).expect("all shards");
    let (merged, parts) = verdict("1/1", merged, true);
    assert_eq!(parts.seconds(), Some(2.0 * SHARDS as f64));
    [verdict("1/1", Parts::default(), true).0, merged]
}

#[test]
fn merged_verdicts_are_those_of_one_machine() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, jobs) in [("campaign", 3000), ("models", 6000), ("watertight", 4000), ("boxes", 4000)] {
        let item = ITEMS.iter().find(|item| item.name == name).expect("an item");
        let [one, merged] = verdicts(jobs, &|request, _| match name {
            "campaign" => campaign::verify(request, folder.path()),
            "models" => models::verify(request, folder.path()),
            _ => (item.run)(request),
        });
        assert_eq!(one, merged, "{name}");
    }
}

/// The first failure is that of one machine, with the same files.
#[test]
fn a_merged_failure_is_that_of_one_machine() {
    let folder = tempfile::tempdir().expect("a folder");
    let expected = DatapathNetlist::new(Config::DEFAULT).expect("a datapath");
    let wrong = DatapathNetlist::new(Config::DEFAULT.rules(Rules::Chisel)).expect("a datapath");
    let shape = shape(Config::DEFAULT, &expected);
    let run = |request: &mut Request<'_>, is_whole: bool| {
        let folder = folder.path().join(if is_whole { "whole" } else { "shard" });
        verify_module(request, wrong.top(), &shape, &folder)
    };
    let [one, merged] = verdicts(256 * 30, &run);
    assert_eq!((one.failures.len(), &one.failures), (1, &merged.failures));
}
