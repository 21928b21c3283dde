//! Records of verification runs: the command, commit, versions of programs, duration and result.
//!
//! A [`Recorder`] writes one JSON file for each item. [`table`] shows the records of a folder in Markdown. A record has
//! the hash of its item's subject: it is stale if the subject has changed since.

mod subject;
mod table;

pub use table::table;

use crate::error::Error;
use crate::files::in_folder;
use crate::request::Request;
use crate::verdict::{Item, Verdict};
use raypath_tools::{ToolError, read, write};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
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
        let subject = subject::hash(&root(), item.subject)?;
        let (level, jobs, seed, shard) = (request.level, request.jobs, request.seed, request.shard);
        let mut command = format!("verify {} --level {} --seed {seed} --shard {shard}", item.name, level.name());
        command += &jobs.map_or(String::new(), |jobs| format!(" --jobs {jobs}"));
        let begin = std::time::Instant::now();
        let verdict = (item.run)(request)?;
        if !verdict.is_stopped {
            self.write(&Record {
                item: item.name.to_string(),
                command,
                configuration: Some(request.config.to_string()),
                commit: self.commit.clone(),
                is_dirty: self.is_dirty,
                subject: Some(subject),
                versions: self.versions.clone(),
                cores: std::thread::available_parallelism().map_or(1, usize::from),
                seconds: Some(Duration::from_millis(begin.elapsed().as_millis() as u64).as_secs_f64()),
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
        Ok(self.subject != Some(subject::hash(root, item.subject)?))
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
