//! The table of records for the documents.

use super::Record;
use crate::error::Error;
use crate::verdict::Item;
use std::fmt::Write as _;
use std::path::Path;

/// A table in Markdown with a row for each item and its record. A record is shown as stale if its subject differs from
/// the one in the repository at `root`.
///
/// # Errors
/// A subject cannot be read.
pub fn table(items: &[Item], records: &[Record], root: &Path) -> Result<String, Error> {
    let mut text = "| item | claim | oracle | recorded run | command | commit | time | result |\n\
                    | --- | --- | --- | --- | --- | --- | --- | --- |\n"
        .to_string();
    for item in items {
        let found = records.iter().find(|record| record.item == item.name);
        let run = match found {
            None => "none | | | | not recorded".to_string(),
            Some(record) => {
                let stale = if record.is_stale(item, root)? { ", **stale**" } else { "" };
                let Record { covered, command, result, .. } = record;
                format!(
                    "{covered} | `{command}` | {} | {} | {result}{stale}",
                    commit(record),
                    record.seconds.map_or(String::new(), time)
                )
            }
        };
        // Writing to a String cannot fail.
        let _ = writeln!(text, "| `{}` | {} | {} | {run} |", item.name, item.claim, item.oracle);
    }
    Ok(text)
}

/// The abbreviated commit, and whether the files differed from it.
fn commit(record: &Record) -> String {
    let commit = record.commit.as_ref().map_or("unknown", |commit| commit.get(..7).unwrap_or(commit));
    let dirty = if record.is_dirty == Some(true) { ", changed" } else { "" };
    let note = if record.note.is_some() { " or earlier" } else { "" };
    format!("{commit}{dirty}{note}")
}

fn time(seconds: f64) -> String {
    let minutes = (seconds / 60.0).round() as u64;
    match seconds {
        ..100.0 => format!("{seconds:.0} s"),
        ..6000.0 => format!("{minutes} min"),
        _ => format!("{} h {} min", minutes / 60, minutes % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::{table, time};
    use crate::record::{Record, subject};
    use crate::verdict::Item;
    use std::collections::BTreeMap;

    const ITEM: Item = Item {
        name: "sums",
        claim: "sums are right",
        oracle: "exact arithmetic",
        subject: &["subject.rs"],
        run: |_| unreachable!("this test does not run the item"),
    };

    #[test]
    fn a_record_is_stale_after_its_subject_has_changed() {
        let folder = tempfile::tempdir().expect("a folder");
        let (root, file) = (folder.path(), folder.path().join("subject.rs"));
        std::fs::write(&file, "let a = 1;\n").expect("a file");
        let record = Record {
            item: "sums".to_string(),
            command: "verify sums --level full".to_string(),
            configuration: None,
            commit: Some("0123456789abcdef".to_string()),
            is_dirty: Some(false),
            subject: Some(subject::hash(root, ITEM.subject).expect("a hash")),
            versions: BTreeMap::new(),
            cores: 2,
            seconds: Some(40.4),
            result: "as claimed".to_string(),
            covered: "3 sums".to_string(),
            remarks: Vec::new(),
            failures: Vec::new(),
            note: None,
        };
        let row = |record: &Record| {
            let text = table(&[ITEM], std::slice::from_ref(record), root).expect("a table");
            text.lines().last().expect("a row").to_string()
        };
        let current = "| `sums` | sums are right | exact arithmetic | 3 sums | `verify sums --level full` | 0123456 | \
                       40 s | as claimed |";
        assert_eq!(row(&record), current);
        std::fs::write(&file, "let a = 2;\n").expect("a file");
        assert!(row(&record).ends_with("| as claimed, **stale** |"));
        assert!(row(&Record { subject: None, ..record.clone() }).ends_with("**stale** |"));
        assert!(row(&Record { is_dirty: Some(true), ..record }).contains("| 0123456, changed |"));
        assert!(table(&[ITEM], &[], root).expect("a table").ends_with("| none | | | | not recorded |\n"));
    }

    #[test]
    fn the_unit_of_a_time_depends_on_its_length() {
        assert_eq!([24.0, 660.0, 7505.0].map(time), ["24 s", "11 min", "2 h 5 min"]);
    }
}
