//! Hardware from a step: a circuit whose values are wires of a module.

use crate::step::StepParameters;
use crate::words::WordCircuit;
use raypath_hdl::{Builder, Wire};
use raypath_ops::{Bit, Bundle, Circuit, Field, Narrowing, Num, Path, Relation, Sink, Source, Test};
use std::fmt;

/// A circuit that adds gates to a module. Numbers are in the IEEE 754 layout of binary32. It has no arithmetic on
/// numbers: a module in which a number is added or multiplied is refused when it is finished.
#[derive(Clone, Copy)]
pub struct Netlist<'m>(pub &'m Builder);

/// A value of [`Netlist`].
#[derive(Clone, Copy)]
pub struct Value<'m>(pub Wire<'m>);

/// A comparison of two numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison<'m> {
    less: Value<'m>,
    equal: Value<'m>,
    greater: Value<'m>,
}

const WIDTH: u32 = 32;
const INFINITY: u64 = 0x7f80_0000;

impl PartialEq for Netlist<'_> {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.0, other.0)
    }
}

impl fmt::Debug for Netlist<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Netlist")
    }
}

impl PartialEq for Value<'_> {
    /// Whether both are the same wire.
    fn eq(&self, other: &Self) -> bool {
        self.0 == other.0
    }
}

impl fmt::Debug for Value<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bits", self.0.width())
    }
}

