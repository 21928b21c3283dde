//! The faults of an operation's dataflow.

use super::evaluate::Dataflow;
use raypath_ops::{Direction, Narrowing, Relation, Test};
use raypath_rtl::dataflow::{Kind, NodeId, Op};

/// A change of the dataflow.
#[derive(Debug, Clone)]
pub struct Fault {
    /// The place and the change in words.
    pub text: String,
    change: Change,
}

#[derive(Debug, Clone)]
enum Change {
    /// A node computes something else, or its complement.
    Node { id: NodeId, op: Op, is_inverted: bool },
    /// Two inputs are exchanged.
    Inputs([NodeId; 2]),
    /// Two outputs, by position, are exchanged.
    Outputs([usize; 2]),
    /// The next values of two states, by position, are exchanged.
    States([usize; 2]),
}

impl Fault {
    /// The dataflow with the fault. Nodes keep their positions.
    pub fn apply(&self, flow: &Dataflow) -> Dataflow {
        let mut faulty = flow.clone();
        let graph = &mut faulty.graph;
        match self.change.clone() {
            Change::Node { id, op, is_inverted } => {
                graph.nodes[id.index()].op = op;
                faulty.inverted = is_inverted.then_some(id);
            }
            Change::Inputs([a, b]) => {
                let [first, second] = [a, b].map(|id| flow.graph.node(id).op.clone());
                (graph.nodes[a.index()].op, graph.nodes[b.index()].op) = (second, first);
            }
            Change::Outputs([a, b]) => {
                (graph.outputs[a].node, graph.outputs[b].node) = (graph.outputs[b].node, graph.outputs[a].node);
            }
            Change::States([a, b]) => {
                (graph.states[a].next, graph.states[b].next) = (graph.states[b].next, graph.states[a].next);
            }
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
pub fn faults(flow: &Dataflow) -> Vec<Fault> {
    let live = flow.graph.live();
    let mut list = List { flow, live: &live, faults: Vec::new() };
    for id in flow.graph.ids().filter(|id| live[id.index()]) {
        list.operator(id);
        list.other_operands(id);
    }
    list.inputs();
    list.outputs_and_states();
    list.faults
}

struct List<'g> {
    flow: &'g Dataflow,
    live: &'g [bool],
    faults: Vec<Fault>,
}

impl List<'_> {
    fn add(&mut self, id: NodeId, how: &str, op: Op, is_inverted: bool) {
        let was = &self.flow.graph.node(id).op;
        if is_inverted || op != *was {
            let text = format!("{} ({was:?}), node {}: {how}", self.flow.graph.name_of(id), id.0);
            self.faults.push(Fault { text, change: Change::Node { id, op, is_inverted } });
        }
    }

    /// A node becomes another one.
    fn becomes(&mut self, id: NodeId, how: &str, op: Op) {
        self.add(id, how, op, false);
    }

    /// A node passes on an operand.
    fn passes(&mut self, id: NodeId, how: &str, operand: NodeId) {
        self.add(id, how, Op::Continue(operand), false);
    }

    fn operator(&mut self, id: NodeId) {
        let op = self.flow.graph.node(id).op.clone();
        match op {
            Op::Add(a, b) | Op::Subtract(a, b) | Op::Multiply(a, b) | Op::And(a, b) | Op::Or(a, b) => {
                match op {
                    Op::Add(..) => self.becomes(id, "a difference", Op::Subtract(a, b)),
                    Op::Subtract(..) => {
                        self.becomes(id, "a sum", Op::Add(a, b));
                        self.becomes(id, "operands exchanged", Op::Subtract(b, a));
                    }
                    Op::Multiply(..) => self.becomes(id, "a sum", Op::Add(a, b)),
                    Op::And(..) => self.becomes(id, "a disjunction", Op::Or(a, b)),
                    _ => self.becomes(id, "a conjunction", Op::And(a, b)),
                }
                self.passes(id, "the second operand left out", a);
                self.passes(id, "the first operand left out", b);
            }
            Op::Sum(terms) => {
                for place in 0..terms.len() {
                    let rest = [&terms[..place], &terms[place + 1..]].concat();
                    let rest = if let [a, b] = *rest { Op::Add(a, b) } else { Op::Sum(rest) };
                    self.becomes(id, &format!("term {place} left out"), rest);
                }
            }
            Op::Negate(a) | Op::Not(a) => self.passes(id, "left out", a),
            Op::Narrow(a, to) => self.narrowing(id, a, to),
            Op::Compare(a, b) => self.becomes(id, "operands exchanged", Op::Compare(b, a)),
            Op::Relation(order, _) => {
                for relation in RELATIONS {
                    self.add(id, &format!("{relation:?}"), Op::Relation(order, relation), false);
                    self.add(id, &format!("not {relation:?}"), Op::Relation(order, relation), true);
                }
            }
            Op::Test(_, a) => {
                for test in TESTS {
                    self.becomes(id, &format!("{test:?}"), Op::Test(test, a));
                }
                self.add(id, "inverted", op, true);
            }
            Op::Select(condition, a, b) if a != b => {
                self.becomes(id, "condition inverted", Op::Select(condition, b, a));
                self.passes(id, "stuck at the first", a);
                self.passes(id, "stuck at the second", b);
            }
            Op::NumberOf(_) => self.becomes(id, "zero", Op::Number(0)),
            Op::WordEqual(..) => self.add(id, "inverted", op, true),
            Op::WordLess(a, b) => {
                self.becomes(id, "operands exchanged", Op::WordLess(b, a));
                self.becomes(id, "equal instead of less", Op::WordEqual(a, b));
                self.add(id, "inverted", op, true);
            }
            _ => self.constant(id, &op),
        }
    }

    fn narrowing(&mut self, id: NodeId, a: NodeId, to: Narrowing) {
        let direction = match to.direction {
            Direction::TowardZero => Direction::AwayFromZero,
            Direction::AwayFromZero => Direction::TowardZero,
        };
        self.passes(id, "left out", a);
        self.becomes(id, "in the other direction", Op::Narrow(a, Narrowing { direction, ..to }));
        self.becomes(id, "one bit fewer", Op::Narrow(a, Narrowing { bits: to.bits - 1, ..to }));
        if to.bits < 24 {
            self.becomes(id, "one bit more", Op::Narrow(a, Narrowing { bits: to.bits + 1, ..to }));
        }
        let margin = if to.margin == 0 { 1 } else { to.margin - 1 };
        self.becomes(id, &format!("margin {margin}"), Op::Narrow(a, to.margin(margin)));
    }

    fn constant(&mut self, id: NodeId, op: &Op) {
        let number = |value: f32| Op::Number(value.to_bits());
        let others: Vec<Op> = match *op {
            Op::Number(0) => [-0.0, 1.0, f32::INFINITY].map(number).to_vec(),
            Op::Number(bits) => vec![Op::Number(bits ^ 1 << 31), number(0.0), number(f32::MAX)],
            Op::Ulps(ulps) => [ulps / 2, 2 * ulps, 0].map(Op::Ulps).to_vec(),
            Op::Bit(value) => vec![Op::Bit(!value)],
            Op::Word(value) => match self.flow.graph.node(id).kind {
                Kind::Word(width) if width > 1 => [value ^ 1, value ^ 1 << (width - 1)].map(Op::Word).to_vec(),
                _ => vec![Op::Word(value ^ 1)],
            },
            _ => vec![],
        };
        for other in others {
            self.becomes(id, &format!("{other:?}"), other.clone());
        }
    }

    /// Each operand replaced by the nearest earlier value of its type that is no constant.
    fn other_operands(&mut self, id: NodeId) {
        let graph = &self.flow.graph;
        let operands = graph.operands(id);
        for (place, &operand) in operands.iter().enumerate().filter(|(_, operand)| !self.flow.is_constant(**operand)) {
            let is_other = |other: &NodeId| {
                let is_alike = graph.node(*other).kind == graph.node(operand).kind;
                is_alike && self.live[other.index()] && !self.flow.is_constant(*other) && !operands.contains(other)
            };
            let before = (0..operand.0).rev().map(NodeId).find(is_other);
            if let Some(other) = before.or_else(|| (operand.0 + 1..id.0).map(NodeId).find(is_other)) {
                let mut op = graph.node(id).op.clone();
                if let Some(changed) = operands_of(&mut op).into_iter().nth(place) {
                    *changed = other;
                }
                let how = format!("reads {} instead of {}", graph.name_of(other), graph.name_of(operand));
                self.becomes(id, &how, op);
            }
        }
    }

    /// Each input exchanged with the next one of its type.
    fn inputs(&mut self) {
        let graph = &self.flow.graph;
        let is_read = |id: &NodeId| self.live[id.index()] && matches!(graph.node(*id).op, Op::Input(_));
        let read: Vec<NodeId> = graph.ids().filter(is_read).collect();
        for (place, &a) in read.iter().enumerate() {
            let is_alike = |b: &&NodeId| graph.node(**b).kind == graph.node(a).kind;
            let Some(&b) = read[place + 1..].iter().find(is_alike) else { continue };
            let text = format!("input {} exchanged with {}", graph.name_of(a), graph.name_of(b));
            self.faults.push(Fault { text, change: Change::Inputs([a, b]) });
        }
    }

    /// Each output, and each next value of the state, exchanged with the next one of its type.
    fn outputs_and_states(&mut self) {
        let graph = &self.flow.graph;
        let kind = |id: NodeId| graph.node(id).kind;
        for (a, output) in graph.outputs.iter().enumerate() {
            let rest = graph.outputs.iter().enumerate().skip(a + 1);
            let is_alike = |other: NodeId| kind(other) == kind(output.node) && other != output.node;
            let Some((b, other)) = rest.into_iter().find(|(_, other)| is_alike(other.node)) else { continue };
            let text = format!("output {:?} exchanged with {:?}", output.port, other.port);
            self.faults.push(Fault { text, change: Change::Outputs([a, b]) });
        }
        for a in 1..graph.states.len() {
            let text = format!("next value of state {} exchanged with that of {a}", a - 1);
            self.faults.push(Fault { text, change: Change::States([a - 1, a]) });
        }
    }
}

/// The operands of an operator, to change them.
fn operands_of(op: &mut Op) -> Vec<&mut NodeId> {
    match op {
        Op::Input(_) | Op::State(_) | Op::Number(_) | Op::Ulps(_) | Op::Bit(_) | Op::Word(_) => vec![],
        Op::Sum(terms) => terms.iter_mut().collect(),
        Op::Continue(a) | Op::Negate(a) | Op::Narrow(a, _) | Op::NumberOf(a) => vec![a],
        Op::Test(_, a) | Op::Relation(a, _) | Op::Flags(a) | Op::Not(a) => vec![a],
        Op::Add(a, b) | Op::Subtract(a, b) | Op::Multiply(a, b) | Op::Compare(a, b) => vec![a, b],
        Op::And(a, b) | Op::Or(a, b) | Op::WordEqual(a, b) | Op::WordLess(a, b) | Op::WordOr(a, b) => vec![a, b],
        Op::Select(a, b, c) | Op::Residue(a, b, c) => vec![a, b, c],
    }
}
