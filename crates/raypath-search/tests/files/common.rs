use raypath_search::{Dataset, FileError, Neighbours, Vectors, read_neighbours, read_vectors};
use raypath_tools::MemoryLimit;
use std::path::PathBuf;
use tempfile::TempDir;

/// A directory with a file in it.
pub struct Written {
    pub directory: TempDir,
    pub path: PathBuf,
}

impl Written {
    pub fn new(name: &str, bytes: &[u8]) -> Self {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        Self { directory, path }
    }

    pub fn rewrite(&self, bytes: &[u8]) {
        std::fs::write(&self.path, bytes).expect("written");
    }

    pub fn vectors(&self) -> Result<Vectors, FileError> {
        read_vectors(&self.path, MemoryLimit::DEFAULT)
    }

    pub fn neighbours(&self, base: usize) -> Result<Neighbours, FileError> {
        read_neighbours(&self.path, base, MemoryLimit::DEFAULT)
    }

    pub fn dataset(&self) -> Result<Dataset, FileError> {
        Dataset::read(&self.path, None, None, MemoryLimit::DEFAULT)
    }
}

/// Checks that an error names the file and contains all `parts`.
pub fn assert_error<T: std::fmt::Debug>(name: &str, result: Result<T, FileError>, parts: &[&str]) {
    let message = result.expect_err("an error").to_string();
    for part in parts.iter().chain(&[name]) {
        assert!(message.contains(part), "`{message}` does not contain `{part}`");
    }
}

pub fn assert_vectors_error(name: &str, bytes: &[u8], parts: &[&str]) {
    assert_error(name, Written::new(name, bytes).vectors(), parts);
}

pub fn assert_neighbours_error(name: &str, bytes: &[u8], base: usize, parts: &[&str]) {
    assert_error(name, Written::new(name, bytes).neighbours(base), parts);
}

/// The vectors that `tests/data/files.py` writes.
pub fn base() -> Vec<f32> {
    (0..35).map(|i| (i * 7 % 23 - 11) as f32 / 4.0).collect()
}
