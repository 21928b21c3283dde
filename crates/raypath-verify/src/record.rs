//! Records of verification runs: the command, commit, versions of programs, duration and result.
//!
//! A [`Recorder`] writes one JSON file for each item. [`table`] shows the records of a folder in Markdown. A record has
//! the hash of its item's subject: it is stale if the subject has changed since.

mod subject;

use crate::files::in_folder;
use crate::subjects::Subject;
use crate::{Error, Item, Request, Verdict};
use raypath_tools::{ToolError, read, write};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;
use subject::hash;

/// One run of an item.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// The item's name.
    pub item: String,
    /// The arguments of `raypath` that repeat the run.
    pub command: String,
    /// The configuration, which affects some items only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub configuration: Option<String>,
    /// The commit that was checked out. None outside of a Git repository.
    pub commit: Option<String>,
    /// Whether files outside of the folder of records differed from the commit. None if that is unknown.
    pub is_dirty: Option<bool>,
    /// The SHA-256 of the subject's source text. None if it is unknown.
    pub subject: Option<String>,
    /// The versions of the compiler and of the programs that the items run, as far as they are installed.
    pub versions: BTreeMap<String, String>,
    /// The processors of the machine.
    pub cores: usize,
    /// The duration in seconds. None if it is unknown.
    pub seconds: Option<f64>,
    /// "as claimed" or "wrong"; "incomplete" in records that were not written by a [`Recorder`].
    pub result: String,
    /// What the verdict covers: the cases run or the proofs made.
    pub covered: String,
    /// The verdict's remarks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<String>,
    /// The verdict's failures.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub failures: Vec<String>,
    /// The origin of a record that was not written by a [`Recorder`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// Writes records into a folder.
#[derive(Debug)]
pub struct Recorder {
    folder: PathBuf,
    commit: Option<String>,
    is_dirty: Option<bool>,
    versions: BTreeMap<String, String>,
}

/// The commands that print versions.
const VERSIONS: [(&str, &[&str]); 5] = [
    ("rustc", &["rustc", "--version"]),
    ("verilator", &["verilator", "--version"]),
    ("yosys", &["yosys", "-V"]),
    ("pyosys", &["python3", "-c", "from importlib.metadata import version; print(version('pyosys'))"]),
    ("opensta", &["sta", "-version"]),
];

impl Recorder {
    /// Creates the folder, and reads the commit and the versions of programs.
    ///
    /// # Errors
    /// The folder cannot be created.
    pub fn new(folder: &Path) -> Result<Self, Error> {
        fs::create_dir_all(folder).map_err(|problem| ToolError::file(folder, "create the folder", problem))?;
        let root = root();
        let commit = printed(&root, &["git", "rev-parse", "HEAD"]);
        let status = printed(&root, &["git", "status", "--porcelain", "--", ".", ":(exclude)docs/records"]);
        let version = |(name, command): (&str, &[&str])| Some((name.to_string(), printed(&root, command)?));
        Ok(Self {
            folder: folder.to_path_buf(),
            is_dirty: commit.as_ref().and(status).map(|changes| !changes.is_empty()),
            commit,
            versions: VERSIONS.into_iter().filter_map(version).collect(),
        })
    }

    /// Runs all of an item's work and writes its record, which replaces an earlier one of the item. A stopped run
    /// writes none.
    ///
    /// # Errors
    /// The item cannot run, the repository of this program's sources is missing, or a file cannot be written.
    pub fn run(&self, item: &Item, request: &mut Request<'_>) -> Result<Verdict, Error> {
        let subject = current_subject(item, &root())?;
        let (level, jobs, seed, shard) = (request.level, request.jobs, request.seed, request.shard);
        let mut command = format!("verify {} --level {} --seed {seed} --shard {shard}", item.name, level.name());
        command += &jobs.map_or(String::new(), |jobs| format!(" --jobs {jobs}"));
        let options = Subject::of(request).options();
        if !options.is_empty() {
            command += &format!(" {options}");
        }
        let begin = std::time::Instant::now();
        let verdict = (item.run)(request)?;
        if !verdict.is_stopped {
            self.write(&Record {
                item: item.name.to_string(),
                command,
                configuration: Some(Subject::of(request).to_string()),
                commit: self.commit.clone(),
                is_dirty: self.is_dirty,
                subject: Some(subject),
                versions: self.versions.clone(),
                cores: std::thread::available_parallelism().map_or(1, usize::from),
                seconds: Some(
                    request
                        .parts
                        .seconds()
                        .unwrap_or(Duration::from_millis(begin.elapsed().as_millis() as u64).as_secs_f64()),
                ),
                result: if verdict.failures.is_empty() { "as claimed" } else { "wrong" }.to_string(),
                covered: verdict.covered.clone(),
                remarks: verdict.remarks.clone(),
                failures: verdict.failures.clone(),
                note: None,
            })?;
        }
        Ok(verdict)
    }

