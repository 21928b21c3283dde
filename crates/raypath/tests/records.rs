//! Records of verification runs, and their table in the documents.

use raypath_verify::ITEMS;
use raypath_verify::record::{Record, root, table};
use std::fs;
use std::process::Command;

/// The table of `docs/development/verification.md` equals that of `docs/records`. Results whose subject has changed are
/// marked as stale.
#[test]
fn the_table_of_results_follows_from_the_records() {
    let root = root();
    let path = root.join("docs/development/verification.md");
    let document = fs::read_to_string(&path).expect("the document");
    let records = Record::read_all(&root.join("docs/records")).expect("records");
    for record in &records {
        assert!(ITEMS.iter().any(|item| item.name == record.item), "a record of '{}', which is no item", record.item);
    }
    let table = table(ITEMS, &records, &root).expect("a table");
    let (before, rest) = document.split_once("## The items\n\n").expect("the heading");
    let (_, after) = rest.split_once("\n\n").expect("the end of the table");
    let expected = format!("{before}## The items\n\n{table}\n{after}");
    if std::env::var_os("RAYPATH_UPDATE").is_some() {
        fs::write(&path, expected).expect("the document");
        return;
    }
    assert!(
        document == expected,
        "docs/development/verification.md does not show docs/records as they are now, expected:\n{table}\
         help: RAYPATH_UPDATE=1 cargo test --profile tests --workspace --test integration records"
    );
}

#[test]
fn verify_writes_a_record_of_its_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |arguments: &[&str]| {
        let mut raypath = Command::new(env!("CARGO_BIN_EXE_raypath"));
        let raypath = raypath.arg("verify").args(arguments).args(["--jobs", "20", "--seed", "3", "--record"]);
        let output = raypath.arg(folder.path()).output().expect("the program");
        assert!(output.status.success(), "{output:?}");
    };
    run(&["sums"]);
    run(&["triangle-distance", "--rules", "chisel"]);
    let records = Record::read_all(folder.path()).expect("records");
    let [record, chosen] = &records[..] else { panic!("{} records", records.len()) };
    assert!(chosen.command.ends_with("--seed 3 --shard 1/1 --jobs 20 --rules chisel"), "{}", chosen.command);
    assert_eq!((record.item.as_str(), record.result.as_str()), ("sums", "as claimed"));
    assert!(record.command.contains("verify sums") && record.command.ends_with("--seed 3 --shard 1/1 --jobs 20"));
    assert!(record.covered.starts_with("120 sums") && record.seconds.is_some(), "{record:?}");
    assert!(record.versions["rustc"].starts_with("rustc 1."), "{:?}", record.versions);
    let item = ITEMS.iter().find(|item| item.name == "sums").expect("the item");
    assert!(!record.is_stale(item, &root()).expect("a subject"));
}
