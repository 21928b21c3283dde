//! An operation's dataflow as a graph of values, recorded by running the operation over a circuit of nodes.

use raypath_ops::{
    Binary32, Bit, Bundle, Circuit, Field, Narrowing, Num, Operation, Path, Port, Relation, Sink, Source, Test,
    ports_of,
};
use std::cell::RefCell;
use std::fmt::{self, Arguments};

/// The position of a node.
pub type Id = usize;

/// A graph of values. Operands come before their readers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Graph {
    pub nodes: Vec<Node>,
    /// The ports in, also those that the operation lacks.
    pub inputs: Vec<Port>,
    /// The ports out, also those that the operation lacks.
    pub ports_out: Vec<Port>,
    /// The values at the ports out. Those that the operation lacks are left out.
    pub outputs: Vec<Leaf>,
    /// For each value of the state, the node that reads it and the one that computes the next.
    pub states: Vec<(Id, Id)>,
    pub marks: Vec<Mark>,
}

/// A value at a port.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Leaf {
    /// The position of the port.
    pub port: usize,
    /// The bit of a port of several truth values.
    pub bit: u32,
    pub node: Id,
}

/// The beginning of a stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mark {
    /// The nodes before it.
    pub nodes: usize,
    pub stage: u32,
    /// The stage in the shorter pipeline.
    pub short: u32,
    pub what: &'static str,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    pub op: Op,
    pub operands: Vec<Id>,
    /// The complement of a truth value. Operations do not have it, but faults.
    pub inverted: bool,
    /// The name that the operation gives the value, if any.
    pub name: String,
}

/// An operator of [`Circuit`], or a source of values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Op {
    /// The value at a port in: its position, and the bit if the port has several truth values.
    Input(usize, u32, Kind),
    /// A value of the state.
    State(Kind),
    Constant(f32),
    OnePlusUlps(u32),
    Add,
    Sum,
    Subtract,
    Multiply,
    Negate,
    Narrow(Narrowing),
    Compare,
    Relation(Relation),
    NumberOf(u32),
    Test(Test),
    Bit(bool),
    And,
    Or,
    Not,
    /// A constant word: width and value.
    Word(u32, u32),
    WordEqual,
    WordLess,
    /// Condition, value if true, value if false.
    Select(Kind),
    /// The operand. Operations do not have it, but faults.
    Same(Kind),
}

/// The type of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Number,
    Bit,
    /// With its width.
    Word(u32),
    Order,
}

impl Op {
    pub fn kind(self) -> Kind {
        match self {
            Self::Input(_, _, kind) | Self::State(kind) | Self::Select(kind) | Self::Same(kind) => kind,
            Self::Compare => Kind::Order,
            Self::Word(width, _) => Kind::Word(width),
            Self::Relation(_)
            | Self::Test(_)
            | Self::Bit(_)
            | Self::And
            | Self::Or
            | Self::Not
            | Self::WordEqual
            | Self::WordLess => Kind::Bit,
            Self::Constant(_)
            | Self::OnePlusUlps(_)
            | Self::Add
            | Self::Sum
            | Self::Subtract
            | Self::Multiply
            | Self::Negate
            | Self::Narrow(_)
            | Self::NumberOf(_) => Kind::Number,
        }
    }

    pub fn is_constant(self) -> bool {
        matches!(self, Self::Constant(_) | Self::OnePlusUlps(_) | Self::Bit(_) | Self::Word(..))
    }
}

impl Graph {
    /// The dataflow of an operation.
    pub fn of<O: Operation>(operation: &O) -> Self {
        let made = RefCell::new(Self {
            inputs: ports_of::<O::Input<Binary32>>(),
            ports_out: ports_of::<O::Output<Binary32>>(),
            ..Self::default()
        });
        let c = Recorder { made: &made };
        let input = O::Input::build(&mut Path::default(), &mut Reads { c, is_state: false });
        let first = made.borrow().nodes.len();
        let state = O::State::build(&mut Path::default(), &mut Reads { c, is_state: true });
        let before: Vec<Id> = (first..made.borrow().nodes.len()).collect();
        let (output, next) = operation.run(c, input, state);

        let mut outputs = Vec::new();
        let mut write = |name: &str, bit: u32, node: Id| {
            let port = made.borrow().ports_out.iter().position(|port| port.name == name);
            outputs.extend(port.filter(|_| operation.has_output(name)).map(|port| Leaf { port, bit, node }));
        };
        output.each(&mut Path::default(), &mut Writes(&mut write));
        let mut after = Vec::new();
        next.each(&mut Path::default(), &mut Writes(&mut |_, _, node| after.push(node)));
        let mut graph = made.into_inner();
        graph.outputs = outputs;
        graph.states = before.into_iter().zip(after).collect();
        graph
    }

