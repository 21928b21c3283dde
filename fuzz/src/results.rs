//! Readers of files that raypath writes: handshakes and parts of shards.

use raypath_sim::traffic::{parse_recorded, recorded_text};
use raypath_tools::ToolError;
use raypath_work::parts::{Part, Parts};
use std::path::Path;

/// Handshakes are the same after they were written.
pub fn handshakes(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    let Ok(cycles) = parse_recorded(text, Path::new("handshake.txt")) else { return false };
    assert_eq!(parse_recorded(&recorded_text(&cycles), Path::new("again.txt")).ok(), Some(cycles));
    true
}

/// A part is the same after it was written, and a merge of it has its results or is an error.
pub fn part(bytes: &[u8]) -> bool {
    let path = Path::new("part.json");
    let Ok(part) = Part::parse(bytes, path) else { return false };
    let text = serde_json::to_string(&part).unwrap_or_default();
    assert_eq!(Part::parse(text.as_bytes(), path).ok().as_ref(), Some(&part));
    let parts = [(path.to_path_buf(), part)];
    for task in parts[0].1.tasks.keys() {
        let Ok(mut merged) = Parts::merged(&parts, task, Path::new("parts")) else { continue };
        while let Ok(results) =
            merged.phase(|| -> Result<Vec<u64>, ToolError> { unreachable!("a merge computes nothing") })
        {
            assert_eq!(results.len(), 1);
        }
    }
    true
}
