//! Work that several machines divide. Each machine runs a [`Shard`] and saves its results as a part, a JSON file. A
//! merge takes the parts of all shards in place of the computation, and everything after the computation is the same:
//! the merged result has the bytes that one machine would write.

use crate::pool::Shard;
use raypath_tools::{ToolError, read};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Where the results of the current task come from.
#[derive(Debug, Default)]
pub struct Parts {
    source: Source,
    /// The phases of the current task that have begun.
    phases: usize,
    /// The seconds that the parts of the current task took.
    seconds: f64,
}

#[derive(Debug, Default)]
enum Source {
    /// They are computed here.
    #[default]
    Computed,
    /// They are computed here, and kept for a part.
    Saved(Vec<String>),
    /// They are those of the shards.
    Merged(Vec<(PathBuf, Task)>),
}

/// The results of a shard, by task: an item of `verify`, or a command.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// The version of raypath.
    pub version: String,
    /// The work that is divided: the command and its arguments, without the shard.
    pub work: String,
    /// The shard: "2/5".
    pub shard: String,
    /// The tasks that have finished.
    pub tasks: BTreeMap<String, Task>,
}

/// The results of a task.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Task {
    /// The seconds that the task took.
    pub seconds: f64,
    /// The result of each phase, as JSON.
    pub phases: Vec<String>,
}

impl Parts {
    /// Computes results and keeps them for a part.
    pub fn saved() -> Self {
        Self { source: Source::Saved(Vec::new()), ..Self::default() }
    }

    /// Takes the results of a task from all parts, in the order of their shards.
    ///
    /// # Errors
    /// A shard is missing or there twice.
    pub fn merged(parts: &[(PathBuf, Part)], task: &str, folder: &Path) -> Result<Self, ToolError> {
        let found = parts.iter().filter_map(|(path, part)| Some((path, part, part.tasks.get(task)?)));
        let found = found.map(|(path, part, task)| Ok((shard(path, part)?, path, task)));
        let mut found = found.collect::<Result<Vec<_>, ToolError>>()?;
        found.sort_by_key(|(shard, ..)| shard.number());
        let shards: Vec<Shard> = found.iter().map(|(shard, ..)| *shard).collect();
        let count = shards.first().map_or(0, |shard| shard.count());
        let found_shards: Vec<String> = shards.iter().map(Shard::to_string).collect();
        let all = (1..=count).map(|number| format!("{number}/{count}"));
        if shards.is_empty() || !all.clone().eq(found_shards.iter().cloned()) {
            let missing = first(all.filter(|shard| !found_shards.contains(shard)));
            let found = format!("the shards [{}] of {task}", first(found_shards.iter().cloned()));
            return Err(unexpected(folder, found, &format!("each shard i/n of one n once; missing: [{missing}]")));
        }
        let seconds = found.iter().map(|(.., task)| task.seconds).sum();
        let tasks = found.into_iter().map(|(_, path, task)| (path.clone(), task.clone())).collect();
        Ok(Self { source: Source::Merged(tasks), phases: 0, seconds })
    }

    /// The results of the next phase: of `compute`, or those of all shards, without calling it.
    ///
    /// # Errors
    /// Those of `compute`; a part whose content is of another version.
    pub fn phase<T, E>(&mut self, compute: impl FnOnce() -> Result<T, E>) -> Result<Vec<T>, E>
    where
        T: Serialize + DeserializeOwned,
        E: From<ToolError>,
    {
        let phase = self.phases;
        self.phases += 1;
        match &mut self.source {
            Source::Computed => Ok(vec![compute()?]),
            Source::Saved(phases) => {
                let result = compute()?;
                let text = serde_json::to_string(&result);
                phases.push(text.map_err(|problem| ToolError::unexpected("a part", problem.to_string(), "JSON"))?);
                Ok(vec![result])
            }
            Source::Merged(tasks) => {
                let result = |(path, task): &(PathBuf, Task)| {
                    let text = task.phases.get(phase).map_or("", String::as_str);
                    let expected = format!("the results of phase {phase}");
                    serde_json::from_str(text).map_err(|problem| unexpected(path, problem.to_string(), &expected))
                };
                Ok(tasks.iter().map(result).collect::<Result<_, _>>()?)
            }
        }
    }

    /// Whether the results are those of a shard, so that a claim about all of them cannot be judged here.
    pub fn is_saved(&self) -> bool {
        matches!(self.source, Source::Saved(_))
    }

    /// The seconds that the merged shards took; None if the results are computed here.
    pub fn seconds(&self) -> Option<f64> {
        matches!(self.source, Source::Merged(_)).then_some(self.seconds)
    }

    /// The task of a part, if results are kept for one.
    pub fn into_task(self, seconds: f64) -> Option<Task> {
        match self.source {
            Source::Saved(phases) => Some(Task { seconds, phases }),
            Source::Computed | Source::Merged(_) => None,
        }
    }
}

impl Part {
    /// Reads all parts in a folder: its files `*.json`.
    ///
    /// # Errors
    /// There are none; a file cannot be read, is no part, or is a part of other work.
    pub fn read_all(folder: &Path, version: &str, work: &str) -> Result<Vec<(PathBuf, Self)>, ToolError> {
        let refused = |problem| ToolError::file(folder, "read", problem);
        let entries = std::fs::read_dir(folder).map_err(refused)?;
        let paths: Result<Vec<PathBuf>, _> = entries.map(|entry| entry.map(|entry| entry.path())).collect();
        let mut paths = paths.map_err(refused)?;
        paths.retain(|path| path.extension().is_some_and(|extension| extension == "json"));
        if paths.is_empty() {
            return Err(unexpected(folder, "no files *.json".to_string(), "a part of each shard, as --part writes it"));
        }
        paths.sort();
        paths.into_iter().map(|path| Ok((path.clone(), Self::read(&path, version, work)?))).collect()
    }

