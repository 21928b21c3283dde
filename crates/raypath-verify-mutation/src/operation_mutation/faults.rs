//! The faults of an operation's dataflow.

use super::graph::{Graph, Id, Kind, Leaf, Node, Op};
use raypath_ops::{Direction, Narrowing, Relation, Test};

/// A change of the dataflow.
#[derive(Debug, Clone)]
pub struct Fault {
    /// The place and the change in words.
    pub text: String,
    /// Nodes that become others, in ascending order.
    pub nodes: Vec<Changed>,
    /// Two outputs, by position, that are exchanged.
    pub outputs: Option<[usize; 2]>,
    /// Two values of the state, by position, whose next values are exchanged.
    pub states: Option<[usize; 2]>,
}

/// A node that becomes another one.
#[derive(Debug, Clone)]
pub struct Changed {
    pub id: Id,
    pub op: Op,
    pub operands: Vec<Id>,
    /// The result is inverted: a truth value.
    pub inverted: bool,
}

impl Fault {
    /// The graph with the fault. Nodes keep their positions.
    pub fn apply(&self, graph: &Graph) -> Graph {
        let mut faulty = graph.clone();
        for Changed { id, op, operands, inverted } in self.nodes.iter().cloned() {
            let name = faulty.nodes[id].name.clone();
            faulty.nodes[id] = Node { op, operands, inverted, name };
        }
        if let Some([a, b]) = self.outputs {
            let nodes = [faulty.outputs[a].node, faulty.outputs[b].node];
            [faulty.outputs[b].node, faulty.outputs[a].node] = nodes;
        }
        if let Some([a, b]) = self.states {
            let nodes = [faulty.states[a].1, faulty.states[b].1];
            [faulty.states[b].1, faulty.states[a].1] = nodes;
        }
        faulty
    }
}

const RELATIONS: [Relation; 5] =
    [Relation::Less, Relation::LessOrEqual, Relation::Equal, Relation::GreaterOrEqual, Relation::Greater];
const TESTS: [Test; 7] =
    [Test::SignBit, Test::Zero, Test::Nan, Test::AtLeastZero, Test::AboveZero, Test::AtMostZero, Test::BelowZero];

/// All faults of a dataflow: those of each node that has an effect, and exchanged ports and states.
///
/// Sums become differences, products become sums, and an operand is left out; operands of differences and comparisons
/// are exchanged; a relation becomes each other one, or the complement of each, which differs for NaN; a test becomes
/// each other one, or its complement; a selection is inverted or stuck at one side; conjunctions and disjunctions
/// become each other, or lose an operand; negations are left out; constants change; a rounding has another direction,
/// margin or number of bits, or is left out; and an operand is replaced by the value of its type that was computed
/// before it.
pub fn faults(graph: &Graph) -> Vec<Fault> {
    let live = graph.live();
    let mut list = List { graph, live: &live, faults: Vec::new() };
    for id in (0..graph.nodes.len()).filter(|&id| live[id]) {
        list.operator(id);
        list.other_operands(id);
    }
    list.inputs();
    list.outputs_and_states();
    list.faults
}

struct List<'g> {
    graph: &'g Graph,
    live: &'g [bool],
    faults: Vec<Fault>,
}

