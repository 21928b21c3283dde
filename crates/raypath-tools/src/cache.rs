//! Results kept on disk, named by the digest of everything that they depend on, so that nothing is computed twice.

use crate::ToolError;
use crate::input::unpacked;
use flate2::Compression;
use flate2::write::GzEncoder;
use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use std::fs::{self, File};
use std::io::{BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// The limit on an unpacked result. A netlist of the largest configuration has some tens of millions of bytes.
pub const MAX_RESULT_BYTES: u64 = 1 << 30;

/// A folder of results, each a gzip file of JSON.
#[derive(Debug, Clone)]
pub struct Cache {
    folder: PathBuf,
}

/// The name of a result: a digest of everything that it depends on.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Key(String);

impl Key {
    /// The key of a result of this kind that depends on these parts, and on this crate's version.
    pub fn new(kind: &str, parts: &[&str]) -> Self {
        let mut digest = Sha256::new();
        for part in [env!("CARGO_PKG_VERSION"), kind].iter().chain(parts) {
            digest.update((part.len() as u64).to_le_bytes());
            digest.update(part);
        }
        Self(format!("{kind}-{}", &hex(&digest.finalize())[..32]))
    }

    /// The key as text, which another key may depend on.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl Cache {
    /// A cache in a folder, which is created with the first result.
    pub fn new(folder: &Path) -> Self {
        Self { folder: folder.to_path_buf() }
    }

    /// A kept result. None if there is none, or its file is damaged.
    pub fn get<T: DeserializeOwned>(&self, key: &Key) -> Option<T> {
        decode(File::open(self.path(key)).ok()?)
    }

    /// Whether a file of this result exists, damaged or not.
    pub fn has(&self, key: &Key) -> bool {
        self.path(key).exists()
    }

    /// Keeps a result. Its file appears complete or not at all.
    ///
    /// # Errors
    /// The folder or the file cannot be written.
    pub fn put<T: Serialize>(&self, key: &Key, result: &T) -> Result<(), ToolError> {
        fs::create_dir_all(&self.folder)
            .map_err(|problem| ToolError::file(&self.folder, "create the folder", problem))?;
        let path = self.path(key);
        let refused = |problem| ToolError::file(&path, "write", problem);
        let mut file = NamedTempFile::new_in(&self.folder).map_err(refused)?;
        let mut encoder = GzEncoder::new(BufWriter::new(file.as_file_mut()), Compression::fast());
        serde_json::to_writer(&mut encoder, result).map_err(|problem| refused(problem.into()))?;
        let written = encoder.finish().and_then(|mut file| file.flush());
        written.map_err(refused)?;
        file.persist(&path).map_err(|problem| refused(problem.error))?;
        Ok(())
    }

    /// The kept result, or that of `compute`, which is kept if `is_final` says so.
    ///
    /// # Errors
    /// Those of `compute`; the result cannot be written.
    pub fn kept<T: Serialize + DeserializeOwned, E: From<ToolError>>(
        &self,
        key: &Key,
        is_final: impl FnOnce(&T) -> bool,
        compute: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        if let Some(result) = self.get(key) {
            return Ok(result);
        }
        let result = compute()?;
        if is_final(&result) {
            self.put(key, &result)?;
        }
        Ok(result)
    }

    fn path(&self, key: &Key) -> PathBuf {
        self.folder.join(format!("{}.json.gz", key.0))
    }
}

/// The SHA-256 digest of bytes, in hexadecimal digits.
pub fn digest(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Decodes a kept result. None if it is damaged.
pub fn decode<T: DeserializeOwned>(stream: impl Read) -> Option<T> {
    serde_json::from_slice(&unpacked(stream, MAX_RESULT_BYTES).ok()?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_read_back_unless_damaged() {
        let folder = tempfile::tempdir().expect("a folder");
        let cache = Cache::new(&folder.path().join("cache"));
        let key = Key::new("area", &["text", "library"]);
        assert_eq!((cache.get::<Vec<u32>>(&key), cache.has(&key)), (None, false));
        cache.put(&key, &vec![1, 2, 3]).expect("written");
        assert_eq!((cache.get(&key), cache.has(&key)), (Some(vec![1, 2, 3]), true));
        let bytes = fs::read(cache.path(&key)).expect("a file");
        fs::write(cache.path(&key), &bytes[..bytes.len() / 2]).expect("written");
        assert_eq!(cache.get::<Vec<u32>>(&key), None);
        assert_eq!(fs::read_dir(&cache.folder).expect("a folder").count(), 1);
    }

    #[test]
    fn keys_separate_their_parts() {
        let keys = [Key::new("a", &["bc", "d"]), Key::new("a", &["b", "cd"]), Key::new("ab", &["c", "d"])];
        assert!(keys[0] != keys[1] && keys[1] != keys[2] && keys[0] != keys[2]);
    }
}
