//! The recorder: a circuit that adds a node to a graph for every operator.

use crate::ir::graph::{Kind, Node, NodeId, Op, OperationGraph, OutputValue, PortBit, StateValue};
use crate::ir::position::{Position, Stage};
use raypath_ops::{
    Binary32, Bit, Bundle, Circuit, Field, Narrowing, Num, Operation, Path, RESIDUE_BITS, Relation, Single, Sink,
    Source, Test,
};
use std::borrow::Cow;
use std::cell::{Cell, RefCell};
use std::fmt;

/// How the recorder treats the stages that an operation marks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Marks {
    /// They are the stages of its values, unless it selects automatic staging.
    #[default]
    Used,
    /// They are the stages of its values; [`Circuit::stage_or`] marks the stages of the shorter pipeline.
    Short,
    /// They are ignored, and the operation is staged automatically.
    Ignored,
}

/// Runs `operation` once and returns its graph, unchecked.
pub fn record<O: Operation>(operation: &O, opcode: u64, marks: Marks) -> OperationGraph<Stage> {
    let recording = Recording { marks, auto: Cell::new(marks == Marks::Ignored), ..Recording::default() };
    let c = RecordingCircuit { recording: &recording };
    let mut inputs = Vec::new();
    let mut add_input = |kind, field: Field<'_>| {
        let id = c.add_input(kind, &field);
        if operation.has_input(field.name) {
            inputs.push(id);
        }
        id
    };
    let input = O::Input::build(&mut Path::default(), &mut ValueSource { c, add: &mut add_input });
    let mut names = Vec::new();
    let mut add_state = |kind, field: Field<'_>| {
        names.push(field.name.to_string());
        let id = c.push_at(Position::INPUT, kind, Op::State(names.len() - 1));
        c.name(id, field.name);
        id
    };
    let state = O::State::build(&mut Path::default(), &mut ValueSource { c, add: &mut add_state });

    let (output, next) = operation.run(c, input, state);

    let mut outputs = Vec::new();
    let mut add_output = |field: Field<'_>, node| {
        if operation.has_output(field.name) {
            outputs.push(OutputValue { port: port_bit(&field), node });
        }
    };
    output.each(&mut Path::default(), &mut NodeSink(&mut add_output));
    let mut next_nodes = Vec::new();
    next.each(&mut Path::default(), &mut NodeSink(&mut |_, node| next_nodes.push(node)));

    let states = names.into_iter().zip(next_nodes).collect();
    recording.finish(O::NAME, opcode, inputs, outputs, states)
}

/// The state of a recording.
#[derive(Default)]
struct Recording {
    nodes: RefCell<Vec<Node<Stage>>>,
    notes: RefCell<Vec<(u32, Cow<'static, str>)>>,
    stage: Cell<u32>,
    marks: Marks,
    auto: Cell<bool>,
}

impl Recording {
    fn finish(
        &self,
        name: &'static str,
        opcode: u64,
        inputs: Vec<NodeId>,
        outputs: Vec<OutputValue>,
        states: Vec<(String, NodeId)>,
    ) -> OperationGraph<Stage> {
        let nodes = self.nodes.take();
        let state = |(name, next): (String, NodeId)| {
            let position = nodes[next.index()].position;
            StateValue { name, next, written: position, read: position }
        };
        let states = states.into_iter().map(state).collect();
        let (notes, is_auto) = (self.notes.take(), self.auto.get());
        OperationGraph { name, opcode, inputs, outputs, states, notes, is_auto, counts_exceptions: false, nodes }
    }
}

/// The recording circuit.
#[derive(Clone, Copy)]
struct RecordingCircuit<'g> {
    recording: &'g Recording,
}

impl RecordingCircuit<'_> {
    fn push(self, kind: Kind, op: Op) -> NodeId {
        self.push_at(Stage(self.recording.stage.get()), kind, op)
    }

    fn push_at(self, stage: Stage, kind: Kind, op: Op) -> NodeId {
        let mut nodes = self.recording.nodes.borrow_mut();
        nodes.push(Node { op, kind, position: stage, name: None });
        NodeId(nodes.len() as u32 - 1)
    }

    /// A node for a field of the input, named like its port.
    fn add_input(self, kind: Kind, field: &Field<'_>) -> NodeId {
        let id = self.push_at(Position::INPUT, kind, Op::Input(port_bit(field)));
        self.recording.nodes.borrow_mut()[id.index()].name = Some(name_of(field));
        id
    }

    /// The node of a value that needs no unit. Equal values share one node.
    fn once(self, kind: Kind, op: Op) -> NodeId {
        let found = self.recording.nodes.borrow().iter().position(|node| node.op == op && node.kind == kind);
        found.map_or_else(|| self.push(kind, op), |index| NodeId(index as u32))
    }

    /// The value of a bit that is constant, such as the order of two boxes' indices before they are sorted.
    fn known_bit(self, id: NodeId) -> Option<bool> {
        match self.recording.nodes.borrow()[id.index()].op {
            Op::Bit(value) => Some(value),
            _ => None,
        }
    }

    fn known_word(self, id: NodeId) -> Option<u32> {
        match self.recording.nodes.borrow()[id.index()].op {
            Op::Word(value) => Some(value),
            _ => None,
        }
    }

    fn name(self, id: NodeId, name: &str) {
        let mut nodes = self.recording.nodes.borrow_mut();
        let node = &mut nodes[id.index()];
        if !matches!(node.op, Op::Input(_) | Op::Number(_) | Op::Ulps(_) | Op::Bit(_) | Op::Word(_)) {
            node.name = Some(name.to_string());
        }
    }
}

