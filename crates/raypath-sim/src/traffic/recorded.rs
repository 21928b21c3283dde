//! Recorded handshakes as text (`docs/reference/transactions.md`): one letter per cycle.

use crate::InputError;
use crate::traffic::Cycle;
use raypath_tools::MemoryLimit;
use std::path::Path;

const CYCLES_PER_LINE: usize = 80;

const LETTERS: &str =
    "expected b (both act), s (source), k (sink), - (neither), r (reset), or w before a cycle (withdraw)";

/// The text of a file with these cycles.
pub fn recorded_text(cycles: &[Cycle]) -> String {
    let mut text =
        String::from("# a letter a cycle: b both act, s source, k sink, - neither, r reset; w before it: withdrawn\n");
    for line in cycles.chunks(CYCLES_PER_LINE) {
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

/// Reads the cycles of a file. White space and lines that begin with `#` are ignored.
///
/// # Errors
/// A file that cannot be read, takes more than 2 GiB, or has an unknown letter.
pub fn read_recorded(path: &Path) -> Result<Vec<Cycle>, InputError> {
    let refused = |problem: String| InputError::in_file(path, format!("{problem}, expected text"));
    let bytes = MemoryLimit::DEFAULT.read(path).map_err(|problem| refused(problem.to_string()))?;
    parse_recorded(&String::from_utf8(bytes).map_err(|problem| refused(problem.to_string()))?, path)
}

/// Reads the cycles of a text. `path` appears in messages.
///
/// # Errors
/// An unknown letter, or a `w` without a cycle.
pub fn parse_recorded(text: &str, path: &Path) -> Result<Vec<Cycle>, InputError> {
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
                _ => {
                    return Err(InputError::at_line(
                        path,
                        index + 1,
                        format!("'{letter}' is not a valid cycle, {LETTERS}"),
                    ));
                }
            };
            cycles.push(Cycle { offers, takes, withdraws, resets: letter == 'r' });
            withdraws = false;
        }
    }
    match withdraws {
        true => Err(InputError::in_file(path, format!("'w' at the end, {LETTERS}"))),
        false => Ok(cycles),
    }
}
