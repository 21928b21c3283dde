//! A design over several cycles, as terms of a script.

use super::design::{Design, Id, NodeKind};
use super::script::{Script, Term};
use super::units::unit_output;
use raypath_tools::ToolError;
use raypath_verify::Error;
use std::collections::HashMap;

/// The values of a design's nodes in the cycles that were asked for.
///
/// The reset is on in cycle 0 and off later. Registers have any value in cycle 0.
pub(super) struct Unrolled<'d> {
    design: &'d Design,
    values: HashMap<(u32, Id), Term>,
}

impl<'d> Unrolled<'d> {
    pub fn new(design: &'d Design) -> Self {
        Self { design, values: HashMap::new() }
    }

    /// Gives a node a value in a cycle. It must not have been used there before.
    pub fn set(&mut self, cycle: u32, node: Id, value: Term) {
        self.values.insert((cycle, node), value);
    }

    /// The value of a node in a cycle.
    pub fn value(&mut self, script: &mut Script, cycle: u32, node: Id) -> Result<Term, Error> {
        // Not recursive, because a chain of operators over all cycles is long.
        let mut open = vec![(cycle, node)];
        while let Some(&at) = open.last() {
            if self.values.contains_key(&at) {
                open.pop();
                continue;
            }
            let needed = self.needed(at)?;
            let before = open.len();
            open.extend(needed.iter().filter(|at| !self.values.contains_key(at)));
            if open.len() == before {
                let operands: Vec<Term> = needed.iter().map(|at| self.values[at]).collect();
                let value = self.compute(script, at, &operands)?;
                self.values.insert(at, value);
                open.pop();
            }
        }
        Ok(self.values[&(cycle, node)])
    }

    /// The nodes that a node's value follows from, and their cycles.
    fn needed(&self, (cycle, id): (u32, Id)) -> Result<Vec<(u32, Id)>, Error> {
        let node =
            self.design.nodes.get(&id).ok_or_else(|| unexpected(&format!("node {id}"), "a node of the design"))?;
        Ok(match &node.kind {
            NodeKind::Input(Some(name)) => match self.design.unit_output(name) {
                Some((instance, module, _)) => {
                    let operand = |(port, _): &(String, u32)| {
                        let name = format!("{instance}.{port}_i");
                        let id = self.design.outputs.get(&name).copied();
                        id.map(|id| (cycle, id)).ok_or_else(|| unexpected("no such port", &name))
                    };
                    self.design.modules[module].inputs.iter().map(operand).collect::<Result<_, _>>()?
                }
                None => vec![],
            },
            NodeKind::State { next: Some(next) } if cycle > 0 => vec![(cycle - 1, *next)],
            NodeKind::Operator { operands, .. } => operands.iter().map(|&operand| (cycle, operand)).collect(),
            NodeKind::Input(None) | NodeKind::State { .. } | NodeKind::Constant(_) => vec![],
        })
    }

    fn compute(&self, script: &mut Script, (cycle, id): (u32, Id), operands: &[Term]) -> Result<Term, Error> {
        let node = &self.design.nodes[&id];
        let width = node.width;
        Ok(match &node.kind {
            NodeKind::Input(Some(name)) if name == "rst_ni" => script.constant(1, u64::from(cycle > 0)),
            NodeKind::Input(Some(name)) => match self.design.unit_output(name) {
                Some((_, module, port)) => unit_output(script, module, port, operands, width),
                None => script.free(width),
            },
            NodeKind::State { next: Some(_) } if cycle > 0 => operands[0],
            NodeKind::Input(None) | NodeKind::State { .. } => script.free(width),
            NodeKind::Constant(bits) => script.define(width, format!("#b{bits}")),
            NodeKind::Operator { name, numbers, .. } => operator(script, width, name, operands, numbers)?,
        })
    }
}

/// An operator of BTOR2 as one of SMT-LIB.
fn operator(script: &mut Script, width: u32, name: &str, operands: &[Term], numbers: &[u32]) -> Result<Term, Error> {
    let compared = |relation: &str| format!("({relation} {} {})", operands[0], operands[1]);
    Ok(match (name, numbers) {
        ("not", _) => script.operator(width, "bvnot", operands),
        ("and", _) => script.operator(width, "bvand", operands),
        ("or", _) => script.operator(width, "bvor", operands),
        ("xor", _) => script.operator(width, "bvxor", operands),
        ("xnor", _) => script.operator(width, "bvxnor", operands),
        ("concat", _) => script.operator(width, "concat", operands),
        ("add", _) => script.operator(width, "bvadd", operands),
        ("sub", _) => script.operator(width, "bvsub", operands),
        ("sll", _) => script.operator(width, "bvshl", operands),
        ("srl", _) => script.operator(width, "bvlshr", operands),
        ("slice", &[high, low]) => script.slice(operands[0], high, low),
        // Yosys names a node in this way.
        ("uext", &[0]) => operands[0],
        ("uext", &[more]) => script.operator(width, &format!("(_ zero_extend {more})"), operands),
        ("eq", _) => script.bit(&compared("=")),
        ("neq", _) => script.bit(&compared("distinct")),
        ("ult", _) => script.bit(&compared("bvult")),
        ("ulte", _) => script.bit(&compared("bvule")),
        ("ugt", _) => script.bit(&compared("bvugt")),
        ("ugte", _) => script.bit(&compared("bvuge")),
        ("redor", _) => {
            let zero = script.constant(operands[0].width, 0);
            script.bit(&format!("(distinct {} {zero})", operands[0]))
        }
        ("redand", _) => {
            let ones = script.define(operands[0].width, format!("#b{}", "1".repeat(operands[0].width as usize)));
            script.bit(&format!("(= {} {ones})", operands[0]))
        }
        ("ite", _) => script.select(operands[0], operands[1], operands[2]),
        _ => return Err(unexpected(name, "an operator of bit-vectors that raypath's text needs")),
    })
}

fn unexpected(found: &str, expected: &str) -> Error {
    ToolError::unexpected("yosys", found.to_string(), expected.to_string()).into()
}
