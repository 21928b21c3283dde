//! What the program was built from, which results of verification state.

use std::sync::OnceLock;

/// The sources of this program.
#[derive(Debug, Clone, Copy, Default)]
pub struct Build {
    /// The commit that was checked out. None if the sources were in no Git repository.
    pub commit: Option<&'static str>,
    /// Whether the sources were those of the commit.
    pub is_clean: bool,
    /// The digest of `Cargo.lock`, as `git hash-object` prints it. None if it is unknown.
    pub lock: Option<&'static str>,
}

static BUILD: OnceLock<Build> = OnceLock::new();

impl Build {
    /// The build of this process: unknown, unless its `main` has set it.
    pub fn current() -> Self {
        BUILD.get().copied().unwrap_or_default()
    }

    /// States what this process was built from. Only the first call has an effect.
    pub fn set(self) {
        let _ = BUILD.set(self);
    }
}