const BIT: Kind = Kind::Word(1);

impl Circuit for RecordingCircuit<'_> {
    type Num = NodeId;
    type Bit = NodeId;
    type Word = NodeId;
    type Order = NodeId;

    fn stage(self, number: u32, what: &'static str) {
        if self.recording.marks == Marks::Ignored {
            return;
        }
        self.recording.stage.set(number);
        let mut notes = self.recording.notes.borrow_mut();
        let note = (number, Cow::Borrowed(what));
        if !notes.contains(&note) {
            notes.push(note);
        }
    }

    fn stage_or(self, number: u32, short: u32, what: &'static str) {
        self.stage(if self.recording.marks == Marks::Short { short } else { number }, what);
    }

    fn auto(self) {
        self.recording.auto.set(true);
    }

    fn label<B: Bundle<Self>>(self, name: fmt::Arguments<'_>, value: &B) {
        let mut label = |field: Field<'_>, node| self.name(node, &name_of(&field));
        value.each(&mut Path::new(&name.to_string()), &mut NodeSink(&mut label));
    }

    fn constant(self, value: f32) -> NodeId {
        self.once(Kind::Number, Op::Number(value.to_bits()))
    }
    fn ulps(self, ulps: u32) -> NodeId {
        self.once(Kind::Number, Op::Ulps(ulps))
    }
    fn add(self, a: NodeId, b: NodeId) -> NodeId {
        self.push(Kind::Number, Op::Add(a, b))
    }
    fn sum(self, terms: &[NodeId]) -> NodeId {
        self.push(Kind::Number, Op::Sum(terms.to_vec()))
    }
    fn subtract(self, a: NodeId, b: NodeId) -> NodeId {
        self.push(Kind::Number, Op::Subtract(a, b))
    }
    fn multiply(self, a: NodeId, b: NodeId) -> NodeId {
        self.push(Kind::Number, Op::Multiply(a, b))
    }
    fn residue(self, product: NodeId, a: NodeId, b: NodeId) -> NodeId {
        let stage = self.recording.nodes.borrow()[product.index()].position;
        self.push_at(stage, Kind::Word(RESIDUE_BITS), Op::Residue(product, a, b))
    }
    fn negate(self, a: NodeId) -> NodeId {
        self.push(Kind::Number, Op::Negate(a))
    }
    fn narrow(self, a: NodeId, to: Narrowing) -> NodeId {
        self.push(Kind::Number, Op::Narrow(a, to))
    }
    fn compare(self, a: NodeId, b: NodeId) -> NodeId {
        self.push(Kind::Order, Op::Compare(a, b))
    }
    fn relation(self, order: NodeId, relation: Relation) -> NodeId {
        // Computed with the comparison, so that one bit crosses the registers and not the comparator's three.
        let stage = self.recording.nodes.borrow()[order.index()].position;
        self.push_at(stage, BIT, Op::Relation(order, relation))
    }
    fn number_of(self, _width: u32, word: NodeId) -> NodeId {
        match self.known_word(word) {
            Some(value) => self.constant(value as f32),
            None => self.push(Kind::Number, Op::NumberOf(word)),
        }
    }
    fn test(self, test: Test, a: NodeId) -> NodeId {
        let op = self.recording.nodes.borrow()[a.index()].op.clone();
        match (op, test) {
            (Op::Number(bits), _) => self.constant_bit(Binary32.test(test, Single(f32::from_bits(bits)))),
            // A test of a negated number is a test of the number itself, so that no negation is needed.
            (Op::Negate(a), Test::SignBit) => self.not(self.test(Test::SignBit, a)),
            (Op::Negate(a), Test::Zero | Test::Nan) => self.test(test, a),
            (Op::Negate(a), Test::AtLeastZero) => self.test(Test::AtMostZero, a),
            (Op::Negate(a), Test::AboveZero) => self.test(Test::BelowZero, a),
            (Op::Negate(a), Test::AtMostZero) => self.test(Test::AtLeastZero, a),
            (Op::Negate(a), Test::BelowZero) => self.test(Test::AboveZero, a),
            _ => self.once(BIT, Op::Test(test, a)),
        }
    }
    fn constant_bit(self, value: bool) -> NodeId {
        self.once(BIT, Op::Bit(value))
    }
    fn and(self, a: NodeId, b: NodeId) -> NodeId {
        match (self.known_bit(a), self.known_bit(b)) {
            (Some(true), _) | (_, Some(false)) => b,
            (Some(false), _) | (_, Some(true)) => a,
            (None, None) => self.push(BIT, Op::And(a, b)),
        }
    }
    fn or(self, a: NodeId, b: NodeId) -> NodeId {
        match (self.known_bit(a), self.known_bit(b)) {
            (Some(false), _) | (_, Some(true)) => b,
            (Some(true), _) | (_, Some(false)) => a,
            (None, None) => self.push(BIT, Op::Or(a, b)),
        }
    }
    fn not(self, a: NodeId) -> NodeId {
        match self.known_bit(a) {
            Some(value) => self.constant_bit(!value),
            None => self.push(BIT, Op::Not(a)),
        }
    }
    fn constant_word(self, width: u32, value: u32) -> NodeId {
        self.once(Kind::Word(width), Op::Word(value))
    }
    fn word_equal(self, a: NodeId, b: NodeId) -> NodeId {
        self.push(BIT, Op::WordEqual(a, b))
    }
    fn word_less(self, a: NodeId, b: NodeId) -> NodeId {
        match (self.known_word(a), self.known_word(b)) {
            (Some(a), Some(b)) => self.constant_bit(a < b),
            _ => self.push(BIT, Op::WordLess(a, b)),
        }
    }
    fn select_num(self, condition: NodeId, if_true: NodeId, if_false: NodeId) -> NodeId {
        self.push(Kind::Number, Op::Select(condition, if_true, if_false))
    }
    fn select_bit(self, condition: NodeId, if_true: NodeId, if_false: NodeId) -> NodeId {
        self.push(BIT, Op::Select(condition, if_true, if_false))
    }
    fn select_word(self, condition: NodeId, if_true: NodeId, if_false: NodeId) -> NodeId {
        let kind = self.recording.nodes.borrow()[if_true.index()].kind;
        self.push(kind, Op::Select(condition, if_true, if_false))
    }
}

