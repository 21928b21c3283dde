//! The circuit that records: every operator leaves a node.

use crate::graph::{Kind, Node, NodeId, Op, OutputValue, PortBit, StateValue, Traced};
use raypath_ops::{Binary32, Bit, Bundle, Circuit, Field, Num, Operation, Path, Relation, Single, Sink, Source, Test};
use std::borrow::Cow;
use std::cell::{Cell, RefCell};
use std::fmt;

/// What the stages that an operation marks are to the recorder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Marks {
    /// Where its values are made, unless it asks for automatic staging.
    #[default]
    Heeded,
    /// Nothing: it is staged automatically.
    Ignored,
}

/// Runs `operation` once and gives what it did, unchecked.
pub fn record<O: Operation>(operation: &O, opcode: u64, marks: Marks) -> Traced {
    let graph = Graph { marks, auto: Cell::new(marks == Marks::Ignored), ..Graph::default() };
    let c = Tracer { graph: &graph };
    let mut inputs = InputSource { c, is_there: &|port| operation.has_input(port), inputs: Vec::new() };
    let input = O::Input::build(&mut Path::default(), &mut inputs);
    let inputs = inputs.inputs;
    let mut states = StateSource { c, names: Vec::new() };
    let state = O::State::build(&mut Path::default(), &mut states);
    let names = states.names;

    let (output, next) = operation.run(c, input, state);

    let mut outputs = OutputSink { is_there: &|port| operation.has_output(port), outputs: Vec::new() };
    output.each(&mut Path::default(), &mut outputs);
    let outputs = outputs.outputs;
    let mut next_nodes = Leaves(Vec::new());
    next.each(&mut Path::default(), &mut next_nodes);

    let states = names.into_iter().zip(next_nodes.0).collect();
    graph.traced(O::NAME, opcode, inputs, outputs, states)
}

#[derive(Default)]
struct Graph {
    nodes: RefCell<Vec<Node>>,
    notes: RefCell<Vec<(u32, Cow<'static, str>)>>,
    stage: Cell<u32>,
    marks: Marks,
    auto: Cell<bool>,
}

impl Graph {
    fn traced(
        &self,
        name: &'static str,
        opcode: u64,
        inputs: Vec<NodeId>,
        outputs: Vec<OutputValue>,
        states: Vec<(String, NodeId)>,
    ) -> Traced {
        let nodes = self.nodes.take();
        let state = |(name, next): (String, NodeId)| {
            let stage = nodes[next.index()].stage;
            StateValue { name, next, written: stage, read: stage }
        };
        let states = states.into_iter().map(state).collect();
        let (notes, is_auto) = (self.notes.take(), self.auto.get());
        Traced { name, opcode, inputs, outputs, states, notes, is_auto, counts_exceptions: false, nodes }
    }
}

/// The circuit that records.
#[derive(Clone, Copy)]
struct Tracer<'g> {
    graph: &'g Graph,
}

impl Tracer<'_> {
    fn push(self, kind: Kind, op: Op) -> NodeId {
        self.push_at(self.graph.stage.get(), kind, op)
    }

    fn push_at(self, stage: u32, kind: Kind, op: Op) -> NodeId {
        let mut nodes = self.graph.nodes.borrow_mut();
        nodes.push(Node { op, kind, stage, name: None });
        NodeId(nodes.len() as u32 - 1)
    }

    /// The node of a value that costs no unit, made once however often it is written.
    fn once(self, kind: Kind, op: Op) -> NodeId {
        let found = self.graph.nodes.borrow().iter().position(|node| node.op == op && node.kind == kind);
        found.map_or_else(|| self.push(kind, op), |index| NodeId(index as u32))
    }

    /// A bit whose value follows from constants, such as the order of two boxes' numbers before they are sorted.
    fn known_bit(self, id: NodeId) -> Option<bool> {
        match self.graph.nodes.borrow()[id.index()].op {
            Op::Bit(value) => Some(value),
            _ => None,
        }
    }

    fn known_word(self, id: NodeId) -> Option<u32> {
        match self.graph.nodes.borrow()[id.index()].op {
            Op::Word(value) => Some(value),
            _ => None,
        }
    }

    fn name(self, id: NodeId, name: &str) {
        let mut nodes = self.graph.nodes.borrow_mut();
        let node = &mut nodes[id.index()];
        if !matches!(node.op, Op::Input(_) | Op::Number(_) | Op::OnePlusUlps(_) | Op::Bit(_) | Op::Word(_)) {
            node.name = Some(name.to_string());
        }
    }
}

