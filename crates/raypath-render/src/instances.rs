//! Files of instances.
//!
//! A file has one instance per line: the 12 numbers of the affine matrix from the mesh to the scene, row by row,
//! `xx xy xz xt yx yy yz yt zx zy zz zt`, as decimals separated by spaces. The last number of each row is the
//! translation. `#` starts a comment; empty lines are ignored. Instances are numbered from 0.

use crate::read::{ReadError, parse_lines, text};
use raypath_scene::Placement;
use raypath_scene::placement::NUMBERS;
use raypath_tools::MemoryLimit;
use std::path::Path;

/// Reads a file of instances.
///
/// # Errors
/// A file that cannot be read, no instance, or a line that is not a matrix with an inverse; lines that take more memory
/// than `limit`, 1024 bytes each with their part of the tree.
pub fn read_instances(path: &Path, limit: MemoryLimit) -> Result<Vec<Placement>, ReadError> {
    parse_instances(&text(path, limit, 1024)?, path)
}

/// Reads instances from text. `path` appears in messages.
///
/// # Errors
/// No instance, or a line that is not a matrix with an inverse.
pub fn parse_instances(text: &str, path: &Path) -> Result<Vec<Placement>, ReadError> {
    let instances = parse_lines(text, path, parse_instance)?;
    if instances.is_empty() {
        return Err(ReadError::new(path, "no instance, expected a line of 12 numbers for each".to_string()));
    }
    Ok(instances)
}

fn parse_instance(text: &str) -> Result<Placement, String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    if words.len() != NUMBERS.len() {
        return Err(format!("{} numbers, expected 12: {}", words.len(), NUMBERS.join(" ")));
    }
    let mut numbers = [[0.0; 4]; 3];
    for ((number, name), word) in numbers.as_flattened_mut().iter_mut().zip(NUMBERS).zip(words) {
        *number = word.parse().map_err(|_| format!("{name} = '{word}', expected a decimal number"))?;
    }
    Placement::checked(numbers).map_err(|problem| problem.to_string())
}
