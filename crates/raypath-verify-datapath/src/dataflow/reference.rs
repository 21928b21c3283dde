//! An operation as terms of a script: a circuit whose numbers are recoded, and whose units may be any functions.

use super::conversion::Conversion;
use super::script::{Script, Term};
use super::units::Units;
use raypath_ops::{Bit, Bundle, Circuit, Field, Narrowing, Num, Operation, Path, Relation, Sink, Source, Test};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// The outcome of a job: the values at its ports, by name without the direction, and of the states after it.
#[derive(Debug, Default)]
pub(super) struct Outcome {
    pub outputs: BTreeMap<String, Term>,
    pub states: BTreeMap<String, Term>,
    /// The exceptions of each sum and product, if the units report them.
    pub exceptions: Vec<Term>,
    /// The units of one operand that it uses.
    pub conversions: BTreeSet<Conversion>,
}

/// The values of a job: at the ports, without the direction, and of the states before it.
pub(super) trait JobValues {
    /// The value at a port; none if there is no such port.
    fn input(&self, port: &str) -> Option<Term>;
    /// The value of a state; none if there is no such state.
    fn state(&self, state: &str) -> Option<Term>;
    /// The width of a port out, if there is one.
    fn output_width(&self, port: &str) -> Option<u32>;
}

/// The outcome of an operation for a job.
pub(super) fn outcome<O: Operation>(
    operation: &O,
    script: &mut Script,
    units: Units<'_>,
    values: &dyn JobValues,
) -> Outcome {
    let made =
        Made { script: RefCell::new(script), units, exceptions: RefCell::default(), conversions: RefCell::default() };
    let c = Terms { made: &made };
    let mut read = |field: Field<'_>, width: Option<u32>| c.input(values, &field, width);
    let input = O::Input::build(&mut Path::default(), &mut TermSource { c, read: &mut read });
    let mut names = Vec::new();
    let mut read = |field: Field<'_>, width: Option<u32>| {
        names.push(field.name.to_string());
        values.state(field.name).unwrap_or_else(|| c.free(width))
    };
    let state = O::State::build(&mut Path::default(), &mut TermSource { c, read: &mut read });

    let (output, next) = operation.run(c, input, state);

    let mut outcome = Outcome::default();
    let mut write = |field: Field<'_>, value: Term, bits: Option<u32>| {
        if !operation.has_output(field.name) {
            return;
        }
        let mut script = made.script.borrow_mut();
        let width = values.output_width(field.name).unwrap_or(value.width);
        let value = bits.map_or(value, |bits| units.decoded(&mut script, value, bits, width));
        // The bits of a port come in order, the lowest first.
        match outcome.outputs.get_mut(field.name).filter(|_| field.bit.is_some()) {
            Some(low) => *low = script.operator(low.width + 1, "concat", &[value, *low]),
            None => {
                outcome.outputs.insert(field.name.to_string(), value);
            }
        }
    };
    output.each(&mut Path::default(), &mut TermSink(&mut write));
    let mut nexts = Vec::new();
    next.each(&mut Path::default(), &mut TermSink(&mut |_, value, _| nexts.push(value)));
    outcome.states = names.into_iter().zip(nexts).collect();
    outcome.exceptions = made.exceptions.take();
    outcome.conversions = made.conversions.take();
    outcome
}

/// What terms are made of.
struct Made<'s, 'd> {
    script: RefCell<&'s mut Script>,
    units: Units<'d>,
    exceptions: RefCell<Vec<Term>>,
    conversions: RefCell<BTreeSet<Conversion>>,
}

/// The circuit.
#[derive(Clone, Copy)]
struct Terms<'m, 's, 'd> {
    made: &'m Made<'s, 'd>,
}

/// A number.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Number {
    term: Term,
    /// The bits of the significand, hidden bit included; all below are zero.
    bits: u32,
    /// The operands, if it is a product.
    factors: Option<(Term, Term)>,
}