impl<'m> Netlist<'m> {
    fn constant_value(self, width: u32, value: u64) -> Value<'m> {
        Value(self.0.constant(width, value))
    }

    /// A wire that nothing drives, which the builder reports.
    fn no_arithmetic(self) -> Value<'m> {
        Value(self.0.forward_unnamed(WIDTH).wire())
    }

    fn magnitude(self, a: Value<'m>) -> Wire<'m> {
        a.0.lower(WIDTH - 1)
    }

    fn is_zero(self, a: Value<'m>) -> Wire<'m> {
        self.magnitude(a).is(0)
    }

    fn is_nan(self, a: Value<'m>) -> Wire<'m> {
        self.0.constant(WIDTH - 1, INFINITY).less(self.magnitude(a))
    }
}

impl<'m> Circuit for Netlist<'m> {
    type Num = Value<'m>;
    type Bit = Value<'m>;
    type Word = Value<'m>;
    type Order = Comparison<'m>;

    fn label<B: Bundle<Self>>(self, name: fmt::Arguments<'_>, value: &B) {
        wires(&name.to_string(), value).into_iter().for_each(|(name, wire)| _ = wire.hint(&name));
    }
    fn constant(self, value: f32) -> Value<'m> {
        self.constant_value(WIDTH, value.to_bits().into())
    }
    fn ulps(self, ulps: u32) -> Value<'m> {
        self.constant_value(WIDTH, u64::from((ulps as f32 * f32::EPSILON).to_bits()))
    }
    fn add(self, _a: Value<'m>, _b: Value<'m>) -> Value<'m> {
        self.no_arithmetic()
    }
    fn sum(self, _terms: &[Value<'m>]) -> Value<'m> {
        self.no_arithmetic()
    }
    fn subtract(self, _a: Value<'m>, _b: Value<'m>) -> Value<'m> {
        self.no_arithmetic()
    }
    fn multiply(self, _a: Value<'m>, _b: Value<'m>) -> Value<'m> {
        self.no_arithmetic()
    }
    fn residue(self, _product: Value<'m>, _a: Value<'m>, _b: Value<'m>) -> Value<'m> {
        self.no_arithmetic()
    }
    fn negate(self, a: Value<'m>) -> Value<'m> {
        Value(self.0.concat(&[!a.0.top(), self.magnitude(a)]))
    }

    fn narrow(self, _a: Value<'m>, _to: Narrowing) -> Value<'m> {
        self.no_arithmetic()
    }

    fn compare(self, a: Value<'m>, b: Value<'m>) -> Comparison<'m> {
        let unordered = (self.is_nan(a) | self.is_nan(b)).hint("unordered");
        let equal = (a.0.equals(b.0) | (self.is_zero(a) & self.is_zero(b))).hint("equal");
        let (p, q) = (self.magnitude(a), self.magnitude(b));
        let (a_negative, b_negative) = (a.0.top(), b.0.top());
        let alike = a_negative.mux(q.less(p), p.less(q)).hint("alike_below");
        let below = (a_negative ^ b_negative).mux(a_negative, alike).hint("below");
        let less = (below & !equal).hint("less");
        Comparison {
            less: Value(!unordered & less),
            equal: Value(!unordered & equal),
            greater: Value(!unordered & !equal & !less),
        }
    }

    fn relation(self, order: Comparison<'m>, relation: Relation) -> Value<'m> {
        let Comparison { less, equal, greater } = order;
        match relation {
            Relation::Less => less,
            Relation::LessOrEqual => Value(less.0 | equal.0),
            Relation::Equal => equal,
            Relation::GreaterOrEqual => Value(greater.0 | equal.0),
            Relation::Greater => greater,
        }
    }

    fn number_of(self, _width: u32, _word: Value<'m>) -> Value<'m> {
        self.no_arithmetic()
    }

    fn test(self, test: Test, a: Value<'m>) -> Value<'m> {
        let (negative, zero, nan) = (a.0.top(), self.is_zero(a), self.is_nan(a));
        Value(match test {
            Test::SignBit => negative,
            Test::Zero => zero,
            Test::Nan => nan,
            Test::AtLeastZero => !nan & (zero | !negative),
            Test::AboveZero => !nan & !zero & !negative,
            Test::AtMostZero => !nan & (zero | negative),
            Test::BelowZero => !nan & !zero & negative,
        })
    }

    fn constant_bit(self, value: bool) -> Value<'m> {
        self.constant_value(1, value.into())
    }
    fn and(self, a: Value<'m>, b: Value<'m>) -> Value<'m> {
        Value(a.0 & b.0)
    }
    fn or(self, a: Value<'m>, b: Value<'m>) -> Value<'m> {
        Value(a.0 | b.0)
    }
    fn not(self, a: Value<'m>) -> Value<'m> {
        Value(!a.0)
    }

    fn constant_word(self, width: u32, value: u32) -> Value<'m> {
        self.constant_value(width, value.into())
    }
    fn word_equal(self, a: Value<'m>, b: Value<'m>) -> Value<'m> {
        Value(a.0.equals(b.0))
    }
    fn word_less(self, a: Value<'m>, b: Value<'m>) -> Value<'m> {
        Value(a.0.less(b.0))
    }

    fn select_num(self, condition: Value<'m>, if_true: Value<'m>, if_false: Value<'m>) -> Value<'m> {
        Value(condition.0.mux(if_true.0, if_false.0))
    }
    fn select_bit(self, condition: Value<'m>, if_true: Value<'m>, if_false: Value<'m>) -> Value<'m> {
        self.select_num(condition, if_true, if_false)
    }
    fn select_word(self, condition: Value<'m>, if_true: Value<'m>, if_false: Value<'m>) -> Value<'m> {
        self.select_num(condition, if_true, if_false)
    }
}

impl<'m> WordCircuit for Netlist<'m> {
    fn word_add(self, _width: u32, a: Value<'m>, b: Value<'m>) -> Value<'m> {
        Value(a.0 + b.0)
    }
    fn word_part(self, a: Value<'m>, low: u32, width: u32) -> Value<'m> {
        Value(a.0.bits(low + width - 1, low))
    }
    fn word_join(self, (_, high): (u32, Value<'m>), (_, low): (u32, Value<'m>)) -> Value<'m> {
        Value(self.0.concat(&[high.0, low.0]))
    }
    fn word_of_bit(self, a: Value<'m>) -> Value<'m> {
        a
    }
    fn word_bit(self, a: Value<'m>, index: Value<'m>) -> Value<'m> {
        Value((a.0 & self.word_one_hot(index).0).any())
    }
    fn word_one_hot(self, index: Value<'m>) -> Value<'m> {
        Value(self.0.constant(32, 1).shift_left(index.0))
    }
    fn number_of_bits(self, a: Value<'m>) -> Value<'m> {
        a
    }
    fn word_and(self, _width: u32, a: Value<'m>, b: Value<'m>) -> Value<'m> {
        Value(a.0 & b.0)
    }
    fn word_or(self, _width: u32, a: Value<'m>, b: Value<'m>) -> Value<'m> {
        Value(a.0 | b.0)
    }
    fn word_not(self, _width: u32, a: Value<'m>) -> Value<'m> {
        Value(!a.0)
    }
    fn is_finite(self, a: Value<'m>) -> Value<'m> {
        Value(!a.0.bits(30, 23).all())
    }
    fn word_highest(self, a: Value<'m>) -> Value<'m> {
        // The upper half if it has a bit, else the lower one. The lowest bit of each decides nothing.
        let mut word = a.0.upper(31);
        let [b4, b3, b2, b1] = [16, 8, 4, 2].map(|half| {
            let is_in_upper = word.upper(half).any().hint(&format!("is_in_upper_{half}"));
            word = is_in_upper.mux(word.upper(half - 1), word.lower(half - 1)).hint(&format!("half_of_{half}"));
            is_in_upper
        });
        Value(self.0.concat(&[b4, b3, b2, b1, word]))
    }
}

/// A bundle of the wires that `wire` returns for its ports, by name and width, in order.
pub fn from_wires<'m, B: Bundle<Netlist<'m>>>(
    builder: &'m Builder,
    name: &str,
    wire: impl FnMut(&str, u32) -> Wire<'m>,
) -> B {
    B::build(&mut Path::new(name), &mut FromWires { circuit: Netlist(builder), wire, flags: None })
}

/// A bundle of the inputs `<name>_<field>_i` of a module.
pub fn inputs<'m, B: Bundle<Netlist<'m>>>(builder: &'m Builder, name: &str) -> B {
    from_wires(builder, name, |field, width| builder.input(&format!("{field}_i"), width))
}

/// A bundle of the inputs `<name>_<field>_i` of a module. Fields that the features do not have are 0.
pub fn inputs_with<'m, B: Bundle<Netlist<'m>>>(builder: &'m Builder, name: &str, step: StepParameters) -> B {
    from_wires(builder, name, |field, width| match step.has(field) {
        true => builder.input(&format!("{field}_i"), width),
        false => builder.constant(width, 0),
    })
}

/// A bundle of these wires, one for each port, in order. A missing wire is an error of the builder.
pub fn from_list<'m, B: Bundle<Netlist<'m>>>(builder: &'m Builder, wires: &[Wire<'m>]) -> B {
    let mut wires = wires.iter();
    let missing = |width: u32| builder.forward_unnamed(width).wire();
    from_wires(builder, "", |_, width| wires.next().copied().unwrap_or_else(|| missing(width)))
}

/// The ports of a bundle, `<name>_<field>`, with their wires.
pub fn wires<'m>(name: &str, bundle: &impl Bundle<Netlist<'m>>) -> Vec<(String, Wire<'m>)> {
    let mut found = ToWires::default();
    bundle.each(&mut Path::new(name), &mut found);
    found.ports
}

/// The ports of a bundle that the features have, with their wires.
pub fn wires_with<'m>(
    name: &str,
    bundle: &impl Bundle<Netlist<'m>>,
    step: StepParameters,
) -> impl Iterator<Item = (String, Wire<'m>)> {
    wires(name, bundle).into_iter().filter(move |(port, _)| step.has(port))
}

/// Adds the outputs `<name>_<field>_o` for the ports of a bundle that the features have.
pub fn outputs_with<'m>(builder: &'m Builder, name: &str, bundle: &impl Bundle<Netlist<'m>>, step: StepParameters) {
    for (port, wire) in wires_with(name, bundle, step) {
        builder.output(&format!("{port}_o"), wire);
    }
}

