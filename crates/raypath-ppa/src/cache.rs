//! Results kept on disk under the digest of all that they follow from, so that nothing is done twice.

use crate::Error;
use crate::input::unpacked;
use crate::library::hex;
use flate2::Compression;
use flate2::write::GzEncoder;
use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use std::fs::{self, File};
use std::io::{BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// More bytes, unpacked, than any result has: a netlist of the largest configuration has some tens of millions.
pub(crate) const MOST_BYTES: u64 = 1 << 30;

/// A folder of results.
#[derive(Debug, Clone)]
pub struct Cache {
    folder: PathBuf,
}

/// What a result follows from, as a digest.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Key(String);

impl Key {
    /// Of a kind of result and everything that it depends on. This crate's version always counts: it reads the tools.
    pub fn new(kind: &str, parts: &[&str]) -> Self {
        let mut digest = Sha256::new();
        for part in [env!("CARGO_PKG_VERSION"), kind].iter().chain(parts) {
            digest.update((part.len() as u64).to_le_bytes());
            digest.update(part);
        }
        Self(format!("{kind}-{}", &hex(&digest.finalize())[..32]))
    }

    /// As text; another digest may depend on it.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl Cache {
    /// A cache in a folder, which is made when something is put into it.
    pub fn new(folder: &Path) -> Self {
        Self { folder: folder.to_path_buf() }
    }

    /// A result, if it is there and whole.
    pub fn get<T: DeserializeOwned>(&self, key: &Key) -> Option<T> {
        whole(File::open(self.path(key)).ok()?)
    }

    /// Whether there is a result, whole or not.
    pub fn has(&self, key: &Key) -> bool {
        self.path(key).exists()
    }

    /// Keeps a result. It is there whole or not at all.
    pub fn put<T: Serialize>(&self, key: &Key, result: &T) -> Result<(), Error> {
        fs::create_dir_all(&self.folder).map_err(|problem| Error::file(&self.folder, "create the folder", problem))?;
        let path = self.path(key);
        let refused = |problem| Error::file(&path, "write", problem);
        let mut file = NamedTempFile::new_in(&self.folder).map_err(refused)?;
        let mut encoder = GzEncoder::new(BufWriter::new(file.as_file_mut()), Compression::fast());
        serde_json::to_writer(&mut encoder, result).map_err(|problem| refused(problem.into()))?;
        let written = encoder.finish().and_then(|mut file| file.flush());
        written.map_err(refused)?;
        file.persist(&path).map_err(|problem| refused(problem.error))?;
        Ok(())
    }

    fn path(&self, key: &Key) -> PathBuf {
        self.folder.join(format!("{}.json.gz", key.0))
    }
}

/// A result as it was kept, if it is whole.
pub(crate) fn whole<T: DeserializeOwned>(stream: impl Read) -> Option<T> {
    serde_json::from_slice(&unpacked(stream, MOST_BYTES).ok()?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_comes_back_unless_it_is_broken() {
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
    fn parts_do_not_run_together() {
        let keys = [Key::new("a", &["bc", "d"]), Key::new("a", &["b", "cd"]), Key::new("ab", &["c", "d"])];
        assert!(keys[0] != keys[1] && keys[1] != keys[2] && keys[0] != keys[2]);
    }
}
