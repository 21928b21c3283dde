//! Options for work that several machines divide, and the files of its parts.

use crate::CliError;
use clap::Args;
use raypath_sim::files::write_all;
use raypath_work::parts::{Part, Parts, Task};
use raypath_work::pool::Shard;
use std::collections::BTreeMap;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(next_help_heading = "Several machines")]
pub struct DivisionArguments {
    /// The part of the work for this machine: 2/5 is the second part of five [default: 1/1]
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Write the results of the shard to a file, for --merge
    #[arg(long, value_name = "FILE.json")]
    part: Option<PathBuf>,
    /// Compute nothing: take the results of all shards from the files *.json in a folder
    #[arg(long, value_name = "DIR", conflicts_with_all = ["shard", "part"])]
    merge: Option<PathBuf>,
}

/// The work of a command, divided or not.
pub struct Division {
    /// What is divided: the command and its arguments.
    work: String,
    shard: Shard,
    part: Option<PathBuf>,
    merged: Option<(PathBuf, Vec<(PathBuf, Part)>)>,
    tasks: BTreeMap<String, Task>,
}

const VERSION: &str = env!("CARGO_PKG_VERSION");

impl DivisionArguments {
    /// Begins the work. With `--merge`, reads the parts.
    pub fn begin(&self, work: String) -> Result<Division, CliError> {
        let merged = match &self.merge {
            Some(folder) => Some((folder.clone(), Part::read_all(folder, VERSION, &work)?)),
            None => None,
        };
        Ok(Division { work, shard: self.shard(), part: self.part.clone(), merged, tasks: BTreeMap::new() })
    }

    /// Begins work whose result is whole: an error for a shard without a file for its part.
    pub fn begin_whole(&self, work: String) -> Result<Division, CliError> {
        if self.part.is_none() && self.shard() != Shard::ALL {
            let problem = format!("--shard {}: a shard has no result of its own, expected --part too", self.shard());
            return Err(CliError::unusable(problem));
        }
        self.begin(work)
    }

    /// The part of the work, or all of it.
    pub fn shard(&self) -> Shard {
        self.shard.unwrap_or(Shard::ALL)
    }

    /// Whether the command computes a shard, or merges the results of shards.
    pub fn is_divided(&self) -> bool {
        self.part.is_some() || self.merge.is_some()
    }

    /// Whether the user chose a part of the work, or where its results go or come from.
    #[cfg(feature = "verify")]
    pub fn is_chosen(&self) -> bool {
        self.shard.is_some() || self.is_divided()
    }
}

impl Division {
    /// Where the results of a task come from.
    pub fn parts(&self, task: &str) -> Result<Parts, CliError> {
        Ok(match &self.merged {
            Some((folder, parts)) => Parts::merged(parts, task, folder)?,
            None if self.part.is_some() => Parts::saved(),
            None => Parts::default(),
        })
    }

    /// Keeps the results of a task that took this time.
    pub fn keep(&mut self, task: &str, parts: Parts, seconds: f64) {
        self.tasks.extend(parts.into_task(seconds).map(|results| (task.to_string(), results)));
    }

    /// Writes the part, if one is wanted. Returns the message, which is the command's only result then.
    pub fn write(self) -> Result<Option<String>, CliError> {
        let Some(path) = self.part else { return Ok(None) };
        let Self { work, shard, tasks, .. } = self;
        let part = Part { version: VERSION.to_string(), work, shard: shard.to_string(), tasks };
        let text = serde_json::to_string(&part).map_err(|problem| CliError::unusable(format!("JSON: {problem}")))?;
        write_all(&[(path.clone(), text + "\n")])?;
        Ok(Some(format!("Wrote the results of shard {shard} to {}.", path.display())))
    }
}
