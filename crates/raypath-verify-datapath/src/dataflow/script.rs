//! A problem in SMT-LIB 2: bit-vectors, each defined once, and uninterpreted functions of bit-vectors.

use num_bigint::BigUint;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt::Write;

/// A bit-vector of a script.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Term {
    number: u32,
    /// Its bits.
    pub width: u32,
}

impl std::fmt::Display for Term {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "t{}", self.number)
    }
}

/// What a term is made of.
#[derive(Debug, Clone, Copy)]
enum Parts {
    /// Bits of a term, from this one on.
    Slice(Term, u32),
    Concatenation(Term, Term),
}

/// The bits of a weight.
const WEIGHT: u32 = 32;

/// Definitions in the order in which they were made. Equal expressions are one term.
#[derive(Debug, Default)]
pub struct Script {
    functions: BTreeMap<String, (Vec<u32>, u32)>,
    /// Declarations, definitions and assumptions, a line each.
    lines: Vec<String>,
    terms: HashMap<String, Term>,
    known: HashMap<Term, BigUint>,
    /// What slices and concatenations are made of.
    made_of: HashMap<Term, Parts>,
    count: u32,
}

impl Script {
    /// A bit-vector of any value.
    pub fn free(&mut self, width: u32) -> Term {
        let term = self.next(width);
        self.lines.push(format!("(declare-fun {term} () (_ BitVec {width}))"));
        term
    }

    /// The value of an expression of bit-vectors.
    pub fn define(&mut self, width: u32, expression: String) -> Term {
        if let Some(&term) = self.terms.get(&expression) {
            return term;
        }
        let term = self.next(width);
        self.lines.push(format!("(define-fun {term} () (_ BitVec {width}) {expression})"));
        self.terms.insert(expression, term);
        term
    }

    /// The value of a function that may be any function of its operands.
    pub fn apply(&mut self, function: &str, operands: &[Term], width: u32) -> Term {
        let widths = operands.iter().map(|operand| operand.width).collect();
        self.functions.entry(function.to_string()).or_insert((widths, width));
        let operands: String = operands.iter().map(|operand| format!(" {operand}")).collect();
        self.define(width, format!("(|{function}|{operands})"))
    }

    /// The value of a function that may be any function which does not depend on the order of its operands. Functions of
    /// one `family` have the same operands, as the outputs of a unit do.
    ///
    /// It is a function of the sum of the operands' weights, which are any function of an operand. That is no
    /// restriction: a script has a few hundred lists of operands at most, and for random weights the probability that
    /// two different lists have the same sum is less than 2^-[`WEIGHT`] times the number of pairs of lists, times their
    /// length. So there are weights for which all sums differ.
    pub fn apply_to_all(&mut self, family: &str, function: &str, operands: &[Term], width: u32) -> Term {
        let weight = format!("weight of {family}");
        let mut weights: Vec<Term> = operands.iter().map(|&operand| self.apply(&weight, &[operand], WEIGHT)).collect();
        weights.sort();
        let sum = self.operator(WEIGHT, "bvadd", &weights);
        self.apply(function, &[sum], width)
    }

    /// A condition that holds.
    pub fn assume(&mut self, condition: &str) {
        self.lines.push(format!("(assert {condition})"));
    }

    /// A constant.
    pub fn constant(&mut self, width: u32, value: u64) -> Term {
        self.wide_constant(width, value.into())
    }

    /// A constant of more bits.
    pub fn wide_constant(&mut self, width: u32, value: BigUint) -> Term {
        let term = self.define(width, format!("(_ bv{value} {width})"));
        self.known.insert(term, value);
        term
    }

    /// The value of a term, if it is a constant.
    pub fn known(&self, term: Term) -> Option<&BigUint> {
        self.known.get(&term)
    }

    /// One bit: whether a condition holds.
    pub fn bit(&mut self, condition: &str) -> Term {
        self.define(1, format!("(ite {condition} #b1 #b0)"))
    }

