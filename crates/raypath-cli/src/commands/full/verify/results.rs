//! The results of a run of `raypath verify` in a file: what was verified, with what, and how it ended.

use crate::{Build, CliError};
use raypath_sim::files::write_all;
use raypath_tools::{ToolError, read, versions};
use raypath_verify::{Item, Level, Shard, Verdict};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::process::Command;

/// What `raypath verify --out` writes.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Results {
    /// The version of raypath.
    version: String,
    /// The commit that the program was built from. None if it is unknown.
    commit: Option<String>,
    /// Whether the sources of the program were those of the commit.
    is_clean: bool,
    /// The digest of `Cargo.lock`, as `git hash-object` prints it.
    lock: Option<String>,
    /// The versions of the programs that items use, as far as they are installed.
    programs: BTreeMap<String, String>,
    /// The processors of the machine.
    cores: usize,
    level: String,
    seed: u64,
    /// The part of the work: "1/1" is all of it.
    shard: String,
    items: Vec<ItemResult>,
}

/// The result of an item.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ItemResult {
    name: String,
    claim: String,
    oracle: String,
    /// What was run or proved, with numbers.
    work: String,
    seconds: f64,
    /// "as claimed", "wrong", or "not run".
    verdict: String,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    remarks: Vec<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    failures: Vec<String>,
}

impl Results {
    /// The results of no item.
    pub fn new(level: Level, seed: u64, shard: Shard) -> Self {
        let Build { commit, is_clean, lock } = Build::current();
        Self {
            version: env!("CARGO_PKG_VERSION").to_string(),
            commit: commit.map(str::to_string),
            is_clean,
            lock: lock.map(str::to_string),
            programs: BTreeMap::new(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            level: level.name().to_string(),
            seed,
            shard: shard.to_string(),
            items: Vec::new(),
        }
    }

    /// Adds the result of an item that took `seconds`.
    pub fn add(&mut self, item: &Item, verdict: &Verdict, seconds: f64) {
        let Verdict { covered, failures, remarks, .. } = verdict.clone();
        let result = if failures.is_empty() { "as claimed" } else { "wrong" };
        let result = ItemResult { work: covered, seconds, remarks, failures, ..ItemResult::new(item, result) };
        self.items.push(result);
    }

    /// Adds an item that could not run.
    pub fn add_missing(&mut self, item: &Item, problem: &CliError) {
        self.items.push(ItemResult { failures: vec![problem.to_string()], ..ItemResult::new(item, "not run") });
    }

    /// Writes the file, complete or not at all.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(mut self, path: &Path) -> Result<(), CliError> {
        self.programs = versions().into_iter().map(|(name, version)| (name.to_string(), version)).collect();
        let text = serde_json::to_string_pretty(&self).map_err(CliError::unusable)?;
        Ok(write_all(&[(path.to_path_buf(), text + "\n")])?)
    }
}

impl ItemResult {
    fn new(item: &Item, verdict: &str) -> Self {
        Self {
            name: item.name.to_string(),
            claim: item.claim.to_string(),
            oracle: item.oracle.to_string(),
            work: String::new(),
            seconds: 0.0,
            verdict: verdict.to_string(),
            remarks: Vec::new(),
            failures: Vec::new(),
        }
    }
}

/// Shows the commits and the files that changed since the commit of results, as Git knows them in the working folder.
///
/// # Errors
/// The file holds no results, or names no commit; the working folder is in no repository that has it.
pub fn since(path: &Path, out: &mut dyn Write) -> Result<(), CliError> {
    let parsed: Result<Results, _> = serde_json::from_slice(&read(path)?);
    let results = parsed.map_err(|problem| ToolError::file(path, "read the results", problem.into()))?;
    let Some(commit) = &results.commit else {
        let problem = format!("{}: field commit is null, expected results of a build in a repository", path.display());
        return Err(CliError::unusable(problem));
    };
    let state = if results.is_clean { "" } else { ", with changes that no commit has" };
    writeln!(out, "Verified: version {}, commit {commit}{state}, level {}.", results.version, results.level)?;
    for arguments in [
        &["log", "--oneline", "--no-decorate", &format!("{commit}..HEAD")][..],
        &["diff", "--stat", commit, "--", ":/crates", ":/Cargo.lock"],
    ] {
        out.write_all(git(path, arguments)?.as_bytes())?;
    }
    Ok(())
}

fn git(path: &Path, arguments: &[&str]) -> Result<String, CliError> {
    let output = Command::new("git").arg("--no-pager").args(arguments).output();
    let output = output.map_err(|problem| CliError::unusable(format!("git: {problem}, expected Git")))?;
    if !output.status.success() {
        let problem = String::from_utf8_lossy(&output.stderr);
        let problem = problem.lines().next().unwrap_or("it failed");
        let found = format!("{}: git: {problem}, expected a repository with its commit", path.display());
        return Err(CliError::unusable(found));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}
