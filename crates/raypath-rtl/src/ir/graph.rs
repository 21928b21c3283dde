//! The graph of an operation: one node per value, each with its position in the pipeline.

use crate::error::Error;
use crate::ir::position::{LAST_STAGE, Position, STAGES, Stage, Step};
use crate::ir::units::{UnitKind, sum_steps};
use raypath_float::flags;
use raypath_ops::{Narrowing, Relation, Test};
use std::borrow::Cow;

/// The greatest number of operations in a datapath. Opcodes are below it.
pub const MAX_OPERATIONS: u64 = 64;

/// A value, by its index in [`OperationGraph::nodes`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub u32);

impl NodeId {
    /// The index.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// The operator that computes a value.
#[derive(Debug, Clone, PartialEq)]
pub enum Op {
    /// An input port, or one bit of it.
    Input(PortBit),
    /// The operation's state of this number.
    State(usize),
    /// A constant, as the bits of a binary32 number.
    Number(u32),
    /// The constant that is this number of ulps of 1 in the format of the datapath.
    Ulps(u32),
    /// A constant truth value.
    Bit(bool),
    /// A constant word.
    Word(u32),
    /// The next part of a unit with a latency of several steps.
    Continue(NodeId),
    /// A sum of two numbers.
    Add(NodeId, NodeId),
    /// A sum of three or more terms. Its stage is the one in which it is available (`sum_steps`).
    Sum(Vec<NodeId>),
    /// The first number minus the second.
    Subtract(NodeId, NodeId),
    /// A product.
    Multiply(NodeId, NodeId),
    /// The order of two numbers.
    Compare(NodeId, NodeId),
    /// A number with the other sign.
    Negate(NodeId),
    /// A number with a shorter significand.
    Narrow(NodeId, Narrowing),
    /// A word as a number.
    NumberOf(NodeId),
    /// A test of a number's sign or class. It is computed wherever that saves registers
    /// ([`OperationGraph::is_movable`]).
    Test(Test, NodeId),
    /// Whether an order is this one.
    Relation(NodeId, Relation),
    /// The floating-point exceptions of a sum or a product.
    Flags(NodeId),
    /// What rounding takes from the first value, the product of the others.
    Residue(NodeId, NodeId, NodeId),
    /// Both truth values.
    And(NodeId, NodeId),
    /// Either truth value.
    Or(NodeId, NodeId),
    /// The other truth value.
    Not(NodeId),
    /// Whether two words are equal.
    WordEqual(NodeId, NodeId),
    /// Whether the first word is less, as an unsigned number.
    WordLess(NodeId, NodeId),
    /// Bitwise.
    WordOr(NodeId, NodeId),
    /// The second value if the first one, a truth value, is true, otherwise the third.
    Select(NodeId, NodeId, NodeId),
}

impl Op {
    /// Whether an adder or a multiplier computes it. Such a value is rounded and may raise exceptions.
    pub fn rounds(&self) -> bool {
        matches!(self, Self::Add(..) | Self::Subtract(..) | Self::Multiply(..))
    }

    /// The rounding, if it makes a significand shorter.
    pub fn narrowing(&self) -> Option<Narrowing> {
        match self {
            Self::Narrow(_, to) => Some(*to),
            _ => None,
        }
    }
}

/// The type of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A number. Its encoding depends on the register that holds it.
    Number,
    /// An intermediate result between two parts of a unit: the kind of unit, and the part before it (from 0).
    Cut(UnitKind, u32),
    /// A word of this number of bits; a truth value has one.
    Word(u32),
    /// The three results of a comparator.
    Order,
}

/// A value of an operation.
#[derive(Debug, Clone, PartialEq)]
pub struct Node<P> {
    /// What computes it.
    pub op: Op,
    /// Its type.
    pub kind: Kind,
    /// The stage or step that computes it. Constants and state are available at every position.
    pub position: P,
    /// Its name in the operation's description.
    pub name: Option<String>,
}

/// An input or output port without its direction suffix, or one bit of it.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PortBit {
    /// The port's name.
    pub port: String,
    /// The bit and the width of the port, if the value is one bit of several.
    pub bit: Option<(u32, u32)>,
}