    /// An operator of the theory of bit-vectors.
    pub fn operator(&mut self, width: u32, name: &str, operands: &[Term]) -> Term {
        let operands: String = operands.iter().map(|operand| format!(" {operand}")).collect();
        self.define(width, format!("({name}{operands})"))
    }

    /// The bits `high` to `low` of a term, or of the part of it that has them all.
    pub fn slice(&mut self, mut term: Term, mut high: u32, mut low: u32) -> Term {
        while let Some(&parts) = self.made_of.get(&term) {
            let (part, begin) = match parts {
                Parts::Slice(of, from) => {
                    (high, low) = (high + from, low + from);
                    (of, 0)
                }
                Parts::Concatenation(_, lower) if high < lower.width => (lower, 0),
                Parts::Concatenation(upper, lower) if low >= lower.width => (upper, lower.width),
                Parts::Concatenation(..) => break,
            };
            (term, high, low) = (part, high - begin, low - begin);
        }
        if (high, low) == (term.width - 1, 0) {
            return term;
        }
        let slice = self.define(high - low + 1, format!("((_ extract {high} {low}) {term})"));
        self.made_of.insert(slice, Parts::Slice(term, low));
        slice
    }

    /// Two terms behind each other. Neighbouring slices of a term are one slice.
    pub fn concatenate(&mut self, upper: Term, lower: Term) -> Term {
        if let (Some(&Parts::Slice(of, from)), Some(&Parts::Slice(same, low))) =
            (self.made_of.get(&upper), self.made_of.get(&lower))
            && of == same
            && from == low + lower.width
        {
            return self.slice(of, from + upper.width - 1, low);
        }
        let both = self.operator(upper.width + lower.width, "concat", &[upper, lower]);
        self.made_of.insert(both, Parts::Concatenation(upper, lower));
        both
    }

    /// One of two terms.
    pub fn select(&mut self, condition: Term, if_true: Term, if_false: Term) -> Term {
        self.define(if_true.width, format!("(ite (= {condition} #b1) {if_true} {if_false})"))
    }

    /// The question whether one of the pairs can differ; its answer `unsat` means that none can.
    pub fn differs(&self, pairs: &[(String, Term, Term)]) -> String {
        let mut text = self.text(pairs.iter().flat_map(|(_, actual, expected)| [*actual, *expected]));
        // Bitwuzla refuses an `or` of one term.
        let mut all = " false".to_string();
        for (number, (_, actual, expected)) in pairs.iter().enumerate() {
            let _ = writeln!(text, "(define-fun d{number} () Bool (distinct {actual} {expected}))");
            let _ = write!(all, " d{number}");
        }
        text + &format!("(assert (or{all}))\n(check-sat)\n")
    }

    /// The question whether all assumptions can hold together.
    pub fn holds(&self) -> String {
        self.text([]) + "(check-sat)\n"
    }

    /// The assumptions, and the definitions that they or these terms need.
    fn text(&self, terms: impl IntoIterator<Item = Term>) -> String {
        let mut needed: HashSet<u32> = terms.into_iter().map(|term| term.number).collect();
        let mut lines: Vec<&str> = Vec::new();
        for line in self.lines.iter().rev() {
            let mut terms = line.split([' ', '(', ')']).filter_map(term_number).peekable();
            let is_assumption = line.starts_with("(assert");
            if is_assumption || terms.peek().is_some_and(|defined| needed.contains(defined)) {
                needed.extend(terms);
                lines.push(line);
            }
        }

        let mut text = "(set-logic QF_UFBV)\n".to_string();
        for (name, (operands, width)) in &self.functions {
            let operands: Vec<String> = operands.iter().map(|width| format!("(_ BitVec {width})")).collect();
            let _ = writeln!(text, "(declare-fun |{name}| ({}) (_ BitVec {width}))", operands.join(" "));
        }
        for line in lines.into_iter().rev() {
            text += line;
            text.push('\n');
        }
        text
    }

    fn next(&mut self, width: u32) -> Term {
        self.count += 1;
        Term { number: self.count, width }
    }
}

/// The number of a term in a script.
fn term_number(word: &str) -> Option<u32> {
    word.strip_prefix('t')?.parse().ok()
}
