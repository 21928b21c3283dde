//! And-inverter graphs as Yosys writes them, with the names of their inputs.

use super::Miter;
use crate::error::Error;
use raypath_tools::{ToolError, read};
use std::collections::BTreeMap;
use std::path::Path;

/// A graph without state and with one output. A literal is twice a variable, and one more for its negation. Variable 0
/// is the constant 0; the inputs and then the gates follow.
pub struct Graph {
    inputs: u32,
    output: u32,
    /// The two literals of each gate.
    pub gates: Vec<[u32; 2]>,
}

impl Graph {
    /// Parses the binary form of AIGER; none if it is damaged, has state, or not one output.
    pub fn parse(graph: &[u8]) -> Option<Self> {
        let mut lines = graph.splitn(3, |&byte| byte == b'\n');
        let header = std::str::from_utf8(lines.next()?).ok()?.strip_prefix("aig ")?;
        let numbers: Vec<u32> = header.split(' ').map(|number| number.parse().ok()).collect::<Option<_>>()?;
        let [_, inputs, 0, 1, count] = numbers[..] else { return None };
        let output = std::str::from_utf8(lines.next()?).ok()?.parse().ok()?;
        let mut bytes = lines.next()?;
        let mut gates = Vec::new();
        for gate in 0..count {
            let a = (2 * (inputs + gate + 1)).checked_sub(number(&mut bytes)?)?;
            gates.push([a, a.checked_sub(number(&mut bytes)?)?]);
        }
        Some(Self { inputs, output, gates })
    }

    /// The output for these inputs, of which there are as many as the graph has.
    pub fn evaluate(&self, inputs: impl IntoIterator<Item = bool>) -> bool {
        let mut values: Vec<bool> = std::iter::once(false).chain(inputs).collect();
        let value = |values: &[bool], literal: u32| values[literal as usize / 2] ^ (literal % 2 == 1);
        for gate in &self.gates {
            values.push(gate.iter().all(|&literal| value(&values, literal)));
        }
        value(&values, self.output)
    }
}

/// A number of seven bits in each byte, the lowest first, of which all but the last have the top bit set.
fn number(bytes: &mut &[u8]) -> Option<u32> {
    let mut value = 0;
    for shift in (0..32).step_by(7) {
        let (&byte, rest) = bytes.split_first()?;
        *bytes = rest;
        value |= u32::from(byte & 0x7f).checked_shl(shift)?;
        if byte < 0x80 {
            return Some(value);
        }
    }
    None
}

/// A graph in a file, checked against its problem.
pub struct Aiger {
    pub problem: String,
    /// The graph's file name in its folder.
    pub file: String,
    pub graph: Graph,
    /// The port and bit of each input.
    inputs: Vec<(String, u32)>,
}

impl Aiger {
    /// Reads the graph of the problem with this number. It must have the problem's inputs, one output and no state.
    pub fn read(folder: &Path, number: usize, problem: &Miter) -> Result<Self, Error> {
        let file = format!("{number}.aig");
        let map = read(&folder.join(format!("{number}.map")))?;
        let inputs = inputs(&String::from_utf8_lossy(&map));
        let mut found = inputs.clone();
        found.sort();
        let mut expected: Vec<(String, u32)> =
            problem.inputs.iter().flat_map(|(name, width)| (0..*width).map(|bit| (name.clone(), bit))).collect();
        expected.sort();
        match Graph::parse(&read(&folder.join(&file))?) {
            Some(graph) if found == expected && graph.inputs as usize == expected.len() => {
                Ok(Self { problem: problem.name.clone(), file, graph, inputs })
            }
            _ => {
                let (header, _) = header(&folder.join(&file))?;
                let found = format!("{}: found a circuit '{header}' with inputs {}", problem.name, ports(&found));
                let expected = format!("one output, no latches and the inputs {}", ports(&expected));
                Err(ToolError::unexpected("yosys", found, expected).into())
            }
        }
    }

    /// The ports' values from a word that begins with a digit 0 or 1 for each input, in order; none if there are fewer,
    /// or if the output is not 1 for them.
    pub fn counterexample(&self, word: &str) -> Option<BTreeMap<String, u64>> {
        let digits = word.chars().take(self.inputs.len()).map(|digit| digit.to_digit(2));
        let digits: Vec<u32> = digits.collect::<Option<_>>()?;
        let is_one = digits.len() == self.inputs.len() && self.graph.evaluate(digits.iter().map(|&digit| digit == 1));
        let mut values = BTreeMap::new();
        for ((port, bit), digit) in self.inputs.iter().zip(digits) {
            *values.entry(port.clone()).or_insert(0) |= u64::from(digit) << bit;
        }
        is_one.then_some(values)
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

#[cfg(test)]
mod tests {
    use super::Graph;

    /// Two inputs; gate 3 is 1 and 2, gate 4 is not 1 and 2, gate 5 is both gates, which is the output.
    const GRAPH: &[u8] = b"aig 5 2 0 1 3\n10\n\x02\x02\x04\x01\x02\x02";

    #[test]
    fn a_graph_is_evaluated() {
        let graph = Graph::parse(GRAPH).expect("a graph");
        let other = Graph { output: 9, ..Graph::parse(GRAPH).expect("a graph") };
        for inputs in [[false, false], [false, true], [true, false], [true, true]] {
            assert!(!graph.evaluate(inputs) && other.evaluate(inputs) != (inputs == [false, true]), "{inputs:?}");
        }
        assert!(Graph::parse(b"aig 1 0 1 1 0\n2\n2\n").is_none() && Graph::parse(&GRAPH[..18]).is_none());
    }
}
