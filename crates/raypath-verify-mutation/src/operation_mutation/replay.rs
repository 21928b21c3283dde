//! A dataflow, with or without a fault, as an operation again: over any circuit, so that a datapath can be elaborated
//! from it.

use super::graph::{Graph, Id, Kind, Op};
use raypath_ops::{Bit, Bundle, Circuit, Field, Num, Operation, Path, Sink, Source};
use std::sync::Arc;

/// An operation with the ports of another one and a dataflow of its own.
#[derive(Debug, Clone)]
pub struct Replayed<O> {
    pub operation: O,
    pub graph: Arc<Graph>,
}

/// A value of a circuit.
#[derive(Debug, Clone, Copy)]
enum Value<C: Circuit> {
    Number(C::Num),
    Bit(C::Bit),
    Word(C::Word),
    Order(C::Order),
}

impl<O: Operation> Operation for Replayed<O> {
    const NAME: &'static str = O::NAME;
    type Input<C: Circuit> = O::Input<C>;
    type Output<C: Circuit> = O::Output<C>;
    type State<C: Circuit> = O::State<C>;

    fn has_input(&self, port: &str) -> bool {
        self.operation.has_input(port)
    }

    fn has_output(&self, port: &str) -> bool {
        self.operation.has_output(port)
    }

    fn run<C: Circuit>(&self, c: C, input: Self::Input<C>, state: Self::State<C>) -> (Self::Output<C>, Self::State<C>) {
        let graph = &self.graph;
        let (mut inputs, mut states) = (Leaves::default(), Leaves::default());
        input.each(&mut Path::default(), &mut inputs);
        state.each(&mut Path::default(), &mut states);
        let mut values: Vec<Value<C>> = Vec::with_capacity(graph.nodes.len());
        for (id, node) in graph.nodes.iter().enumerate() {
            graph
                .marks
                .iter()
                .filter(|mark| mark.nodes == id)
                .for_each(|mark| c.stage_or(mark.stage, mark.short, mark.what));
            let source = match node.op {
                Op::Input(port, bit, _) => inputs.at(&graph.inputs[port].name, bit),
                Op::State(_) => states.at(&node.name, 0),
                _ => None,
            };
            let mut value = source.unwrap_or_else(|| computed(c, node.op, &node.operands, &values));
            if let (Value::Bit(bit), true) = (value, node.inverted) {
                value = Value::Bit(c.not(bit));
            }
            if !node.name.is_empty() && !matches!(node.op, Op::Input(..) | Op::State(_)) {
                name(c, &node.name, value);
            }
            values.push(value);
        }
        let mut next = graph.states.iter().map(|state| values[state.1]);
        let next = O::State::build(&mut Path::unnamed(), &mut Built { c, next: &mut |_| next.next() });
        let output = |field: &Field<'_>| {
            let bit = field.bit.map_or(0, |(bit, _)| bit);
            let port = graph.ports_out.iter().position(|port| port.name == field.name);
            graph.outputs.iter().find(|leaf| Some(leaf.port) == port && leaf.bit == bit).map(|leaf| values[leaf.node])
        };
        (O::Output::build(&mut Path::default(), &mut Built { c, next: &mut { output } }), next)
    }
}

fn name<C: Circuit>(c: C, name: &str, value: Value<C>) {
    match value {
        Value::Number(value) => c.label(format_args!("{name}"), &Num::new(c, value)),
        Value::Bit(value) => c.label(format_args!("{name}"), &Bit::new(c, value)),
        Value::Word(_) | Value::Order(_) => {}
    }
}

