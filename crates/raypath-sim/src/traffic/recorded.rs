//! Handshakes as text (`docs/reference/transactions.md`): a letter a cycle.

use crate::traffic::Cycle;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a file is no recorded handshake.
#[derive(Debug, Error)]
pub enum RecordedError {
    /// It cannot be read.
    #[error("{}: {problem}, expected text", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        problem: std::io::Error,
    },
    /// A letter that means nothing.
    #[error("{}:{line}: '{letter}' is no cycle, expected b (both act), s (source), k (sink), - (neither), r (reset), or w before a cycle (withdraw)", path.display())]
    Letter {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is there.
        letter: char,
    },
}

const CYCLES_A_LINE: usize = 80;

/// Cycles as the text of a file.
pub fn recorded_text(cycles: &[Cycle]) -> String {
    let mut text =
        String::from("# a letter a cycle: b both act, s source, k sink, - neither, r reset; w before it: withdrawn\n");
    for line in cycles.chunks(CYCLES_A_LINE) {
        for cycle in line {
            text.extend(cycle.withdraws.then_some('w'));
            text.push(match (cycle.resets, cycle.offers, cycle.takes) {
                (true, ..) => 'r',
                (false, true, true) => 'b',
                (false, true, false) => 's',
                (false, false, true) => 'k',
                (false, false, false) => '-',
            });
        }
        text.push('\n');
    }
    text
}

/// Reads the cycles of a file. Blanks and lines that begin with `#` are passed over.
///
/// # Errors
/// A file that cannot be read, or with letters that mean nothing.
pub fn read_recorded(path: &Path) -> Result<Vec<Cycle>, RecordedError> {
    let text = std::fs::read_to_string(path);
    let text = text.map_err(|problem| RecordedError::File { path: path.to_path_buf(), problem })?;
    let mut cycles = Vec::new();
    let mut withdraws = false;
    for (index, line) in text.lines().enumerate().filter(|(_, line)| !line.starts_with('#')) {
        for letter in line.chars().filter(|letter| !letter.is_whitespace()) {
            let (offers, takes) = match letter {
                'b' => (true, true),
                's' => (true, false),
                'k' => (false, true),
                '-' | 'r' => (false, false),
                'w' if !withdraws => {
                    withdraws = true;
                    continue;
                }
                _ => return Err(RecordedError::Letter { path: path.to_path_buf(), line: index + 1, letter }),
            };
            cycles.push(Cycle { offers, takes, withdraws, resets: letter == 'r' });
            withdraws = false;
        }
    }
    Ok(cycles)
}