impl Terms<'_, '_, '_> {
    /// The value of an input. One that the design lacks may be any, because the operation must not read it.
    fn input(self, values: &dyn JobValues, field: &Field<'_>, width: Option<u32>) -> Term {
        let Some(port) = values.input(field.name) else { return self.free(width) };
        let script = &mut self.made.script.borrow_mut();
        match (width, field.bit) {
            (None, _) => self.made.units.encoded(script, port),
            (Some(_), Some((bit, _))) => script.slice(port, bit, bit),
            (Some(width), None) => script.slice(port, width - 1, 0),
        }
    }

    /// Any value: a number, or a word.
    fn free(self, width: Option<u32>) -> Term {
        self.made.script.borrow_mut().free(width.unwrap_or(self.made.units.format.recoded_width()))
    }

    fn number(self, term: Term) -> Number {
        Number { term, bits: self.made.units.format.significand(), factors: None }
    }

    /// A constant (docs/reference/formats.md).
    fn recoded(self, value: f64) -> Number {
        let format = self.made.units.format;
        let (exponent, fraction) = (format.exponent(), format.fraction_width());
        let sign = u64::from(value.is_sign_negative());
        let bits = value.abs().to_bits();
        let magnitude = match value {
            0.0 => 0,
            _ if value.is_infinite() => 0b110 << (exponent - 2 + fraction),
            _ => {
                let field = (bits >> 52) + (1 << exponent) - 1023;
                (field << fraction) | ((bits & ((1 << 52) - 1)) >> (52 - fraction))
            }
        };
        let bias = (1_u64 << (exponent - 1)) - 1;
        let ieee = match value {
            0.0 => 0,
            _ if value.is_infinite() => format.infinity(),
            _ => magnitude - (((1 << exponent) - bias) << fraction),
        };
        // Also what is known of its negation, which is a constant too.
        let [term, _] = [sign, 1 - sign].map(|sign| {
            let script = &mut self.made.script.borrow_mut();
            let term = script.constant(format.recoded_width(), (sign << (exponent + 1 + fraction)) | magnitude);
            self.made.units.is_constant(script, term, (sign << (exponent + fraction)) | ieee);
            term
        });
        let used = format.significand() - magnitude.trailing_zeros().min(fraction);
        self.short(term, used)
    }

    /// A number of `bits` bits, zeros below.
    fn short(self, term: Term, bits: u32) -> Number {
        self.made.units.is_short(&mut self.made.script.borrow_mut(), term, bits);
        Number { term, bits, factors: None }
    }

    fn operator(self, width: u32, name: &str, operands: &[Term]) -> Term {
        self.made.script.borrow_mut().operator(width, name, operands)
    }

    fn holds(self, condition: String) -> Term {
        self.made.script.borrow_mut().bit(&condition)
    }

    fn select(self, condition: Term, if_true: Term, if_false: Term) -> Term {
        self.made.script.borrow_mut().select(condition, if_true, if_false)
    }

    fn binary(self, stem: &str, a: Number, b: Number, output: &str) -> Term {
        let results = self.made.units.binary(&mut self.made.script.borrow_mut(), stem, a.term, b.term, output);
        self.made.exceptions.borrow_mut().extend(results.exceptions);
        results.number
    }

    fn converted(self, conversion: Conversion, operand: Term) -> Term {
        self.made.conversions.borrow_mut().insert(conversion);
        self.made.units.converted(&mut self.made.script.borrow_mut(), conversion, operand)
    }

    /// The sign and the class of a number.
    fn sign_and_class(self, a: Term) -> (Term, Term) {
        let script = &mut self.made.script.borrow_mut();
        (script.slice(a, a.width - 1, a.width - 1), script.slice(a, a.width - 2, a.width - 4))
    }
}