/// Adds the outputs `<name>_<field>_o` for the ports of a bundle.
pub fn outputs<'m>(builder: &'m Builder, name: &str, bundle: &impl Bundle<Netlist<'m>>) {
    for (port, wire) in wires(name, bundle) {
        builder.output(&format!("{port}_o"), wire);
    }
}

struct FromWires<'m, F> {
    circuit: Netlist<'m>,
    wire: F,
    /// The port whose bits arrive, the lowest first.
    flags: Option<Wire<'m>>,
}

impl<'m, F: FnMut(&str, u32) -> Wire<'m>> Source<Netlist<'m>> for FromWires<'m, F> {
    fn num(&mut self, field: Field<'_>) -> Num<Netlist<'m>> {
        Num::new(self.circuit, Value((self.wire)(field.name, WIDTH)))
    }
    fn bit(&mut self, field: Field<'_>) -> Bit<Netlist<'m>> {
        let Some((bit, width)) = field.bit else { return Bit::new(self.circuit, Value((self.wire)(field.name, 1))) };
        let port = match self.flags {
            Some(port) if bit > 0 => port,
            _ => (self.wire)(field.name, width),
        };
        self.flags = Some(port);
        Bit::new(self.circuit, Value(port.bit(bit)))
    }
    fn word(&mut self, field: Field<'_>, width: u32) -> (Netlist<'m>, Value<'m>) {
        (self.circuit, Value((self.wire)(field.name, width)))
    }
}

#[derive(Default)]
struct ToWires<'m> {
    flags: Vec<Wire<'m>>,
    ports: Vec<(String, Wire<'m>)>,
}

impl<'m> Sink<Netlist<'m>> for ToWires<'m> {
    fn num(&mut self, field: Field<'_>, value: Num<Netlist<'m>>) {
        self.ports.push((field.name.to_string(), value.value.0));
    }
    fn bit(&mut self, field: Field<'_>, value: Bit<Netlist<'m>>) {
        let wire = value.value.0;
        let Some((_, width)) = field.bit else { return self.ports.push((field.name.to_string(), wire)) };
        // Bits of a port arrive in order, the lowest first.
        self.flags.push(wire);
        if self.flags.len() == width as usize {
            let bits: Vec<Wire<'m>> = self.flags.drain(..).rev().collect();
            self.ports.push((field.name.to_string(), wire.builder().concat(&bits)));
        }
    }
    fn word(&mut self, field: Field<'_>, _width: u32, value: Value<'m>) {
        self.ports.push((field.name.to_string(), value.0));
    }
}