fn computed<C: Circuit>(c: C, op: Op, operands: &[Id], values: &[Value<C>]) -> Value<C> {
    let number = |place: usize| match operands.get(place).map(|&id| values[id]) {
        Some(Value::Number(number)) => number,
        _ => c.constant(0.0),
    };
    let bit = |place: usize| match operands.get(place).map(|&id| values[id]) {
        Some(Value::Bit(bit)) => bit,
        _ => c.constant_bit(false),
    };
    let word = |place: usize, width: u32| match operands.get(place).map(|&id| values[id]) {
        Some(Value::Word(word)) => word,
        _ => c.constant_word(width, 0),
    };
    match op {
        Op::Constant(value) => Value::Number(c.constant(value)),
        Op::OnePlusUlps(ulps) => Value::Number(c.one_plus_ulps(ulps)),
        Op::Add => Value::Number(c.add(number(0), number(1))),
        Op::Sum => {
            let terms: Vec<C::Num> = (0..operands.len()).map(number).collect();
            Value::Number(c.sum(&terms))
        }
        Op::Subtract => Value::Number(c.subtract(number(0), number(1))),
        Op::Multiply => Value::Number(c.multiply(number(0), number(1))),
        Op::Negate => Value::Number(c.negate(number(0))),
        Op::Narrow(to) => Value::Number(c.narrow(number(0), to)),
        Op::Compare => Value::Order(c.compare(number(0), number(1))),
        Op::Relation(relation) => Value::Bit(match operands.first().map(|&id| values[id]) {
            Some(Value::Order(order)) => c.relation(order, relation),
            _ => c.constant_bit(false),
        }),
        Op::NumberOf(width) => Value::Number(c.number_of(width, word(0, width))),
        Op::Test(test) => Value::Bit(c.test(test, number(0))),
        Op::Bit(value) => Value::Bit(c.constant_bit(value)),
        Op::And => Value::Bit(c.and(bit(0), bit(1))),
        Op::Or => Value::Bit(c.or(bit(0), bit(1))),
        Op::Not => Value::Bit(c.not(bit(0))),
        Op::Word(width, value) => Value::Word(c.constant_word(width, value)),
        Op::WordEqual => Value::Bit(c.word_equal(word(0, 1), word(1, 1))),
        Op::WordLess => Value::Bit(c.word_less(word(0, 1), word(1, 1))),
        Op::Select(Kind::Number) => Value::Number(c.select_num(bit(0), number(1), number(2))),
        Op::Select(Kind::Word(width)) => Value::Word(c.select_word(bit(0), word(1, width), word(2, width))),
        Op::Select(_) => Value::Bit(c.select_bit(bit(0), bit(1), bit(2))),
        Op::Same(_) => values[operands[0]],
        // Only sources that are missing come here.
        Op::Input(_, _, kind) | Op::State(kind) => match kind {
            Kind::Number | Kind::Order => Value::Number(c.constant(0.0)),
            Kind::Bit => Value::Bit(c.constant_bit(false)),
            Kind::Word(width) => Value::Word(c.constant_word(width, 0)),
        },
    }
}

/// The values of a bundle, with the names of their ports and their bits.
struct Leaves<C: Circuit>(Vec<(String, u32, Value<C>)>);

impl<C: Circuit> Default for Leaves<C> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<C: Circuit> Leaves<C> {
    fn at(&self, port: &str, bit: u32) -> Option<Value<C>> {
        self.0.iter().find(|(name, of, _)| name == port && *of == bit).map(|(_, _, value)| *value)
    }

    fn push(&mut self, field: &Field<'_>, value: Value<C>) {
        self.0.push((field.name.to_string(), field.bit.map_or(0, |(bit, _)| bit), value));
    }
}

impl<C: Circuit> Sink<C> for Leaves<C> {
    fn num(&mut self, field: Field<'_>, value: Num<C>) {
        self.push(&field, Value::Number(value.value));
    }
    fn bit(&mut self, field: Field<'_>, value: Bit<C>) {
        self.push(&field, Value::Bit(value.value));
    }
    fn word(&mut self, field: Field<'_>, _width: u32, value: C::Word) {
        self.push(&field, Value::Word(value));
    }
}

/// A source of computed values; zeros where there are none.
struct Built<'a, C: Circuit> {
    c: C,
    next: &'a mut dyn FnMut(&Field<'_>) -> Option<Value<C>>,
}

impl<C: Circuit> Source<C> for Built<'_, C> {
    fn num(&mut self, field: Field<'_>) -> Num<C> {
        match (self.next)(&field) {
            Some(Value::Number(value)) => Num::new(self.c, value),
            _ => self.c.zero(),
        }
    }
    fn bit(&mut self, field: Field<'_>) -> Bit<C> {
        match (self.next)(&field) {
            Some(Value::Bit(value)) => Bit::new(self.c, value),
            _ => self.c.bit(false),
        }
    }
    fn word(&mut self, field: Field<'_>, width: u32) -> (C, C::Word) {
        match (self.next)(&field) {
            Some(Value::Word(value)) => (self.c, value),
            _ => (self.c, self.c.constant_word(width, 0)),
        }
    }
}
