//! The files that `raypath verify` writes and reads.

use super::{ends_with, file, folder, raypath, said, text};
use serde_json::Value;

#[test]
fn verify_writes_its_results() {
    let folder = folder();
    let path = text(&folder.path().join("results.json"));
    ends_with(&["verify", "sums", "--jobs", "20", "--seed", "3", "--out", &path], 0, &["All claims hold."]);
    let results: Value = serde_json::from_slice(&std::fs::read(&path).expect("a file")).expect("JSON");
    assert_eq!(
        (&results["level"], &results["seed"], &results["shard"]),
        (&"regression".into(), &3.into(), &"1/1".into())
    );
    let [item] = &results["items"].as_array().expect("items")[..] else { panic!("{results}") };
    assert_eq!((&item["name"], &item["verdict"]), (&"sums".into(), &"as claimed".into()));
    assert!(item["work"].as_str().is_some_and(|work| work.starts_with("120 sums")), "{item}");
    assert!(item["seconds"].as_f64().is_some_and(|seconds| seconds > 0.0), "{item}");
    // The commit is that of the sources, whatever folder the program runs in.
    let head = std::process::Command::new("git").args(["rev-parse", "HEAD"]).output();
    if let Some(head) = head.ok().filter(|head| head.status.success()) {
        assert_eq!(results["commit"], String::from_utf8_lossy(&head.stdout).trim());
        let since = said(&raypath(&["verify", "--since", &path]));
        assert!(since.starts_with("Verified: version "), "{since}");
    }
    let other = file(folder.path(), "other.json", "{}");
    ends_with(&["verify", "--since", &other], 2, &["other.json", "cannot read the results", "missing field"]);
}

/// Without a choice, level regression does the tenth of its work that belongs to the day.
#[test]
fn the_part_of_the_day_is_one_of_ten() {
    let program = said(&raypath(&["verify", "--help"]));
    assert!(program.contains("a tenth of its work"), "{program}");
    ends_with(
        &["verify", "sums", "--jobs", "20", "--shard", "3/10"],
        0,
        &["part 3 of 10; all claims of this part hold"],
    );
}