/// One output of an operation.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputValue {
    /// The port.
    pub port: PortBit,
    /// The value at the port.
    pub node: NodeId,
}

/// A state register of an operation: it keeps its value from job to job.
#[derive(Debug, Clone, PartialEq)]
pub struct StateValue<P> {
    /// Its name.
    pub name: String,
    /// The value for the next job.
    pub next: NodeId,
    /// The position that writes it.
    pub written: P,
    /// The first position that reads it.
    pub read: P,
}

/// The graph of an operation: its positions are stages before the stages are divided into steps, and steps afterwards.
#[derive(Debug, Clone, PartialEq)]
pub struct OperationGraph<P = Stage> {
    /// The operation's name.
    pub name: &'static str,
    /// The operation's opcode.
    pub opcode: u64,
    /// The values.
    pub nodes: Vec<Node<P>>,
    /// The inputs that the operation has.
    pub inputs: Vec<NodeId>,
    /// The outputs that the operation has.
    pub outputs: Vec<OutputValue>,
    /// The state registers; [`Op::State`] refers to their positions here.
    pub states: Vec<StateValue<P>>,
    /// The descriptions of its stages.
    pub notes: Vec<(u32, Cow<'static, str>)>,
    /// The scheduler assigns the stages. Before that, the positions have no meaning.
    pub is_auto: bool,
    /// The exceptions of all sums and products are an output, so that none of them is dead.
    pub counts_exceptions: bool,
}

impl OperationGraph<Stage> {
    /// Adds a word that each job carries from the input port `tag` to the output port `tag`.
    pub fn add_tag(&mut self, width: u32) -> Result<(), Error> {
        let port = self.new_port("tag")?;
        let node = self.push(Op::Input(port.clone()), Kind::Word(width), Stage::INPUT, Some(port.port.clone()));
        self.inputs.push(node);
        self.outputs.push(OutputValue { port, node });
        Ok(())
    }

    /// Replaces dead values by constants, so that they occupy no unit, step or register. The other values keep their
    /// indices, because names contain them.
    pub fn eliminate_dead_values(&mut self) {
        let live = self.live();
        for (node, is_live) in self.nodes.iter_mut().zip(live) {
            if !is_live && !matches!(node.op, Op::Input(_)) {
                *node = Node { op: Op::Bit(false), kind: Kind::Word(1), position: Stage::INPUT, name: None };
            }
        }
    }

    /// Adds an output `exception_flags`: the exceptions of all sums and products. Each stage combines the exceptions of
    /// its units with the word of the stages before, so that one word crosses the registers. The stages must be
    /// assigned.
    pub fn add_exception_flags(&mut self) -> Result<(), Error> {
        let port = self.new_port("exception_flags")?;
        let kind = Kind::Word(flags::COUNT);
        let mut so_far: Option<NodeId> = None;
        for stage in (1..STAGES).map(Stage) {
            let here = self.ids().filter(|&id| self.node(id).position == stage);
            let units: Vec<NodeId> = here.filter(|&id| self.node(id).op.rounds()).collect();
            let mut raised: Vec<NodeId> =
                units.into_iter().map(|id| self.push(Op::Flags(id), kind, stage, None)).collect();
            if raised.is_empty() {
                continue;
            }
            raised.extend(so_far);
            // As a tree, for a short path.
            while let [_, _, ..] = raised.as_slice() {
                raised = raised
                    .chunks(2)
                    .map(|pair| match *pair {
                        [a, b] => self.push(Op::WordOr(a, b), kind, stage, None),
                        _ => pair[0],
                    })
                    .collect();
            }
            so_far = raised.pop();
            if let Some(NodeId(id)) = so_far {
                self.nodes[id as usize].name = Some(port.port.clone());
            }
        }
        let node = so_far.unwrap_or_else(|| self.push(Op::Word(0), kind, Stage(1), None));
        self.outputs.push(OutputValue { port, node });
        Ok(())
    }

    fn push(&mut self, op: Op, kind: Kind, position: Stage, name: Option<String>) -> NodeId {
        self.nodes.push(Node { op, kind, position, name });
        NodeId(self.nodes.len() as u32 - 1)
    }