const BIT: Kind = Kind::Word(1);

impl Circuit for Tracer<'_> {
    type Num = NodeId;
    type Bit = NodeId;
    type Word = NodeId;
    type Order = NodeId;

    fn stage(self, number: u32, what: &'static str) {
        if self.graph.marks == Marks::Ignored {
            return;
        }
        self.graph.stage.set(number);
        let mut notes = self.graph.notes.borrow_mut();
        let note = (number, Cow::Borrowed(what));
        if !notes.contains(&note) {
            notes.push(note);
        }
    }

    fn auto(self) {
        self.graph.auto.set(true);
    }

    fn label<B: Bundle<Self>>(self, name: fmt::Arguments<'_>, value: &B) {
        value.each(&mut Path::new(&name.to_string()), &mut LabelSink(self));
    }

    fn constant(self, value: f32) -> NodeId {
        self.once(Kind::Number, Op::Number(value.to_bits()))
    }
    fn one_plus_ulps(self, ulps: u32) -> NodeId {
        self.once(Kind::Number, Op::OnePlusUlps(ulps))
    }
    fn add(self, a: NodeId, b: NodeId) -> NodeId {
        self.push(Kind::Number, Op::Add(a, b))
    }
    fn subtract(self, a: NodeId, b: NodeId) -> NodeId {
        self.push(Kind::Number, Op::Subtract(a, b))
    }
    fn multiply(self, a: NodeId, b: NodeId) -> NodeId {
        self.push(Kind::Number, Op::Multiply(a, b))
    }
    fn negate(self, a: NodeId) -> NodeId {
        self.push(Kind::Number, Op::Negate(a))
    }
    fn compare(self, a: NodeId, b: NodeId) -> NodeId {
        self.push(Kind::Order, Op::Compare(a, b))
    }
    fn relation(self, order: NodeId, relation: Relation) -> NodeId {
        // Read where the comparison is made: one bit crosses the registers, not the comparator's three.
        let stage = self.graph.nodes.borrow()[order.index()].stage;
        self.push_at(stage, BIT, Op::Relation(order, relation))
    }
    fn number_of(self, _width: u32, word: NodeId) -> NodeId {
        match self.known_word(word) {
            Some(value) => self.constant(value as f32),
            None => self.push(Kind::Number, Op::NumberOf(word)),
        }
    }
    fn test(self, test: Test, a: NodeId) -> NodeId {
        let op = self.graph.nodes.borrow()[a.index()].op.clone();
        match (op, test) {
            (Op::Number(bits), _) => self.constant_bit(Binary32.test(test, Single(f32::from_bits(bits)))),
            // Of a negated number its original is asked, so that no number is made for its sign's sake.
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
        let kind = self.graph.nodes.borrow()[if_true.index()].kind;
        self.push(kind, Op::Select(condition, if_true, if_false))
    }
}

impl PartialEq for Tracer<'_> {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.graph, other.graph)
    }
}

impl fmt::Debug for Tracer<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Tracer")
    }
}

fn port_bit(field: &Field<'_>) -> PortBit {
    PortBit { port: field.name.to_string(), bit: field.bit }
}

/// Values that arrive at ports. It does not name the operation's type: every type would have a copy of all this.
struct InputSource<'g> {
    c: Tracer<'g>,
    is_there: &'g dyn Fn(&str) -> bool,
    inputs: Vec<NodeId>,
}

