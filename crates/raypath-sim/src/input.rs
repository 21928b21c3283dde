use std::fmt::{self, Display};
use std::path::{Path, PathBuf};

/// A file that cannot be read, or whose content is not valid. The message has the form `path:line: problem`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InputError {
    /// The file; `None` if the input does not come from a file.
    pub path: Option<PathBuf>,
    /// The line, from 1; `None` if the problem is not in one line.
    pub line: Option<usize>,
    /// What was found, and what was expected.
    pub problem: String,
}

impl InputError {
    pub(crate) fn in_file(path: &Path, problem: impl Display) -> Self {
        Self { path: Some(path.to_path_buf()), line: None, problem: problem.to_string() }
    }

    pub(crate) fn at_line(path: &Path, line: usize, problem: impl Display) -> Self {
        Self { line: Some(line), ..Self::in_file(path, problem) }
    }
}

impl Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(path) = &self.path {
            write!(f, "{}:", path.display())?;
            self.line.map_or(Ok(()), |line| write!(f, "{line}:"))?;
            f.write_str(" ")?;
        }
        f.write_str(&self.problem)
    }
}

impl std::error::Error for InputError {}
