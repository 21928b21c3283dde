//! What an operation does, recorded: one node a value, each with the stage that makes it.

use crate::STAGES;
use crate::error::Error;
use crate::schedule;
use crate::tracer::{self, Marks};
use crate::units::UnitKind;
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
    /// Floats: it costs next to nothing, so it is made where it saves registers, not where it was written.
    Test(Test, NodeId),
    Relation(NodeId, Relation),
    And(NodeId, NodeId),
    Or(NodeId, NodeId),
    Not(NodeId),
    WordEqual(NodeId, NodeId),
    WordLess(NodeId, NodeId),
    Select(NodeId, NodeId, NodeId),
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
}

impl Traced {
    /// Runs `operation` over a recording circuit and checks the record.
    pub fn new<O: Operation>(operation: &O, opcode: u64, marks: Marks) -> Result<Self, Error> {
        let mut traced = tracer::record(operation, opcode, marks);
        if traced.is_auto {
            schedule::check(&traced)?;
        } else {
            traced.check()?;
        }
        traced.name_tests();
        Ok(traced)
    }

    /// Adds a word that each job brings at the port `tag` and takes along.
    pub fn add_tag(&mut self, width: u32) -> Result<(), Error> {
        let port = PortBit { port: "tag".to_string(), bit: None };
        let is_input = |&id: &NodeId| matches!(&self.node(id).op, Op::Input(taken) if taken.port == port.port);
        if self.inputs.iter().any(is_input) || self.outputs.iter().any(|output| output.port.port == port.port) {
            let problem = format!("operation {} has a port of that name already", self.name);
            return Err(Error::Feature { feature: "tag", problem });
        }
        let node = NodeId(self.nodes.len() as u32);
        let (op, name) = (Op::Input(port.clone()), Some(port.port.clone()));
        self.nodes.push(Node { op, kind: Kind::Word(width), stage: 0, name });
        self.inputs.push(node);
        self.outputs.push(OutputValue { port, node });
        Ok(())
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
                };
                self.nodes[index].name = Some(format!("{operand}_{what}"));
            }
        }
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
            Op::Continue(a) | Op::Negate(a) | Op::Test(_, a) | Op::Relation(a, _) | Op::Not(a) => vec![a],
            Op::Add(a, b)
            | Op::Subtract(a, b)
            | Op::Multiply(a, b)
            | Op::Compare(a, b)
            | Op::And(a, b)
            | Op::Or(a, b)
            | Op::WordEqual(a, b)
            | Op::WordLess(a, b) => vec![a, b],
            Op::Select(condition, a, b) => vec![condition, a, b],
        }
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

    /// Whether it may be made in any stage that has its operand. State is at hand in one stage only; a test of a constant
    /// is a constant and never gets here.
    pub fn floats(&self, id: NodeId) -> bool {
        matches!(self.node(id).op, Op::Test(_, operand) if !matches!(self.node(operand).op, Op::State(_)))
    }

    /// Stages in range, nothing read before it is made, state read where it is written.
    pub fn check(&self) -> Result<(), Error> {
        for index in 0..self.nodes.len() {
            let id = NodeId(index as u32);
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