    /// A port for a feature of that name; an error if the operation has a port of that name.
    fn new_port(&self, feature: &'static str) -> Result<PortBit, Error> {
        let is_input = |&id: &NodeId| matches!(&self.node(id).op, Op::Input(taken) if taken.port == feature);
        if self.inputs.iter().any(is_input) || self.outputs.iter().any(|output| output.port.port == feature) {
            let problem = format!("operation {} has a port of that name already", self.name);
            return Err(Error::Feature { feature, problem });
        }
        Ok(PortBit { port: feature.to_string(), bit: None })
    }

    /// Names tests after their operands.
    pub fn name_tests(&mut self) {
        for index in 0..self.nodes.len() {
            if let Op::Test(test, operand) = self.nodes[index].op
                && let (None, Some(operand)) = (&self.nodes[index].name, &self.node(operand).name)
            {
                let what = match test {
                    Test::SignBit => "sign",
                    Test::Zero => "is_zero",
                    Test::Nan => "is_nan",
                    Test::AtLeastZero => "at_least_zero",
                    Test::AboveZero => "above_zero",
                    Test::AtMostZero => "at_most_zero",
                    Test::BelowZero => "below_zero",
                };
                self.nodes[index].name = Some(format!("{operand}_{what}"));
            }
        }
    }

    /// Names the next values of states, because assertions refer to them, or to the reset and the value without it.
    pub fn name_states(&mut self) {
        for number in 0..self.states.len() {
            let next = self.states[number].next;
            let is_named = |id: NodeId| self.node(id).name.is_some();
            let is_zero = |id: NodeId| matches!(self.node(id).op, Op::Number(0) | Op::Bit(false) | Op::Word(0));
            let is_known = match self.node(next).op {
                Op::Select(reset, zero, otherwise) if is_zero(zero) => is_named(reset) && is_named(otherwise),
                _ => false,
            };
            if !is_known && !is_named(next) {
                self.nodes[next.index()].name = Some(format!("{}_next", self.states[number].name));
            }
        }
    }

    /// Checks that stages are in range, operands come first, and state is read in the stage that writes it.
    pub fn check(&self) -> Result<(), Error> {
        for id in self.ids() {
            // A sum begins before the stage in which it is available.
            let stage = match &self.node(id).op {
                Op::Sum(terms) => (self.node(id).position.0 + 1).saturating_sub(sum_steps(terms.len() as u32)),
                _ => self.node(id).position.0,
            };
            let inside = !matches!(self.node(id).op, Op::Input(_));
            if inside && !self.is_everywhere(id) && !(1..=LAST_STAGE).contains(&stage) {
                let value = self.name_of(id);
                return Err(Error::NoSuchStage { operation: self.name, value, stage, last: LAST_STAGE });
            }
            for operand in self.operands(id) {
                let made = self.node(operand).position.0;
                if !self.is_everywhere(operand) && made > stage {
                    let (reader, value) = (self.name_of(id), self.name_of(operand));
                    return Err(Error::UsedBeforeMade { operation: self.name, reader, stage, value, made });
                }
                if let Op::State(state) = self.node(operand).op {
                    let made = self.states[state].written.0;
                    if made != stage {
                        let state = self.states[state].name.clone();
                        return Err(Error::StateApart { operation: self.name, state, read: stage, made });
                    }
                }
            }
        }
        Ok(())
    }
}

impl<P: Position> OperationGraph<P> {
    /// All values.
    pub fn ids(&self) -> impl Iterator<Item = NodeId> + use<P> {
        (0..self.nodes.len() as u32).map(NodeId)
    }

    /// A value.
    pub fn node(&self, id: NodeId) -> &Node<P> {
        &self.nodes[id.index()]
    }

    /// The name of a value in messages and in the netlist.
    pub fn name_of(&self, id: NodeId) -> String {
        let node = self.node(id);
        node.name.clone().unwrap_or_else(|| {
            let text = format!("{:?}", node.op);
            let operator = text.split(['(', ' ']).next().unwrap_or_default().to_lowercase();
            format!("{operator}_{}", id.0)
        })
    }

    /// The error that a value is not available at the position that reads it.
    pub fn unplaced(&self, id: NodeId) -> Error {
        Error::Unplaced { operation: self.name, value: self.name_of(id) }
    }