impl PartialEq for RecordingCircuit<'_> {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.recording, other.recording)
    }
}

impl fmt::Debug for RecordingCircuit<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("RecordingCircuit")
    }
}

fn port_bit(field: &Field<'_>) -> PortBit {
    PortBit { port: field.name.to_string(), bit: field.bit }
}

/// The name of a field, with its number if it is one bit of several.
fn name_of(field: &Field<'_>) -> String {
    field.bit.map_or_else(|| field.name.to_string(), |(bit, _)| format!("{}_{bit}", field.name))
}

/// The source of input values or of states: `add` adds a node. Not generic over the operation, so that it is compiled
/// once.
struct ValueSource<'s, 'g> {
    c: RecordingCircuit<'g>,
    add: &'s mut dyn FnMut(Kind, Field<'_>) -> NodeId,
}

impl<'g> Source<RecordingCircuit<'g>> for ValueSource<'_, 'g> {
    fn num(&mut self, field: Field<'_>) -> Num<RecordingCircuit<'g>> {
        Num::new(self.c, (self.add)(Kind::Number, field))
    }
    fn bit(&mut self, field: Field<'_>) -> Bit<RecordingCircuit<'g>> {
        Bit::new(self.c, (self.add)(BIT, field))
    }
    fn word(&mut self, field: Field<'_>, width: u32) -> (RecordingCircuit<'g>, NodeId) {
        (self.c, (self.add)(Kind::Word(width), field))
    }
}

/// A sink that passes on each field with its node. Not generic, like [`ValueSource`].
struct NodeSink<'s>(&'s mut dyn FnMut(Field<'_>, NodeId));

impl<'g> Sink<RecordingCircuit<'g>> for NodeSink<'_> {
    fn num(&mut self, field: Field<'_>, value: Num<RecordingCircuit<'g>>) {
        (self.0)(field, value.value);
    }
    fn bit(&mut self, field: Field<'_>, value: Bit<RecordingCircuit<'g>>) {
        (self.0)(field, value.value);
    }
    fn word(&mut self, field: Field<'_>, _width: u32, value: NodeId) {
        (self.0)(field, value);
    }
}
