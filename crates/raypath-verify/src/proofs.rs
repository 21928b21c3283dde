//! Results of proofs, kept on disk by what is proved, so that nothing is proved twice.
//!
//! The key of a result is the digest of all that it depends on: texts, claims, commands, and the versions of the
//! programs. A change after which the same text is printed proves nothing again. Only final results are kept: that a
//! claim holds, or that it does not. To prove all again, delete the folder.

use raypath_tools::{Cache, Key, ToolError};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// The folder of results, relative to the working directory.
pub const FOLDER: &str = "build/proofs";

/// The cache in [`FOLDER`].
pub fn cache() -> Cache {
    Cache::new(Path::new(FOLDER))
}

/// The result in the cache, or that of `compute`, which is kept if `is_final` says so.
///
/// # Errors
/// Those of `compute`; the result cannot be written.
pub fn kept<T, E>(
    cache: &Cache,
    key: &Key,
    is_final: impl FnOnce(&T) -> bool,
    compute: impl FnOnce() -> Result<T, E>,
) -> Result<T, E>
where
    T: Serialize + DeserializeOwned,
    E: From<ToolError>,
{
    if let Some(result) = cache.get(key) {
        return Ok(result);
    }
    let result = compute()?;
    if is_final(&result) {
        cache.put(key, &result)?;
    }
    Ok(result)
}
