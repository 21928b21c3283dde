//! Proofs that were done before, kept in a folder: a small file for each.

use crate::Error;
use crate::proof::Problem;
use sha2::{Digest, Sha256};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A folder of proofs. Their names follow from everything that was proved, text and commands, and by which programs: a
/// proof of a unit that has changed since is not found.
pub struct Kept {
    folder: PathBuf,
    versions: String,
}

impl Kept {
    /// What is in a folder, which is made where it is not there.
    pub fn open(folder: &Path, versions: String) -> Result<Self, Error> {
        fs::create_dir_all(folder).map_err(|problem| file(folder, problem))?;
        Ok(Self { folder: folder.to_path_buf(), versions })
    }

    /// Whether a problem has been proved.
    pub fn has(&self, problem: &Problem) -> bool {
        self.path(problem).is_file()
    }

    /// Keeps that a problem has been proved, with a word for the reader.
    pub fn keep(&self, problem: &Problem, word: &str) -> Result<(), Error> {
        let path = self.path(problem);
        let mut written = tempfile::NamedTempFile::new_in(&self.folder).map_err(|problem| file(&path, problem))?;
        writeln!(written, "{word}").map_err(|problem| file(&path, problem))?;
        written.persist(&path).map(drop).map_err(|problem| file(&path, problem.error))
    }

    fn path(&self, problem: &Problem) -> PathBuf {
        let mut hash = Sha256::new();
        let texts = problem.sources.iter().flat_map(|(name, text)| [name, text]);
        for text in texts.chain(&problem.commands).chain([&self.versions]) {
            hash.update(text.len().to_le_bytes());
            hash.update(text);
        }
        let digits: String = hash.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect();
        self.folder.join(digits)
    }
}

fn file(path: &Path, problem: std::io::Error) -> Error {
    Error::File { path: path.to_path_buf(), problem }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_very_same_proof_is_found_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let inside = folder.path().join("a/b");
        let problem = |text: &str, command: &str| Problem {
            name: "test".to_string(),
            sources: vec![("unit.sv".to_string(), text.to_string())],
            commands: vec![command.to_string()],
            inputs: Vec::new(),
        };
        let kept = Kept::open(&inside, "1".to_string()).expect("a folder");
        assert!(!kept.has(&problem("x", "proc")));
        kept.keep(&problem("x", "proc"), "proved").expect("a file");
        let later = Kept::open(&inside, "1".to_string()).expect("the folder");
        assert!(later.has(&problem("x", "proc")));
        assert!(!later.has(&problem("y", "proc")) && !later.has(&problem("x", "opt")));
        assert!(!Kept::open(&inside, "2".to_string()).expect("the folder").has(&problem("x", "proc")));
    }
}
