//! Certificates of proofs: a second solver, and a program that checks each of its steps.
//!
//! The and-gates of a graph become clauses here, without ABC. CaDiCaL finds that they cannot hold together with the
//! output, and writes the clauses that it learned (DRAT). The crate `dratify` checks that each follows from those
//! before it, up to the empty clause. So a certified proof relies on the graph, on this translation and on the checker,
//! and neither on ABC nor on CaDiCaL.

use crate::error::Error;
use dratify::{Checker, Lit};
use raypath_tools::{Cadical, ToolError, read, write};
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Steps of a certificate for each second of the limit; the checker takes them in about the time of the solver.
const STEPS_PER_SECOND: u64 = 20_000;

/// Whether a proof has a certificate.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Certificate {
    /// It was not tried.
    NotTried,
    /// Every step was checked.
    Checked {
        /// The clauses that were derived or deleted.
        steps: usize,
    },
    /// The solver had no answer within the limit, or its certificate is too long to check.
    TooLong,
    /// The solver contradicts the proof, or its certificate is wrong, for this reason.
    Wrong(String),
}

/// CaDiCaL, and the limit on a proof.
#[derive(Debug, Clone)]
pub struct Certifier {
    pub solver: Cadical,
    pub limit: Duration,
}

impl Certifier {
    pub fn find(limit: Duration) -> Result<Self, Error> {
        Ok(Self { solver: Cadical::find()?, limit })
    }

    /// Certifies that the output of a graph is 0 for all inputs. The graph is in a file of this folder, in the binary
    /// form of AIGER, and has no state.
    pub fn certify(&self, folder: &Path, graph: &str, stop: &AtomicBool) -> Result<Certificate, Error> {
        let bytes = read(&folder.join(graph))?;
        let clauses = Clauses::of(&bytes).ok_or_else(|| unexpected("yosys", graph, "a graph with one output"))?;
        let (input, output) = (format!("{graph}.cnf"), format!("{graph}.drat"));
        write(&folder.join(&input), &clauses.dimacs())?;
        match self.solver.can_hold(folder, &input, &output, self.limit, stop)? {
            None => Ok(Certificate::TooLong),
            Some(true) => Ok(Certificate::Wrong(format!("{} refutes it", self.solver.version))),
            Some(false) => {
                let bytes = read(&folder.join(&output))?;
                let steps = steps(&bytes).ok_or_else(|| unexpected("cadical", &output, "a binary DRAT file"))?;
                if steps.len() as u64 > STEPS_PER_SECOND * self.limit.as_secs() {
                    return Ok(Certificate::TooLong);
                }
                Ok(clauses.check(&steps))
            }
        }
    }
}

fn unexpected(program: &'static str, file: &str, expected: &str) -> Error {
    ToolError::unexpected(program, format!("another content of {file}"), expected).into()
}

/// Clauses that hold if and only if a graph's output can be 1. A literal is a graph's: twice the variable, and one more
/// for its negation. Variable 0 is the constant 0.
struct Clauses {
    variables: u32,
    clauses: Vec<Vec<Lit>>,
}

impl Clauses {
    /// The clauses of a graph in the binary form of AIGER; none if it has state, or not one output.
    fn of(graph: &[u8]) -> Option<Self> {
        let mut lines = graph.splitn(3, |&byte| byte == b'\n');
        let header = std::str::from_utf8(lines.next()?).ok()?.strip_prefix("aig ")?;
        let numbers: Vec<u32> = header.split(' ').map(|number| number.parse().ok()).collect::<Option<_>>()?;
        let [largest, inputs, 0, 1, gates] = numbers[..] else { return None };
        let output = std::str::from_utf8(lines.next()?).ok()?.parse().ok()?;
        let mut bytes = lines.next()?;
        let mut clauses = vec![vec![1], vec![output]];
        for gate in 0..gates {
            let gate = 2 * (inputs + gate + 1);
            let a = gate.checked_sub(number(&mut bytes)?)?;
            let b = a.checked_sub(number(&mut bytes)?)?;
            clauses.extend([vec![gate ^ 1, a], vec![gate ^ 1, b], vec![gate, a ^ 1, b ^ 1]]);
        }
        Some(Self { variables: largest + 1, clauses })
    }