    /// Reads a part from the content of a file. `path` appears in messages.
    ///
    /// # Errors
    /// Content that is no part.
    pub fn parse(bytes: &[u8], path: &Path) -> Result<Self, ToolError> {
        serde_json::from_slice(bytes)
            .map_err(|problem| unexpected(path, problem.to_string(), "a part, as --part writes it"))
    }

    fn read(path: &Path, version: &str, work: &str) -> Result<Self, ToolError> {
        let part = Self::parse(&read(path)?, path)?;
        if (part.version.as_str(), part.work.as_str()) != (version, work) {
            let found = format!("a part of raypath {}: {}", part.version, part.work);
            return Err(unexpected(path, found, &format!("raypath {version}: {work}")));
        }
        Ok(part)
    }
}

/// The first of many shards, for a message. Their number may be anything that a file says.
fn first(mut shards: impl Iterator<Item = String>) -> String {
    const MOST: usize = 8;
    let mut names: Vec<String> = shards.by_ref().take(MOST).collect();
    names.extend(shards.next().map(|_| "…".to_string()));
    names.join(", ")
}

fn shard(path: &Path, part: &Part) -> Result<Shard, ToolError> {
    part.shard.parse().map_err(|problem| unexpected(path, format!("{problem}"), "a shard"))
}

fn unexpected(path: &Path, found: String, expected: &str) -> ToolError {
    ToolError::unexpected(&path.display().to_string(), found, expected)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(shard: &str, numbers: &[u32]) -> (PathBuf, Part) {
        let mut parts = Parts::saved();
        let kept = parts.phase(|| Ok::<_, ToolError>(numbers.to_vec())).expect("numbers");
        assert_eq!((kept, parts.is_saved(), parts.seconds()), (vec![numbers.to_vec()], true, None));
        let tasks = BTreeMap::from([("sums".to_string(), parts.into_task(1.5).expect("a task"))]);
        let part = Part { version: "1".to_string(), work: "verify".to_string(), shard: shard.to_string(), tasks };
        (PathBuf::from(shard.replace('/', "-")), part)
    }

    fn merged(parts: &[(PathBuf, Part)]) -> Result<Parts, ToolError> {
        Parts::merged(parts, "sums", Path::new("parts"))
    }

    #[test]
    fn a_merge_has_the_results_of_all_shards_and_computes_nothing() {
        let mut parts = merged(&[part("2/2", &[3]), part("1/2", &[1, 2])]).expect("parts");
        let found = parts.phase(|| -> Result<Vec<u32>, ToolError> { unreachable!("a merge computes nothing") });
        assert_eq!(found.expect("numbers"), [vec![1, 2], vec![3]]);
        assert_eq!((parts.seconds(), parts.is_saved()), (Some(3.0), false));
        let problem = parts.phase(|| Ok::<u32, ToolError>(1)).expect_err("no second phase");
        assert!(problem.to_string().contains("phase 1"), "{problem}");
        assert_eq!(Parts::default().phase(|| Ok::<_, ToolError>(7)).expect("a number"), [7]);
    }

    #[test]
    fn missing_and_repeated_shards_are_errors() {
        for shards in [&[][..], &["1/2"], &["1/2", "2/2", "2/2"], &["1/2", "2/3"], &["2/2"]] {
            let parts: Vec<_> = shards.iter().map(|shard| part(shard, &[1])).collect();
            let problem = merged(&parts).expect_err("not all shards").to_string();
            assert!(problem.contains(&shards.join(", ")) && problem.contains("of sums"), "{problem}");
        }
    }

    #[test]
    fn a_message_about_many_shards_names_those_that_are_missing() {
        let shards = (1..=62).filter(|number| ![7, 40].contains(number));
        let parts: Vec<_> = shards.map(|number| part(&format!("{number}/62"), &[1])).collect();
        let problem = merged(&parts).expect_err("not all shards").to_string();
        assert!(problem.contains("8/62, 9/62, …] of sums") && problem.contains("missing: [7/62, 40/62]"), "{problem}");
        let problem = merged(&parts[..1]).expect_err("one shard").to_string();
        assert!(problem.contains("missing: [2/62, 3/62, 4/62, 5/62, 6/62, 7/62, 8/62, 9/62, …]"), "{problem}");
    }

    #[test]
    fn files_of_other_work_are_errors() {
        let folder = tempfile::tempdir().expect("a folder");
        let problem = Part::read_all(folder.path(), "1", "verify").expect_err("no files").to_string();
        assert!(problem.contains("no files *.json, expected a part of each shard"), "{problem}");
        let (name, part) = part("1/1", &[1]);
        let path = folder.path().join(name).with_extension("json");
        std::fs::write(&path, serde_json::to_string(&part).expect("JSON")).expect("a file");
        assert_eq!(Part::read_all(folder.path(), "1", "verify").expect("parts"), [(path.clone(), part)]);
        for (version, work) in [("2", "verify"), ("1", "render")] {
            let problem = Part::read_all(folder.path(), version, work).expect_err("other work").to_string();
            assert!(
                problem.contains("1-1.json") && problem.contains(&format!("raypath {version}: {work}")),
                "{problem}"
            );
        }
        std::fs::write(&path, "{").expect("a file");
        assert!(Part::read_all(folder.path(), "1", "verify").is_err());
    }
}
