//! A design over several cycles, as terms of a script.

use super::design::{Design, Id, MULTIPLIER_CYCLES, NodeKind};
use super::script::{Script, Term};
use super::units::unit_output;
use num_bigint::BigUint;
use raypath_tools::ToolError;
use raypath_verify::Error;
use std::collections::HashMap;

/// The values of a design's nodes in the cycles that were asked for.
///
/// The reset is on in cycle 0 and off later. Registers have any value in cycle 0. What the reset and the handshake
/// decide is a constant, and what a constant does not select is not asked for: a job alone never meets the memory at a
/// deep pipeline's exit.
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
            let needed = self.needed(script, at)?;
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

    /// The nodes that a node's value follows from, and their cycles, as far as known values tell.
    fn needed(&self, script: &Script, (cycle, id): (u32, Id)) -> Result<Vec<(u32, Id)>, Error> {
        let node =
            self.design.nodes.get(&id).ok_or_else(|| unexpected(&format!("node {id}"), "a node of the design"))?;
        Ok(match &node.kind {
            NodeKind::Input(Some(name)) => match self.design.unit_output(name) {
                Some((instance, module, port)) => {
                    let module = &self.design.modules[module];
                    let delay = if module.products.contains(port) { MULTIPLIER_CYCLES } else { 0 };
                    let operand = |at: u32| {
                        module.operands(port).map(move |operand| {
                            let name = format!("{instance}.{operand}_i");
                            let id = self.design.outputs.get(&name).copied();
                            id.map(|id| (at, id)).ok_or_else(|| unexpected("no such port", &name))
                        })
                    };
                    cycle.checked_sub(delay).into_iter().flat_map(operand).collect::<Result<_, _>>()?
                }
                None => vec![],
            },
            NodeKind::State { next: Some(next) } if cycle > 0 => vec![(cycle - 1, *next)],
            NodeKind::Operator { name, operands, .. } if name == "ite" => {
                let select = (cycle, operands[0]);
                match self.values.get(&select).map(|&select| script.known(select)) {
                    None => vec![select],
                    Some(None) => operands.iter().map(|&operand| (cycle, operand)).collect(),
                    Some(Some(value)) => vec![(cycle, operands[if *value == BigUint::ZERO { 2 } else { 1 }])],
                }
            }
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
                // A product of what a multiplier read before the first cycle.
                Some(_) if operands.is_empty() => script.free(width),
                Some((_, module, port)) => unit_output(script, module, port, operands, width),
                None => script.free(width),
            },
            NodeKind::State { next: Some(_) } if cycle > 0 => operands[0],
            NodeKind::Input(None) | NodeKind::State { .. } => script.free(width),
            NodeKind::Constant(bits) => {
                let value = BigUint::parse_bytes(bits.as_bytes(), 2);
                script.wide_constant(width, value.ok_or_else(|| unexpected(bits, "a constant in binary"))?)
            }
            // The operand that a constant selects.
            NodeKind::Operator { name, .. } if name == "ite" && operands.len() == 1 => operands[0],
            NodeKind::Operator { name, numbers, .. } => operator(script, width, name, operands, numbers)?,
        })
    }
}

/// An operator of BTOR2 as one of SMT-LIB.
fn operator(script: &mut Script, width: u32, name: &str, operands: &[Term], numbers: &[u32]) -> Result<Term, Error> {
    // A job that is not there does nothing, whatever its words are.
    if name == "and" && operands.iter().any(|&operand| script.known(operand) == Some(&BigUint::ZERO)) {
        return Ok(script.constant(width, 0));
    }
    let known: Option<Vec<&BigUint>> = operands.iter().map(|&operand| script.known(operand)).collect();
    if let Some(value) = known.and_then(|known| folded(width, name, operands, &known, numbers)) {
        return Ok(script.wide_constant(width, value));
    }
    let compared = |relation: &str| format!("({relation} {} {})", operands[0], operands[1]);
    Ok(match (name, numbers) {
        ("not", _) => script.operator(width, "bvnot", operands),
        ("and", _) => script.operator(width, "bvand", operands),
        ("or", _) => script.operator(width, "bvor", operands),
        ("xor", _) => script.operator(width, "bvxor", operands),
        ("xnor", _) => script.operator(width, "bvxnor", operands),
        ("concat", _) => script.concatenate(operands[0], operands[1]),
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

/// The value of an operator of constants, for those that the control has.
fn folded(width: u32, name: &str, operands: &[Term], known: &[&BigUint], numbers: &[u32]) -> Option<BigUint> {
    let ones = |width: u32| (BigUint::from(1_u8) << width) - 1_u8;
    let value = match (name, known, numbers) {
        ("not", &[a], _) => a ^ ones(width),
        ("and", &[a, b], _) => a & b,
        ("or", &[a, b], _) => a | b,
        ("xor", &[a, b], _) => a ^ b,
        ("concat", &[a, b], _) => (a << operands[1].width) | b,
        ("add", &[a, b], _) => a + b,
        ("sub", &[a, b], _) => a + ones(width) + 1_u8 - b,
        ("slice", &[a], &[_, low]) => a >> low,
        ("uext", &[a], _) => a.clone(),
        ("eq", &[a, b], _) => u8::from(a == b).into(),
        ("neq", &[a, b], _) => u8::from(a != b).into(),
        ("redor", &[a], _) => u8::from(*a != BigUint::ZERO).into(),
        ("redand", &[a], _) => u8::from(*a == ones(operands[0].width)).into(),
        _ => return None,
    };
    Some(value & ones(width))
}

fn unexpected(found: &str, expected: &str) -> Error {
    ToolError::unexpected("yosys", found.to_string(), expected.to_string()).into()
}