    /// The clauses in the format DIMACS, where the variables begin with 1.
    fn dimacs(&self) -> String {
        let mut text = format!("p cnf {} {}\n", self.variables, self.clauses.len());
        for clause in &self.clauses {
            for literal in clause {
                let sign = if literal & 1 == 1 { "-" } else { "" };
                let _ = write!(text, "{sign}{} ", (literal >> 1) + 1);
            }
            text += "0\n";
        }
        text
    }

    /// Checks that the clauses cannot hold, by these steps.
    fn check(&self, steps: &[(bool, Vec<Lit>)]) -> Certificate {
        if let Some((_, clause)) =
            steps.iter().find(|(_, clause)| clause.iter().any(|literal| literal >> 1 >= self.variables))
        {
            return Certificate::Wrong(format!("its certificate has unknown variables: {clause:?}"));
        }
        let result = Checker::new(self.variables, &self.clauses, true, true).check(steps);
        match result.ok && result.reached_empty {
            true => Certificate::Checked { steps: steps.len() },
            false => Certificate::Wrong(format!("its certificate is wrong: {}", result.reason)),
        }
    }
}

/// The steps of a binary DRAT file: whether a clause is deleted, and the clause. None if it is damaged.
fn steps(mut bytes: &[u8]) -> Option<Vec<(bool, Vec<Lit>)>> {
    let mut steps = Vec::new();
    while let Some((&kind, rest)) = bytes.split_first() {
        bytes = rest;
        let is_deletion = match kind {
            b'a' => false,
            b'd' => true,
            _ => return None,
        };
        let mut clause = Vec::new();
        loop {
            // Twice the variable, which begins with 1, and one more for its negation.
            match number(&mut bytes)? {
                0 => break,
                literal => clause.push(literal.checked_sub(2)?),
            }
        }
        steps.push((is_deletion, clause));
    }
    Some(steps)
}

/// A number of seven bits in each byte, the lowest first, of which all but the last have the top bit set: as both
/// formats have it.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Two inputs; gate 3 is 1 and 2, gate 4 is not 1 and 2, gate 5 is both gates, which is the output.
    const GRAPH: &[u8] = b"aig 5 2 0 1 3\n10\n\x02\x02\x04\x01\x02\x02";

    #[test]
    fn a_graph_becomes_clauses() {
        let clauses = Clauses::of(GRAPH).expect("a graph");
        assert_eq!((clauses.variables, clauses.clauses.len()), (6, 11));
        assert_eq!(clauses.clauses[2..5], [vec![7, 4], vec![7, 2], vec![6, 5, 3]]);
        assert_eq!(clauses.dimacs().lines().nth(4), Some("-4 2 0"));
        assert!(Clauses::of(b"aig 1 0 1 1 0\n2\n2\n").is_none() && Clauses::of(&GRAPH[..20]).is_none());
    }

    #[test]
    fn only_a_complete_certificate_counts() {
        // All combinations of two variables.
        let clauses = vec![vec![2, 4], vec![2, 5], vec![3, 4], vec![3, 5]];
        let all = Clauses { variables: 3, clauses };
        let steps = [(false, vec![2]), (false, vec![])];
        assert_eq!(all.check(&steps), Certificate::Checked { steps: 2 });
        for wrong in [&steps[..0], &[(false, vec![])], &[(false, vec![20])]] {
            assert!(matches!(all.check(wrong), Certificate::Wrong(_)), "{wrong:?}");
        }
        let can_hold = Clauses { variables: 3, clauses: all.clauses[..3].to_vec() };
        assert!(matches!(can_hold.check(&steps), Certificate::Wrong(_)));
    }

    #[test]
    fn damaged_files_are_none() {
        assert_eq!(steps(b"a\x04\x07\0d\x04\x07\0"), Some(vec![(false, vec![2, 5]), (true, vec![2, 5])]));
        for damaged in [&b"a\x04"[..], b"x\0", b"a\x01\0", b"a\xff\xff\xff\xff\xff\xff\0"] {
            assert_eq!(steps(damaged), None);
        }
    }
}