    /// Whether each node has an effect on an output or a state.
    pub fn live(&self) -> Vec<bool> {
        let mut live = vec![false; self.nodes.len()];
        let ends = self.outputs.iter().map(|leaf| leaf.node).chain(self.states.iter().map(|&(_, next)| next));
        ends.for_each(|id| live[id] = true);
        for id in (0..self.nodes.len()).rev() {
            if live[id] {
                self.nodes[id].operands.iter().for_each(|&operand| live[operand] = true);
            }
        }
        live
    }

    /// The value in words: its name, or its operator and the first named value that reads it.
    pub fn describe(&self, id: Id) -> String {
        let node = &self.nodes[id];
        let op = format!("{:?}", node.op);
        match &node.op {
            Op::Input(port, bit, _) if *bit > 0 => format!("{} bit {bit}", self.inputs[*port].name),
            Op::Input(port, ..) => self.inputs[*port].name.clone(),
            _ if !node.name.is_empty() => format!("{} ({op})", node.name),
            _ => {
                let mut reader = id;
                for (other, node) in self.nodes.iter().enumerate().skip(id + 1) {
                    if node.operands.contains(&reader) {
                        reader = other;
                        if !node.name.is_empty() {
                            return format!("{op}, node {id}, before {}", node.name);
                        }
                    }
                }
                format!("{op}, node {id}")
            }
        }
    }
}

/// The circuit. Its values are the positions of nodes.
#[derive(Clone, Copy)]
struct Recorder<'g> {
    made: &'g RefCell<Graph>,
}

impl Recorder<'_> {
    fn node(self, op: Op, operands: &[Id]) -> Id {
        let nodes = &mut self.made.borrow_mut().nodes;
        nodes.push(Node { op, operands: operands.to_vec(), inverted: false, name: String::new() });
        nodes.len() - 1
    }

    fn select(self, condition: Id, if_true: Id, if_false: Id) -> Id {
        let kind = self.made.borrow().nodes[if_true].op.kind();
        self.node(Op::Select(kind), &[condition, if_true, if_false])
    }
}

