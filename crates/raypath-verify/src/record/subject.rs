//! The subject of an item: the source text that its result depends on.

use crate::error::Error;
use crate::files::in_folder;
use raypath_tools::{digest, read};
use std::path::{Path, PathBuf};

/// The SHA-256, in hexadecimal digits, of the files under these paths of the repository at `root`. Lines with only a
/// comment, empty lines and indentation have no effect.
pub fn hash(root: &Path, subject: &[&str]) -> Result<String, Error> {
    let mut files = Vec::new();
    for path in subject {
        collect(&root.join(path), &mut files)?;
    }
    files.sort();
    files.dedup();
    let mut bytes = Vec::new();
    for path in files {
        let text = read(&path)?;
        bytes.extend(path.strip_prefix(root).unwrap_or(&path).to_string_lossy().bytes());
        for line in String::from_utf8_lossy(&text).lines().map(str::trim) {
            if !line.is_empty() && !line.starts_with("//") {
                bytes.push(b'\n');
                bytes.extend(line.bytes());
            }
        }
        bytes.push(0);
    }
    Ok(digest(&bytes))
}

/// Adds a file, or all files in a folder and below.
fn collect(path: &Path, files: &mut Vec<PathBuf>) -> Result<(), Error> {
    if path.is_file() {
        files.push(path.to_path_buf());
        return Ok(());
    }
    for entry in in_folder(path)? {
        collect(&entry, files)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::hash;
    use std::fs;

    #[test]
    fn the_hash_depends_on_code_and_not_on_comments() {
        let folder = tempfile::tempdir().expect("a folder");
        let hash_of = |text: &str| {
            fs::write(folder.path().join("a.rs"), text).expect("a file");
            hash(folder.path(), &["a.rs"]).expect("a hash")
        };
        let first = hash_of("fn one() -> u32 {\n    1\n}\n");
        assert_eq!(hash_of("// One.\n\nfn one() -> u32 {\n1\n}"), first);
        assert_ne!(hash_of("fn one() -> u32 {\n    2\n}\n"), first);
        assert_eq!(first.len(), 64);
    }

    #[test]
    fn a_missing_path_is_an_error() {
        let folder = tempfile::tempdir().expect("a folder");
        let problem = hash(folder.path(), &["nothing"]).expect_err("no such path");
        assert!(problem.to_string().contains("nothing"), "{problem}");
    }
}
