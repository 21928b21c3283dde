//! What an operation does, recorded: one node a value, each with the stage that makes it.

use crate::STAGES;
use crate::error::Error;
use crate::schedule;
use crate::tracer::{self, Marks};
use crate::units::UnitKind;
use raypath_float::flags;
use raypath_ops::{Operation, Relation, Test};
use std::borrow::Cow;

/// A value, by position in its operation's [`Traced::nodes`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub u32);

impl NodeId {
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// How a value is made.
#[derive(Debug, Clone, PartialEq)]
pub enum Op {
    /// An input port, or one bit of it.
    Input(PortBit),
    /// The operation's state of this number.
    State(usize),
    /// A constant, as the bits of a binary32 number.
    Number(u32),
    /// The constant that lies so many places above 1 in the datapath's format.
    OnePlusUlps(u32),
    /// A constant truth value.
    Bit(bool),
    /// A constant word.
    Word(u32),
    /// The next part of a unit that takes several steps.
    Continue(NodeId),
    Add(NodeId, NodeId),
    Subtract(NodeId, NodeId),
    Multiply(NodeId, NodeId),
    Compare(NodeId, NodeId),
    Negate(NodeId),
    /// A word as a number.
    NumberOf(NodeId),
    /// Floats: it costs next to nothing, so it is made where it saves registers, not where it was written.
    Test(Test, NodeId),
    Relation(NodeId, Relation),
    /// The exceptions that a unit raises for a sum or a product.
    Flags(NodeId),
    And(NodeId, NodeId),
    Or(NodeId, NodeId),
    Not(NodeId),
    WordEqual(NodeId, NodeId),
    WordLess(NodeId, NodeId),
    /// Bit by bit.
    WordOr(NodeId, NodeId),
    Select(NodeId, NodeId, NodeId),
}

impl Op {
    /// Whether an adder or a multiplier makes it: then it is rounded, and may raise exceptions.
    pub fn rounds(&self) -> bool {
        matches!(self, Self::Add(..) | Self::Subtract(..) | Self::Multiply(..))
    }
}

/// What a value is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A number; how it stands in a register is the boundary's business.
    Number,
    /// What a unit of several parts hands to its next part, after the part of this number (the first is 0).
    Cut(UnitKind, u32),
    /// A small word of so many bits; a truth value has one.
    Word(u32),
    /// The three answers of a comparator.
    Order,
}

#[derive(Debug, Clone)]
pub struct Node {
    pub op: Op,
    pub kind: Kind,
    /// The stage that makes it, and once they are known the step; 0 for inputs. Constants and state are everywhere.
    pub stage: u32,
    /// What the algorithm calls it.
    pub name: Option<String>,
}

/// An input or output port without its direction suffix, or one bit of it.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PortBit {
    pub port: String,
    /// Bit and width of the port, where the value is one bit of several.
    pub bit: Option<(u32, u32)>,
}

/// One output of an operation.
#[derive(Debug, Clone)]
pub struct OutputValue {
    pub port: PortBit,
    pub node: NodeId,
}

/// A register of an operation that outlives a job.
#[derive(Debug, Clone)]
pub struct StateValue {
    pub name: String,
    /// What it holds for the next job.
    pub next: NodeId,
    /// The stage, and once they are known the step, in which it is written.
    pub written: u32,
    /// The first one in which it is read.
    pub read: u32,
}

/// An operation's record.
#[derive(Debug, Clone)]
pub struct Traced {
    pub name: &'static str,
    pub opcode: u64,
    pub nodes: Vec<Node>,
    pub inputs: Vec<NodeId>,
    pub outputs: Vec<OutputValue>,
    pub states: Vec<StateValue>,
    /// What its stages say they do.
    pub notes: Vec<(u32, Cow<'static, str>)>,
    /// The stages are for the scheduler to find; until then they say nothing.
    pub is_auto: bool,
    /// Every sum and product counts, read or not: what they raise is an output.
    pub counts_exceptions: bool,
}

impl Traced {
    /// Runs `operation` over a recording circuit and checks the record.
    pub fn new<O: Operation>(operation: &O, opcode: u64, marks: Marks) -> Result<Self, Error> {
        tracer::record(operation, opcode, marks).checked()
    }

    fn checked(mut self) -> Result<Self, Error> {
        if self.is_auto {
            schedule::check(&self)?;
        } else {
            self.check()?;
        }
        self.name_tests();
        self.name_states();
        Ok(self)
    }

    /// Adds a word that each job brings at the port `tag` and takes along.
    pub fn add_tag(&mut self, width: u32) -> Result<(), Error> {
        let port = self.new_port("tag")?;
        let node = self.push(Op::Input(port.clone()), Kind::Word(width), 0, Some(port.port.clone()));
        self.inputs.push(node);
        self.outputs.push(OutputValue { port, node });
        Ok(())
    }

    /// Has every sum and product made, so that their exceptions can be an output.
    pub fn count_exceptions(&mut self) -> Result<(), Error> {
        self.counts_exceptions = true;
        if self.is_auto { schedule::check(self) } else { Ok(()) }
    }

    /// Leaves a constant where a value is not made, so that none takes a unit, a step or a state's time. Values keep
    /// their numbers: names of others have them.
    pub fn forget_unread(&mut self) {
        let live = self.live();
        for (node, is_live) in self.nodes.iter_mut().zip(live) {
            if !is_live && !matches!(node.op, Op::Input(_)) {
                *node = Node { op: Op::Bit(false), kind: Kind::Word(1), stage: 0, name: None };
            }
        }
    }