impl InputSource<'_> {
    fn push(&mut self, kind: Kind, field: Field<'_>) -> NodeId {
        let name = match field.bit {
            Some((bit, _)) => format!("{}_{bit}", field.name),
            None => field.name.to_string(),
        };
        let id = self.c.push_at(0, kind, Op::Input(port_bit(&field)));
        self.c.graph.nodes.borrow_mut()[id.index()].name = Some(name);
        if (self.is_there)(field.name) {
            self.inputs.push(id);
        }
        id
    }
}

impl<'g> Source<Tracer<'g>> for InputSource<'g> {
    fn num(&mut self, field: Field<'_>) -> Num<Tracer<'g>> {
        Num::new(self.c, self.push(Kind::Number, field))
    }
    fn bit(&mut self, field: Field<'_>) -> Bit<Tracer<'g>> {
        Bit::new(self.c, self.push(BIT, field))
    }
    fn word(&mut self, field: Field<'_>, width: u32) -> (Tracer<'g>, NodeId) {
        (self.c, self.push(Kind::Word(width), field))
    }
}

struct StateSource<'g> {
    c: Tracer<'g>,
    names: Vec<String>,
}

impl StateSource<'_> {
    fn push(&mut self, kind: Kind, field: Field<'_>) -> NodeId {
        self.names.push(field.name.to_string());
        let id = self.c.push_at(0, kind, Op::State(self.names.len() - 1));
        self.c.name(id, field.name);
        id
    }
}

impl<'g> Source<Tracer<'g>> for StateSource<'g> {
    fn num(&mut self, field: Field<'_>) -> Num<Tracer<'g>> {
        Num::new(self.c, self.push(Kind::Number, field))
    }
    fn bit(&mut self, field: Field<'_>) -> Bit<Tracer<'g>> {
        Bit::new(self.c, self.push(BIT, field))
    }
    fn word(&mut self, field: Field<'_>, width: u32) -> (Tracer<'g>, NodeId) {
        (self.c, self.push(Kind::Word(width), field))
    }
}

/// Values that leave at ports.
struct OutputSink<'o> {
    is_there: &'o dyn Fn(&str) -> bool,
    outputs: Vec<OutputValue>,
}

impl OutputSink<'_> {
    fn push(&mut self, field: Field<'_>, node: NodeId) {
        if (self.is_there)(field.name) {
            self.outputs.push(OutputValue { port: port_bit(&field), node });
        }
    }
}

impl<'g> Sink<Tracer<'g>> for OutputSink<'_> {
    fn num(&mut self, field: Field<'_>, value: Num<Tracer<'g>>) {
        self.push(field, value.value);
    }
    fn bit(&mut self, field: Field<'_>, value: Bit<Tracer<'g>>) {
        self.push(field, value.value);
    }
    fn word(&mut self, field: Field<'_>, _width: u32, value: NodeId) {
        self.push(field, value);
    }
}

/// The leaves of a structure, in order.
struct Leaves(Vec<NodeId>);

impl<'g> Sink<Tracer<'g>> for Leaves {
    fn num(&mut self, _: Field<'_>, value: Num<Tracer<'g>>) {
        self.0.push(value.value);
    }
    fn bit(&mut self, _: Field<'_>, value: Bit<Tracer<'g>>) {
        self.0.push(value.value);
    }
    fn word(&mut self, _: Field<'_>, _: u32, value: NodeId) {
        self.0.push(value);
    }
}

struct LabelSink<'g>(Tracer<'g>);

impl<'g> Sink<Tracer<'g>> for LabelSink<'g> {
    fn num(&mut self, field: Field<'_>, value: Num<Tracer<'g>>) {
        self.0.name(value.value, field.name);
    }
    fn bit(&mut self, field: Field<'_>, value: Bit<Tracer<'g>>) {
        match field.bit {
            Some((bit, _)) => self.0.name(value.value, &format!("{}_{bit}", field.name)),
            None => self.0.name(value.value, field.name),
        }
    }
    fn word(&mut self, field: Field<'_>, _: u32, value: NodeId) {
        self.0.name(value, field.name);
    }
}