impl Circuit for Terms<'_, '_, '_> {
    type Num = Number;
    type Bit = Term;
    type Word = Term;
    /// Less, equal, unordered.
    type Order = [Term; 3];

    fn constant(self, value: f32) -> Number {
        self.recoded(value.into())
    }
    fn ulps(self, ulps: u32) -> Number {
        self.recoded(f64::from(ulps) * 2.0_f64.powi(-(self.made.units.format.fraction_width() as i32)))
    }
    fn add(self, a: Number, b: Number) -> Number {
        self.number(self.binary("add", a, b, "sum"))
    }
    fn sum(self, terms: &[Number]) -> Number {
        let terms: Vec<Term> = terms.iter().map(|number| number.term).collect();
        let sum = self.made.units.sum(&mut self.made.script.borrow_mut(), &terms);
        self.number(sum)
    }
    fn subtract(self, a: Number, b: Number) -> Number {
        self.add(a, self.negate(b))
    }
    fn multiply(self, a: Number, b: Number) -> Number {
        let product = self.binary("mul", a, b, "product");
        for [a, b] in [[a, b], [b, a]] {
            let script = &mut self.made.script.borrow_mut();
            self.made.units.product_by_short(script, a.term, (b.term, b.bits), product);
        }
        Number { factors: Some((a.term, b.term)), ..self.number(product) }
    }
    fn residue(self, _product: Number, a: Number, b: Number) -> Term {
        self.made.units.residue(&mut self.made.script.borrow_mut(), a.term, b.term)
    }
    fn negate(self, a: Number) -> Number {
        let width = a.term.width;
        let sign = self.made.script.borrow_mut().constant(width, 1 << (width - 1));
        self.short(self.operator(width, "bvxor", &[a.term, sign]), a.bits)
    }
    fn narrow(self, a: Number, to: Narrowing) -> Number {
        let term = self.converted(Conversion::Narrow(to), a.term);
        if let Some(factors) = a.factors {
            self.made.units.narrow_product(&mut self.made.script.borrow_mut(), factors, to, term);
        }
        self.short(term, to.bits)
    }
    fn compare(self, a: Number, b: Number) -> [Term; 3] {
        let bits = a.bits.max(b.bits);
        self.made.units.compare(&mut self.made.script.borrow_mut(), a.term, b.term, bits)
    }
    fn relation(self, [less, equal, unordered]: [Term; 3], relation: Relation) -> Term {
        match relation {
            Relation::Less => less,
            Relation::Equal => equal,
            Relation::LessOrEqual => self.or(less, equal),
            Relation::GreaterOrEqual => self.not(self.or(less, unordered)),
            Relation::Greater => self.not(self.or(self.or(less, equal), unordered)),
        }
    }
    fn number_of(self, width: u32, word: Term) -> Number {
        let bits = width.min(self.made.units.format.significand());
        Number { bits, ..self.number(self.converted(Conversion::Number(width), word)) }
    }
    fn test(self, test: Test, a: Number) -> Term {
        let (sign, class) = self.sign_and_class(a.term);
        let (zero, nan) = (format!("(= {class} #b000)"), format!("(= {class} #b111)"));
        let signed = |bit: &str| format!("(and (= {sign} {bit}) (not {nan}))");
        self.holds(match test {
            Test::SignBit => format!("(= {sign} #b1)"),
            Test::Zero => zero,
            Test::Nan => nan,
            Test::AtLeastZero => format!("(or {zero} {})", signed("#b0")),
            Test::AboveZero => format!("(and (not {zero}) {})", signed("#b0")),
            Test::AtMostZero => format!("(or {zero} {})", signed("#b1")),
            Test::BelowZero => format!("(and (not {zero}) {})", signed("#b1")),
        })
    }
    fn constant_bit(self, value: bool) -> Term {
        self.constant_word(1, u32::from(value))
    }
    fn and(self, a: Term, b: Term) -> Term {
        self.operator(1, "bvand", &[a, b])
    }
    fn or(self, a: Term, b: Term) -> Term {
        self.operator(1, "bvor", &[a, b])
    }
    fn not(self, a: Term) -> Term {
        self.operator(1, "bvnot", &[a])
    }
    fn constant_word(self, width: u32, value: u32) -> Term {
        self.made.script.borrow_mut().constant(width, value.into())
    }
    fn word_equal(self, a: Term, b: Term) -> Term {
        self.holds(format!("(= {a} {b})"))
    }
    fn word_less(self, a: Term, b: Term) -> Term {
        self.holds(format!("(bvult {a} {b})"))
    }
    fn select_num(self, condition: Term, a: Number, b: Number) -> Number {
        let term = self.select(condition, a.term, b.term);
        self.short(term, a.bits.max(b.bits))
    }
    fn select_bit(self, condition: Term, if_true: Term, if_false: Term) -> Term {
        self.select(condition, if_true, if_false)
    }
    fn select_word(self, condition: Term, if_true: Term, if_false: Term) -> Term {
        self.select(condition, if_true, if_false)
    }
}

impl PartialEq for Terms<'_, '_, '_> {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.made, other.made)
    }
}

impl fmt::Debug for Terms<'_, '_, '_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Terms")
    }
}

/// A source of values: `read` takes a field and its width, none for a number.
struct TermSource<'a, 'm, 's, 'd> {
    c: Terms<'m, 's, 'd>,
    read: &'a mut dyn FnMut(Field<'_>, Option<u32>) -> Term,
}

impl<'m, 's, 'd> Source<Terms<'m, 's, 'd>> for TermSource<'_, 'm, 's, 'd> {
    fn num(&mut self, field: Field<'_>) -> Num<Terms<'m, 's, 'd>> {
        Num::new(self.c, self.c.number((self.read)(field, None)))
    }
    fn bit(&mut self, field: Field<'_>) -> Bit<Terms<'m, 's, 'd>> {
        Bit::new(self.c, (self.read)(field, Some(1)))
    }
    fn word(&mut self, field: Field<'_>, width: u32) -> (Terms<'m, 's, 'd>, Term) {
        (self.c, (self.read)(field, Some(width)))
    }
}

/// A sink of values, with the bits of the significand of a number.
struct TermSink<'a>(&'a mut dyn FnMut(Field<'_>, Term, Option<u32>));

impl<'m, 's, 'd> Sink<Terms<'m, 's, 'd>> for TermSink<'_> {
    fn num(&mut self, field: Field<'_>, value: Num<Terms<'m, 's, 'd>>) {
        (self.0)(field, value.value.term, Some(value.value.bits));
    }
    fn bit(&mut self, field: Field<'_>, value: Bit<Terms<'m, 's, 'd>>) {
        (self.0)(field, value.value, None);
    }
    fn word(&mut self, field: Field<'_>, _width: u32, value: Term) {
        (self.0)(field, value, None);
    }
}