    /// Adds an output `exception_flags`: what any sum or product raises. The stages must be known: each adds what its
    /// units raise, so that one word crosses the registers.
    pub fn add_exception_flags(&mut self) -> Result<(), Error> {
        let port = self.new_port("exception_flags")?;
        let kind = Kind::Word(flags::COUNT);
        let mut so_far: Option<NodeId> = None;
        for stage in 1..STAGES {
            let here = self.ids().filter(|&id| self.node(id).stage == stage);
            let units: Vec<NodeId> = here.filter(|&id| self.node(id).op.rounds()).collect();
            let mut raised: Vec<NodeId> =
                units.into_iter().map(|id| self.push(Op::Flags(id), kind, stage, None)).collect();
            if raised.is_empty() {
                continue;
            }
            raised.extend(so_far);
            // By pairs, so that few gates are in a row.
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
        let node = so_far.unwrap_or_else(|| self.push(Op::Word(0), kind, 1, None));
        self.outputs.push(OutputValue { port, node });
        Ok(())
    }

    fn push(&mut self, op: Op, kind: Kind, stage: u32, name: Option<String>) -> NodeId {
        self.nodes.push(Node { op, kind, stage, name });
        NodeId(self.nodes.len() as u32 - 1)
    }

    /// A port for a feature of that name, which the operation must not have itself.
    fn new_port(&self, feature: &'static str) -> Result<PortBit, Error> {
        let is_input = |&id: &NodeId| matches!(&self.node(id).op, Op::Input(taken) if taken.port == feature);
        if self.inputs.iter().any(is_input) || self.outputs.iter().any(|output| output.port.port == feature) {
            let problem = format!("operation {} has a port of that name already", self.name);
            return Err(Error::Feature { feature, problem });
        }
        Ok(PortBit { port: feature.to_string(), bit: None })
    }

    /// A test is called after what it tests.
    fn name_tests(&mut self) {
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

    /// Assertions speak of a state's next value, or of what resets it to zero and what it is otherwise: these need
    /// names.
    fn name_states(&mut self) {
        for number in 0..self.states.len() {
            let next = self.states[number].next;
            let is_named = |id: NodeId| self.node(id).name.is_some();
            let is_zero = |id: NodeId| matches!(self.node(id).op, Op::Number(0) | Op::Bit(false) | Op::Word(0));
            let is_told = match self.node(next).op {
                Op::Select(reset, zero, otherwise) if is_zero(zero) => is_named(reset) && is_named(otherwise),
                _ => false,
            };
            if !is_told && !is_named(next) {
                self.nodes[next.index()].name = Some(format!("{}_next", self.states[number].name));
            }
        }
    }

    /// Every value.
    pub fn ids(&self) -> impl Iterator<Item = NodeId> + use<> {
        (0..self.nodes.len() as u32).map(NodeId)
    }

    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.index()]
    }

    /// What to call a value in messages and in the netlist.
    pub fn name_of(&self, id: NodeId) -> String {
        let node = self.node(id);
        node.name.clone().unwrap_or_else(|| {
            let text = format!("{:?}", node.op);
            let operator = text.split(['(', ' ']).next().unwrap_or_default().to_lowercase();
            format!("{operator}_{}", id.0)
        })
    }

    /// That no register brings a value to where it is read.
    pub fn unplaced(&self, id: NodeId) -> Error {
        Error::Unplaced { operation: self.name, value: self.name_of(id) }
    }

    /// The values that a value is made of.
    pub fn operands(&self, id: NodeId) -> Vec<NodeId> {
        match self.node(id).op {
            Op::Input(_) | Op::State(_) | Op::Number(_) | Op::OnePlusUlps(_) | Op::Bit(_) | Op::Word(_) => vec![],
            Op::Continue(a)
            | Op::Negate(a)
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
        }
    }

    /// Which values reach an output or state. The others are not made.
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

    /// Whether it writes state later than it reads it, so that a job must not follow the one before at once.
    pub fn is_loop(&self) -> bool {
        self.spacing() > 0
    }

    /// How many cycles lie between two of its jobs at least, in which none enters.
    pub fn spacing(&self) -> u32 {
        let read = self.states.iter().map(|state| state.read).min().unwrap_or(0);
        let written = self.states.iter().map(|state| state.written).max().unwrap_or(0);
        written.saturating_sub(read)
    }

    /// Whether it is made in no particular stage.
    pub fn is_everywhere(&self, id: NodeId) -> bool {
        matches!(self.node(id).op, Op::State(_) | Op::Number(_) | Op::OnePlusUlps(_) | Op::Bit(_) | Op::Word(_))
    }

    /// Whether it may be made in any stage that has its operand. State is at hand in one stage only; a test of a
    /// constant is a constant and never gets here.
    pub fn floats(&self, id: NodeId) -> bool {
        matches!(self.node(id).op, Op::Test(_, operand) if !matches!(self.node(operand).op, Op::State(_)))
    }

    /// Stages in range, nothing read before it is made, state read where it is written.
    pub fn check(&self) -> Result<(), Error> {
        for id in self.ids() {
            let stage = self.node(id).stage;
            let inside = !matches!(self.node(id).op, Op::Input(_));
            if inside && !self.is_everywhere(id) && !(1..STAGES).contains(&stage) {
                let value = self.name_of(id);
                return Err(Error::NoSuchStage { operation: self.name, value, stage, last: STAGES - 1 });
            }
            for operand in self.operands(id) {
                let made = self.node(operand).stage;
                if !self.is_everywhere(operand) && made > stage {
                    let (reader, value) = (self.name_of(id), self.name_of(operand));
                    return Err(Error::UsedBeforeMade { operation: self.name, reader, stage, value, made });
                }
                if let Op::State(state) = self.node(operand).op {
                    let made = self.states[state].written;
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