    fn write(&self, record: &Record) -> Result<(), Error> {
        let path = self.folder.join(format!("{}.json", record.item));
        Ok(write(&path, &record.text().map_err(|problem| ToolError::file(&path, "write", problem.into()))?)?)
    }
}

impl Record {
    /// Reads all records of a folder, in the order of their files' names.
    ///
    /// # Errors
    /// A file cannot be read or is not a record.
    pub fn read_all(folder: &Path) -> Result<Vec<Self>, Error> {
        let is_record = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "json");
        let paths = in_folder(folder)?.into_iter().filter(is_record);
        paths.map(|path| Self::parse(&read(&path)?, &path)).collect()
    }

    /// Reads a record from the content of a file. `path` appears in messages.
    ///
    /// # Errors
    /// Content that is no record.
    pub fn parse(bytes: &[u8], path: &Path) -> Result<Self, Error> {
        Ok(serde_json::from_slice(bytes).map_err(|problem| ToolError::file(path, "read", problem.into()))?)
    }

    /// The content of the record's file.
    ///
    /// # Errors
    /// A duration that is not a number.
    pub fn text(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self).map(|text| text + "\n")
    }

    /// Whether the item's subject in the repository at `root` differs from the recorded one.
    ///
    /// # Errors
    /// The subject cannot be read.
    pub fn is_stale(&self, item: &Item, root: &Path) -> Result<bool, Error> {
        Ok(self.subject != Some(current_subject(item, root)?))
    }
}

/// The SHA-256 of an item's subject in the repository at `root`.
///
/// # Errors
/// The subject cannot be read.
pub fn current_subject(item: &Item, root: &Path) -> Result<String, Error> {
    hash(root, item.subject)
}

/// The repository from which this program was built.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The trimmed output of a command. None if it fails.
fn printed(folder: &Path, command: &[&str]) -> Option<String> {
    let [program, arguments @ ..] = command else { return None };
    let output = Command::new(program).args(arguments).current_dir(folder).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_string())
}

/// A line for each item whose record is missing or stale.
///
/// # Errors
/// A subject cannot be read.
pub fn stale(items: &[Item], records: &[Record], root: &Path) -> Result<Vec<String>, Error> {
    let line = |item: &Item| match records.iter().find(|record| record.item == item.name) {
        None => Ok(Some(format!("{}: not recorded", item.name))),
        Some(record) if record.is_stale(item, root)? => {
            Ok(Some(format!("{}: recorded at {}, its subject has changed since", item.name, commit(record))))
        }
        Some(_) => Ok(None),
    };
    items.iter().filter_map(|item| line(item).transpose()).collect()
}

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
    use super::{Record, hash, stale, table, time};
    use crate::Item;
    use std::collections::BTreeMap;

    const ITEM: Item = Item {
        name: "sums",
        claim: "sums are right",
        oracle: "exact arithmetic",
        subject: &["subject.rs"],
        has_configuration: false,
        regression_shard: "1/1",
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
            subject: Some(hash(root, ITEM.subject).expect("a hash")),
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
        let lines = |records: &[Record]| stale(&[ITEM], records, root).expect("lines");
        assert_eq!(lines(std::slice::from_ref(&record)), Vec::<String>::new());
        std::fs::write(&file, "let a = 2;\n").expect("a file");
        assert_eq!(lines(std::slice::from_ref(&record)), ["sums: recorded at 0123456, its subject has changed since"]);
        assert_eq!(lines(&[]), ["sums: not recorded"]);
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