impl Circuit for Recorder<'_> {
    type Num = Id;
    type Bit = Id;
    type Word = Id;
    type Order = Id;

    fn stage_or(self, stage: u32, short: u32, what: &'static str) {
        let mut made = self.made.borrow_mut();
        let nodes = made.nodes.len();
        made.marks.push(Mark { nodes, stage, short, what });
    }
    fn stage(self, number: u32, what: &'static str) {
        self.stage_or(number, number, what);
    }
    fn label<B: Bundle<Self>>(self, name: Arguments<'_>, value: &B) {
        value.each(
            &mut Path::new(&name.to_string()),
            &mut Writes(&mut |name, _, node| {
                let named = &mut self.made.borrow_mut().nodes[node].name;
                if named.is_empty() {
                    *named = name.to_string();
                }
            }),
        );
    }
    fn constant(self, value: f32) -> Id {
        self.node(Op::Constant(value), &[])
    }
    fn one_plus_ulps(self, ulps: u32) -> Id {
        self.node(Op::OnePlusUlps(ulps), &[])
    }
    fn add(self, a: Id, b: Id) -> Id {
        self.node(Op::Add, &[a, b])
    }
    fn sum(self, terms: &[Id]) -> Id {
        self.node(Op::Sum, terms)
    }
    fn subtract(self, a: Id, b: Id) -> Id {
        self.node(Op::Subtract, &[a, b])
    }
    fn multiply(self, a: Id, b: Id) -> Id {
        self.node(Op::Multiply, &[a, b])
    }
    fn negate(self, a: Id) -> Id {
        self.node(Op::Negate, &[a])
    }
    fn narrow(self, a: Id, to: Narrowing) -> Id {
        self.node(Op::Narrow(to), &[a])
    }
    fn compare(self, a: Id, b: Id) -> Id {
        self.node(Op::Compare, &[a, b])
    }
    fn relation(self, order: Id, relation: Relation) -> Id {
        self.node(Op::Relation(relation), &[order])
    }
    fn number_of(self, width: u32, word: Id) -> Id {
        self.node(Op::NumberOf(width), &[word])
    }
    fn test(self, test: Test, a: Id) -> Id {
        self.node(Op::Test(test), &[a])
    }
    fn constant_bit(self, value: bool) -> Id {
        self.node(Op::Bit(value), &[])
    }
    fn and(self, a: Id, b: Id) -> Id {
        self.node(Op::And, &[a, b])
    }
    fn or(self, a: Id, b: Id) -> Id {
        self.node(Op::Or, &[a, b])
    }
    fn not(self, a: Id) -> Id {
        self.node(Op::Not, &[a])
    }
    fn constant_word(self, width: u32, value: u32) -> Id {
        self.node(Op::Word(width, value), &[])
    }
    fn word_equal(self, a: Id, b: Id) -> Id {
        self.node(Op::WordEqual, &[a, b])
    }
    fn word_less(self, a: Id, b: Id) -> Id {
        self.node(Op::WordLess, &[a, b])
    }
    fn select_num(self, condition: Id, if_true: Id, if_false: Id) -> Id {
        self.select(condition, if_true, if_false)
    }
    fn select_bit(self, condition: Id, if_true: Id, if_false: Id) -> Id {
        self.select(condition, if_true, if_false)
    }
    fn select_word(self, condition: Id, if_true: Id, if_false: Id) -> Id {
        self.select(condition, if_true, if_false)
    }
}

impl PartialEq for Recorder<'_> {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.made, other.made)
    }
}

impl fmt::Debug for Recorder<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Recorder")
    }
}

/// A source of nodes that read inputs or states.
struct Reads<'g> {
    c: Recorder<'g>,
    is_state: bool,
}

impl Reads<'_> {
    fn read(&self, field: &Field<'_>, kind: Kind) -> Id {
        let bit = field.bit.map_or(0, |(bit, _)| bit);
        let port = self.c.made.borrow().inputs.iter().position(|port| port.name == field.name).unwrap_or_default();
        let op = if self.is_state { Op::State(kind) } else { Op::Input(port, bit, kind) };
        let id = self.c.node(op, &[]);
        self.c.made.borrow_mut().nodes[id].name = field.name.to_string();
        id
    }
}

impl<'g> Source<Recorder<'g>> for Reads<'g> {
    fn num(&mut self, field: Field<'_>) -> Num<Recorder<'g>> {
        Num::new(self.c, self.read(&field, Kind::Number))
    }
    fn bit(&mut self, field: Field<'_>) -> Bit<Recorder<'g>> {
        Bit::new(self.c, self.read(&field, Kind::Bit))
    }
    fn word(&mut self, field: Field<'_>, width: u32) -> (Recorder<'g>, Id) {
        (self.c, self.read(&field, Kind::Word(width)))
    }
}

/// A sink that gets the name of a port, the bit, and the node.
struct Writes<'a>(&'a mut dyn FnMut(&str, u32, Id));

impl Writes<'_> {
    fn write(&mut self, field: &Field<'_>, node: Id) {
        (self.0)(field.name, field.bit.map_or(0, |(bit, _)| bit), node);
    }
}

impl<'g> Sink<Recorder<'g>> for Writes<'_> {
    fn num(&mut self, field: Field<'_>, value: Num<Recorder<'g>>) {
        self.write(&field, value.value);
    }
    fn bit(&mut self, field: Field<'_>, value: Bit<Recorder<'g>>) {
        self.write(&field, value.value);
    }
    fn word(&mut self, field: Field<'_>, _width: u32, value: Id) {
        self.write(&field, value);
    }
}
