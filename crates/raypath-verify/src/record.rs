//! Records of verification runs: the command, commit, versions of programs, duration and result.
//!
//! A [`Recorder`] writes one JSON file for each item. [`table`] shows the records of a folder in Markdown. A record has
//! the hash of its item's subject: it is stale if the subject has changed since.

use crate::files::in_folder;
use crate::subjects::Subject;
use crate::{Error, Item, Request, Verdict};
use raypath_tools::{ToolError, digest, read, write};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

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

    /// Runs an item and writes its record, which replaces an earlier one of the item. A stopped run writes none.
    ///
    /// # Errors
    /// The item cannot run, the repository of this program's sources is missing, or a file cannot be written.
    pub fn run(&self, item: &Item, request: &mut Request<'_>) -> Result<Verdict, Error> {
        let subject = hash(&root(), item.subject)?;
        let (level, jobs, seed, shard) = (request.level, request.jobs, request.seed, request.shard);
        let mut command = format!("verify {} --level {} --seed {seed} --shard {shard}", item.name, level.name());
        command += &jobs.map_or(String::new(), |jobs| format!(" --jobs {jobs}"));
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
        let text =
            serde_json::to_string_pretty(record).map_err(|problem| ToolError::file(&path, "write", problem.into()))?;
        Ok(write(&path, &(text + "\n"))?)
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
        let record = |path: PathBuf| {
            let no_record = |problem: serde_json::Error| ToolError::file(&path, "read", problem.into());
            Ok(serde_json::from_slice(&read(&path)?).map_err(no_record)?)
        };
        paths.map(record).collect()
    }

    /// Whether the item's subject in the repository at `root` differs from the recorded one.
    ///
    /// # Errors
    /// The subject cannot be read.
    pub fn is_stale(&self, item: &Item, root: &Path) -> Result<bool, Error> {
        Ok(self.subject != Some(hash(root, item.subject)?))
    }
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

/// The SHA-256, in hexadecimal digits, of the files under these paths of the repository at `root`. Lines with only a
/// comment, empty lines and indentation have no effect.
fn hash(root: &Path, subject: &[&str]) -> Result<String, Error> {
    let mut files = Vec::new();
    for path in subject {
        collect(&root.join(path), &mut files)?;
    }
    files.sort();
    files.dedup();
    let mut bytes = Vec::new();
    for path in files {
        let text = read(&path)?;
        bytes.extend(path.strip_prefix(root).unwrap_or(&path).to_string_lossy().bytes());
        for line in String::from_utf8_lossy(&text).lines().map(str::trim) {
            if !line.is_empty() && !line.starts_with("//") {
                bytes.push(b'\n');
                bytes.extend(line.bytes());
            }
        }
        bytes.push(0);
    }
    Ok(digest(&bytes))
}

/// Adds a file, or all files in a folder and below.
fn collect(path: &Path, files: &mut Vec<PathBuf>) -> Result<(), Error> {
    if path.is_file() {
        files.push(path.to_path_buf());
        return Ok(());
    }
    for entry in in_folder(path)? {
        collect(&entry, files)?;
    }
    Ok(())
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
    use super::{Record, hash, table, time};
    use crate::Item;
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

    #[test]
    fn the_hash_depends_on_code_and_not_on_comments() {
        let folder = tempfile::tempdir().expect("a folder");
        let hash_of = |text: &str| {
            std::fs::write(folder.path().join("a.rs"), text).expect("a file");
            hash(folder.path(), &["a.rs"]).expect("a hash")
        };
        let first = hash_of("fn one() -> u32 {\n    1\n}\n");
        assert_eq!(hash_of("// One.\n\nfn one() -> u32 {\n1\n}"), first);
        assert_ne!(hash_of("fn one() -> u32 {\n    2\n}\n"), first);
        assert_eq!(first.len(), 64);
    }

    #[test]
    fn a_missing_path_is_an_error() {
        let folder = tempfile::tempdir().expect("a folder");
        let problem = hash(folder.path(), &["nothing"]).expect_err("no such path");
        assert!(problem.to_string().contains("nothing"), "{problem}");
    }
}
