//! Results of proofs, kept on disk by what is proved, so that nothing is proved twice.
//!
//! The key of a result is the digest of all that it depends on: texts, claims, commands, and the versions of the
//! programs. A change after which the same text is printed proves nothing again. Only final results are kept: that a
//! claim holds, or that it does not. To prove all again, delete the folder.

use raypath_tools::Cache;
use std::path::Path;

/// The folder of results, relative to the working directory.
pub const FOLDER: &str = "build/proofs";

/// The cache in [`FOLDER`].
pub fn cache() -> Cache {
    Cache::new(Path::new(FOLDER))
}