    /// The values that a value is computed from.
    pub fn operands(&self, id: NodeId) -> Vec<NodeId> {
        match self.node(id).op {
            Op::Input(_) | Op::State(_) | Op::Number(_) | Op::Ulps(_) | Op::Bit(_) | Op::Word(_) => vec![],
            Op::Sum(ref terms) => terms.clone(),
            Op::Continue(a)
            | Op::Negate(a)
            | Op::Narrow(a, _)
            | Op::NumberOf(a)
            | Op::Test(_, a)
            | Op::Relation(a, _)
            | Op::Flags(a)
            | Op::Not(a) => {
                vec![a]
            }
            Op::Add(a, b)
            | Op::Subtract(a, b)
            | Op::Multiply(a, b)
            | Op::Compare(a, b)
            | Op::And(a, b)
            | Op::Or(a, b)
            | Op::WordEqual(a, b)
            | Op::WordLess(a, b)
            | Op::WordOr(a, b) => vec![a, b],
            Op::Select(condition, a, b) => vec![condition, a, b],
            Op::Residue(product, a, b) => vec![product, a, b],
        }
    }

    /// For each value, whether an output or a state depends on it.
    pub fn live(&self) -> Vec<bool> {
        let mut live = vec![false; self.nodes.len()];
        let outputs = self.outputs.iter().map(|output| output.node);
        let nexts = self.states.iter().map(|state| state.next);
        let counted = self.ids().filter(|&id| self.counts_exceptions && self.node(id).op.rounds());
        let mut open: Vec<NodeId> = outputs.chain(nexts).chain(counted).collect();
        while let Some(id) = open.pop() {
            if !live[id.index()] {
                live[id.index()] = true;
                open.extend(self.operands(id));
            }
        }
        live
    }

    /// Whether something reads what rounding takes from a product.
    pub fn reads_residue(&self, product: NodeId) -> bool {
        self.nodes.iter().any(|node| matches!(node.op, Op::Residue(of, ..) if of == product))
    }

    /// Whether a value is available at every position.
    pub fn is_everywhere(&self, id: NodeId) -> bool {
        matches!(self.node(id).op, Op::State(_) | Op::Number(_) | Op::Ulps(_) | Op::Bit(_) | Op::Word(_))
    }

    /// Whether a value may be computed at any position that has its operand. These are the tests, except those of
    /// state, which is available at one position only.
    pub fn is_movable(&self, id: NodeId) -> bool {
        matches!(self.node(id).op, Op::Test(_, operand) if !matches!(self.node(operand).op, Op::State(_)))
    }

    /// Whether a value is computed at a position. The others are inputs, constants and state.
    pub fn is_computed(&self, id: NodeId) -> bool {
        !matches!(self.node(id).op, Op::Input(_)) && !self.is_everywhere(id)
    }

    /// The kind of unit that computes a value, and which of its parts; `None` if no unit does.
    pub fn unit_part(&self, id: NodeId) -> Option<(UnitKind, u32)> {
        match self.node(id).op {
            Op::Add(..) | Op::Subtract(..) => Some((UnitKind::Add, 0)),
            Op::Sum(_) => Some((UnitKind::Sum, 0)),
            Op::Multiply(..) => Some((UnitKind::Multiply, 0)),
            Op::Compare(..) => Some((UnitKind::Compare, 0)),
            Op::Continue(before) => match self.node(before).kind {
                Kind::Cut(kind, part) => Some((kind, part + 1)),
                _ => None,
            },
            _ => None,
        }
    }
}

impl OperationGraph<Step> {
    /// Whether it writes state later than it reads it, so that its jobs must not follow each other directly.
    pub fn is_loop(&self) -> bool {
        self.spacing() > 0
    }

    /// The least number of cycles between two of its jobs in which no other of its jobs may enter.
    pub fn spacing(&self) -> u32 {
        self.last_write().0.saturating_sub(self.first_read().0)
    }

    /// The first step that reads state; the input's registers if there is no state.
    pub fn first_read(&self) -> Step {
        self.states.iter().map(|state| state.read).min().unwrap_or(Step::INPUT)
    }

    /// The last step that writes state; the input's registers if there is no state.
    pub fn last_write(&self) -> Step {
        self.states.iter().map(|state| state.written).max().unwrap_or(Step::INPUT)
    }
}
