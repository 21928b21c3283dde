//! The cache of proofs: a folder with a small file for each.

use crate::error::{Error, file};
use crate::sat::Miter;
use sha2::{Digest, Sha256};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A folder of proofs. A file's name is a hash of the circuit's text, the commands and the programs' versions, so that
/// the proof of a unit that has changed since is not found.
pub struct ProofCache {
    folder: PathBuf,
    versions: String,
}

impl ProofCache {
    /// Opens a folder, and creates it if it does not exist.
    pub fn open(folder: &Path, versions: String) -> Result<Self, Error> {
        fs::create_dir_all(folder).map_err(|problem| file(folder, problem))?;
        Ok(Self { folder: folder.to_path_buf(), versions })
    }

    /// Whether the cache has a proof of this problem.
    pub fn has(&self, problem: &Miter) -> bool {
        self.path(problem).is_file()
    }

    /// Adds a proved problem, with a note for readers of the file.
    pub fn add(&self, problem: &Miter, note: &str) -> Result<(), Error> {
        let path = self.path(problem);
        let mut written = tempfile::NamedTempFile::new_in(&self.folder).map_err(|problem| file(&path, problem))?;
        writeln!(written, "{note}").map_err(|problem| file(&path, problem))?;
        written.persist(&path).map(drop).map_err(|problem| file(&path, problem.error))
    }

    fn path(&self, problem: &Miter) -> PathBuf {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_very_same_proof_is_found_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let inside = folder.path().join("a/b");
        let problem = |text: &str, command: &str| Miter {
            name: "test".to_string(),
            sources: vec![("unit.sv".to_string(), text.to_string())],
            commands: vec![command.to_string()],
            inputs: Vec::new(),
        };
        let cache = ProofCache::open(&inside, "1".to_string()).expect("a folder");
        assert!(!cache.has(&problem("x", "proc")));
        cache.add(&problem("x", "proc"), "proved").expect("a file");
        let later = ProofCache::open(&inside, "1".to_string()).expect("the folder");
        assert!(later.has(&problem("x", "proc")));
        assert!(!later.has(&problem("y", "proc")) && !later.has(&problem("x", "opt")));
        assert!(!ProofCache::open(&inside, "2".to_string()).expect("the folder").has(&problem("x", "proc")));
    }
}