impl List<'_> {
    fn becomes(&mut self, id: Id, op: Op, operands: &[Id], how: &str) {
        self.add(id, Changed { id, op, operands: operands.to_vec(), inverted: false }, how);
    }

    fn complement(&mut self, id: Id, op: Op, operands: &[Id], how: &str) {
        self.add(id, Changed { id, op, operands: operands.to_vec(), inverted: true }, how);
    }

    fn add(&mut self, id: Id, changed: Changed, how: &str) {
        let node = &self.graph.nodes[id];
        if changed.inverted || (changed.op, &changed.operands) != (node.op, &node.operands) {
            let text = format!("{}: {how}", self.graph.describe(id));
            self.faults.push(Fault { text, nodes: vec![changed], outputs: None, states: None });
        }
    }

    fn operator(&mut self, id: Id) {
        let Node { op, operands, .. } = self.graph.nodes[id].clone();
        let all = operands.as_slice();
        match (op, all) {
            (Op::Add | Op::Subtract | Op::Multiply | Op::And | Op::Or, &[a, b]) => {
                match op {
                    Op::Add => self.becomes(id, Op::Subtract, all, "a difference"),
                    Op::Subtract => {
                        self.becomes(id, Op::Add, all, "a sum");
                        self.becomes(id, op, &[b, a], "operands exchanged");
                    }
                    Op::Multiply => self.becomes(id, Op::Add, all, "a sum"),
                    Op::And => self.becomes(id, Op::Or, all, "a disjunction"),
                    _ => self.becomes(id, Op::And, all, "a conjunction"),
                }
                self.becomes(id, Op::Same(op.kind()), &[a], "the second operand left out");
                self.becomes(id, Op::Same(op.kind()), &[b], "the first operand left out");
            }
            (Op::Sum, terms) => {
                for place in 0..terms.len() {
                    let rest = [&terms[..place], &terms[place + 1..]].concat();
                    let rest_op = if rest.len() == 2 { Op::Add } else { op };
                    self.becomes(id, rest_op, &rest, &format!("term {place} left out"));
                }
            }
            (Op::Negate, &[a]) => self.becomes(id, Op::Same(Kind::Number), &[a], "left out"),
            (Op::Not, &[a]) => self.becomes(id, Op::Same(Kind::Bit), &[a], "left out"),
            (Op::Narrow(to), &[a]) => self.narrowing(id, a, to),
            (Op::Compare, &[a, b]) => self.becomes(id, op, &[b, a], "operands exchanged"),
            (Op::Relation(own), _) => {
                for relation in RELATIONS {
                    let op = Op::Relation(relation);
                    self.becomes(id, op, all, &format!("{relation:?} instead of {own:?}"));
                    self.complement(id, op, all, &format!("not {relation:?} instead of {own:?}"));
                }
            }
            (Op::Test(own), _) => {
                for test in TESTS {
                    self.becomes(id, Op::Test(test), all, &format!("{test:?} instead of {own:?}"));
                }
                self.complement(id, op, all, "inverted");
            }
            (Op::Select(kind), &[condition, if_true, if_false]) if if_true != if_false => {
                self.becomes(id, op, &[condition, if_false, if_true], "condition inverted");
                self.becomes(id, Op::Same(kind), &[if_true], "stuck at the first");
                self.becomes(id, Op::Same(kind), &[if_false], "stuck at the second");
            }
            (Op::NumberOf(_), _) => self.becomes(id, Op::Constant(0.0), &[], "zero"),
            (Op::WordEqual, _) => self.complement(id, op, all, "inverted"),
            (Op::WordLess, &[a, b]) => {
                self.becomes(id, op, &[b, a], "operands exchanged");
                self.becomes(id, Op::WordEqual, all, "equal instead of less");
                self.complement(id, op, all, "inverted");
            }
            _ => self.constant(id, op),
        }
    }

    fn narrowing(&mut self, id: Id, a: Id, to: Narrowing) {
        let direction = match to.direction {
            Direction::TowardZero => Direction::AwayFromZero,
            Direction::AwayFromZero => Direction::TowardZero,
        };
        self.becomes(id, Op::Same(Kind::Number), &[a], "left out");
        self.becomes(id, Op::Narrow(Narrowing { direction, ..to }), &[a], "in the other direction");
        self.becomes(id, Op::Narrow(Narrowing { bits: to.bits - 1, ..to }), &[a], "one bit fewer");
        if to.bits < 24 {
            self.becomes(id, Op::Narrow(Narrowing { bits: to.bits + 1, ..to }), &[a], "one bit more");
        }
        let margin = if to.margin == 0 { 1 } else { to.margin - 1 };
        self.becomes(id, Op::Narrow(to.margin(margin)), &[a], &format!("margin {margin} instead of {}", to.margin));
    }

    fn constant(&mut self, id: Id, op: Op) {
        let others: Vec<Op> = match op {
            Op::Constant(0.0) => [-0.0, 1.0, f32::INFINITY].map(Op::Constant).to_vec(),
            Op::Constant(value) => [-value, 0.0, f32::MAX].map(Op::Constant).to_vec(),
            Op::OnePlusUlps(ulps) => [ulps - 1, ulps + 1, 0].map(Op::OnePlusUlps).to_vec(),
            Op::Bit(value) => vec![Op::Bit(!value)],
            Op::Word(width, value) => {
                let values = [value ^ 1, value ^ 1 << (width - 1)];
                values[..width.min(2) as usize].iter().map(|&value| Op::Word(width, value)).collect()
            }
            _ => vec![],
        };
        for other in others {
            // Not by `becomes`, because −0 equals +0 as a number.
            let changed = Changed { id, op: other, operands: vec![], inverted: false };
            let text = format!("{}: {other:?} instead of {op:?}", self.graph.describe(id));
            self.faults.push(Fault { text, nodes: vec![changed], outputs: None, states: None });
        }
    }

    /// Each operand replaced by the nearest earlier value of its type that is no constant.
    fn other_operands(&mut self, id: Id) {
        let Node { op, operands, .. } = self.graph.nodes[id].clone();
        for (place, &operand) in operands.iter().enumerate() {
            let nodes = &self.graph.nodes;
            let is_other = |&other: &Id| {
                let other_op = nodes[other].op;
                self.live[other]
                    && other_op.kind() == nodes[operand].op.kind()
                    && !other_op.is_constant()
                    && !operands.contains(&other)
            };
            if nodes[operand].op.is_constant() {
                continue;
            }
            if let Some(other) = (0..operand).rev().find(is_other).or_else(|| (operand + 1..id).find(is_other)) {
                let mut changed = operands.clone();
                changed[place] = other;
                let [was, becomes] = [operand, other].map(|id| self.graph.describe(id));
                self.becomes(id, op, &changed, &format!("reads {becomes} instead of {was}"));
            }
        }
    }

    /// Each input exchanged with the next one of its type.
    fn inputs(&mut self) {
        let is_read = |id: &Id| self.live[*id] && matches!(self.graph.nodes[*id].op, Op::Input(..));
        let read: Vec<Id> = (0..self.graph.nodes.len()).filter(is_read).collect();
        for (place, &a) in read.iter().enumerate() {
            let op = self.graph.nodes[a].op;
            let is_alike = |b: &&Id| self.graph.nodes[**b].op.kind() == op.kind();
            let Some(&b) = read[place + 1..].iter().find(is_alike) else { continue };
            let changed = |id: Id, op: Op| Changed { id, op, operands: vec![], inverted: false };
            let nodes = vec![changed(a, self.graph.nodes[b].op), changed(b, op)];
            let text = format!("input {} exchanged with {}", self.graph.describe(a), self.graph.describe(b));
            self.faults.push(Fault { text, nodes, outputs: None, states: None });
        }
    }

    /// Each output, and each next value of the state, exchanged with the next one of its type.
    fn outputs_and_states(&mut self) {
        let kind = |id: Id| self.graph.nodes[id].op.kind();
        let outputs = &self.graph.outputs;
        for (a, leaf) in outputs.iter().enumerate() {
            let is_alike = |other: &Leaf| kind(other.node) == kind(leaf.node) && other.node != leaf.node;
            let Some(more) = outputs[a + 1..].iter().position(is_alike) else { continue };
            let b = a + 1 + more;
            let name = |leaf: &Leaf| format!("{} bit {}", self.graph.ports_out[leaf.port].name, leaf.bit);
            let text = format!("output {} exchanged with {}", name(leaf), name(&outputs[b]));
            self.faults.push(Fault { text, nodes: vec![], outputs: Some([a, b]), states: None });
        }
        for a in 1..self.graph.states.len() {
            let text = format!("next value of state {} exchanged with that of {}", a - 1, a);
            self.faults.push(Fault { text, nodes: vec![], outputs: None, states: Some([a - 1, a]) });
        }
    }
}
