//! And-inverter graphs as Yosys writes them, with the names of their inputs.

use super::Miter;
use crate::error::Error;
use raypath_tools::{ToolError, read};
use std::collections::BTreeMap;
use std::path::Path;

/// A graph in a file, checked against its problem.
pub struct Aiger {
    pub problem: String,
    /// The graph's file name in its folder.
    pub file: String,
    pub gates: u64,
    /// The port and bit of each input.
    inputs: Vec<(String, u32)>,
}

impl Aiger {
    /// Reads the graph of the problem with this number. It must have the problem's inputs, one output and no state.
    pub fn read(folder: &Path, number: usize, problem: &Miter) -> Result<Self, Error> {
        // The numbers of variables, inputs, latches, outputs, and-gates.
        let (header, numbers) = header(&folder.join(format!("{number}.aig")))?;
        let map = read(&folder.join(format!("{number}.map")))?;
        let inputs = inputs(&String::from_utf8_lossy(&map));
        let mut found = inputs.clone();
        found.sort();
        let mut expected: Vec<(String, u32)> =
            problem.inputs.iter().flat_map(|(name, width)| (0..*width).map(|bit| (name.clone(), bit))).collect();
        expected.sort();
        match numbers[..] {
            [_, count, 0, 1, gates] if found == expected && count as usize == expected.len() => {
                Ok(Self { problem: problem.name.clone(), file: format!("{number}.aig"), gates, inputs })
            }
            _ => {
                let found = format!("{}: found a circuit '{header}' with inputs {}", problem.name, ports(&found));
                let expected = format!("one output, no latches and the inputs {}", ports(&expected));
                Err(ToolError::unexpected("yosys", found, expected).into())
            }
        }
    }

    /// The ports' values from a word with a digit 0 or 1 for each input, in order; none if the word is too short.
    pub fn ports(&self, word: &str) -> Option<BTreeMap<String, u64>> {
        let mut values = BTreeMap::new();
        let mut digits = word.chars();
        for (port, bit) in &self.inputs {
            let digit = digits.next()?.to_digit(2)?;
            *values.entry(port.clone()).or_insert(0) |= u64::from(digit) << bit;
        }
        Some(values)
    }
}

/// The first line of a graph's file, and its numbers.
pub fn header(path: &Path) -> Result<(String, Vec<u64>), Error> {
    let bytes = read(path)?;
    let line = bytes.split(|&byte| byte == b'\n').next().unwrap_or_default();
    let line = String::from_utf8_lossy(line).into_owned();
    let numbers = line.split(' ').skip(1).map_while(|word| word.parse().ok()).collect();
    Ok((line, numbers))
}

/// Lines are "input 3 1 a_i": the fourth input is bit 1 of `a_i`.
fn inputs(map: &str) -> Vec<(String, u32)> {
    let mut inputs = BTreeMap::new();
    for line in map.lines() {
        if let ["input", position, bit, name] = line.split(' ').collect::<Vec<_>>()[..]
            && let (Ok(position), Ok(bit)) = (position.parse::<usize>(), bit.parse())
        {
            inputs.insert(position, (name.to_string(), bit));
        }
    }
    inputs.into_values().collect()
}

fn ports(bits: &[(String, u32)]) -> String {
    let mut widths: BTreeMap<&str, u32> = BTreeMap::new();
    bits.iter().for_each(|(name, _)| *widths.entry(name).or_default() += 1);
    let names: Vec<String> = widths.into_iter().map(|(name, width)| format!("{name} ({width})")).collect();
    names.join(", ")
}
