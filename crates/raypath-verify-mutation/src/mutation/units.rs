//! The unit tests' operands on floating-point units with a fault.

use rand::rngs::ChaCha8Rng;
use raypath_float::Format;
use raypath_hdl::{Module, Simulator};
use raypath_rtl::Config;
use raypath_verify::Error;
use raypath_verify_arithmetic::units::bench::{UnitResults, chain};
use raypath_verify_arithmetic::units::operands::{self, CASES, RECODED_CASES, canonical, generator, host_results};
use std::sync::Arc;

/// A part of a floating-point unit, by its number.
pub struct Unit {
    kind: Kind,
    parts: Vec<Arc<Module>>,
    part: usize,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Add,
    Multiply,
    Compare,
    Encode,
    Decode,
}

impl Unit {
    /// The unit of a binary32 configuration with a part of this name.
    pub fn of(config: Config, name: &str) -> Result<Option<Self>, Error> {
        let (format, built) = (config.semantics.format, config.microarchitecture);
        let units = [
            (Kind::Add, built.adder_parts(format, false)?),
            (Kind::Multiply, built.multiplier_parts(format, false)?),
            (Kind::Compare, vec![raypath_float::compare(format)?]),
            (Kind::Encode, vec![raypath_float::encode(format)?]),
            (Kind::Decode, vec![raypath_float::decode(format)?]),
        ];
        let found = units.into_iter().filter(|_| format == Format::BINARY32).find_map(|(kind, parts)| {
            let part = parts.iter().position(|part| part.name() == name)?;
            Some(Self { kind, parts, part })
        });
        Ok(found)
    }

    /// The unit test that fails with this module in place of the part, if any.
    pub fn check(&self, module: &Arc<Module>) -> Result<Option<&'static str>, Error> {
        let mut parts = self.parts.clone();
        parts[self.part] = module.clone();
        let whole = if parts.len() == 1 { module.clone() } else { chain(&parts)? };
        let mut bench = Bench { kind: self.kind, unit: Simulator::new(&whole)? };
        let checks: &[(&'static str, Check)] = match self.kind {
            Kind::Encode | Kind::Decode => &[("unit test, conversions", Bench::converts)],
            _ => &[
                ("unit test, edges", Bench::answers_edges),
                ("unit test, recoded words", Bench::answers_recoded),
                ("unit test, hard operands", Bench::answers_hard_operands),
            ],
        };
        Ok(checks.iter().find(|(_, check)| !check(&mut bench)).map(|(name, _)| *name))
    }
}

type Check = fn(&mut Bench) -> bool;

/// A unit in the netlist simulator, and its oracle.
struct Bench {
    kind: Kind,
    unit: Simulator,
}

impl Bench {
    /// Whether the outputs for these words are those of the results: a number as `of_number` says of the word at the
    /// output and that of IEEE 754, or relations.
    fn shows(&mut self, words: [u64; 2], results: UnitResults, of_number: impl Fn(u64, u64) -> bool) -> bool {
        let UnitResults { sum, product, less, equal, unordered, .. } = results;
        let outputs = self.unit.evaluate(words);
        match self.kind {
            Kind::Add => of_number(outputs[0], sum),
            Kind::Multiply => of_number(outputs[0], product),
            _ => outputs == [less, equal, unordered].map(u64::from),
        }
    }

    /// Whether the results for two binary32 numbers are right.
    fn answers(&mut self, a: u32, b: u32) -> bool {
        let format = Format::BINARY32;
        let results = host_results(f32::from_bits(a), f32::from_bits(b));
        self.shows([a, b].map(|code| format.encode(code.into())), results, |word, code| format.decode(word) == code)
    }

    fn answers_edges(&mut self) -> bool {
        let edges = operands::edges();
        edges.iter().all(|&a| edges.iter().all(|&b| self.answers(a, b)))
    }

    /// Results must be canonical words.
    fn answers_recoded(&mut self) -> bool {
        let mut random = generator(5);
        (0..RECODED_CASES).all(|_| {
            let ((a, x), (b, y)) = (operands::recoded(&mut random), operands::recoded(&mut random));
            self.shows([a, b], host_results(x, y), |word, code| word == Format::BINARY32.encode(code))
        })
    }

    /// Starts with the operands of the unit's own test, because those of the others rarely find more.
    fn answers_hard_operands(&mut self) -> bool {
        type Operands = fn(&mut ChaCha8Rng) -> (u32, u32);
        let all: [(u64, Operands); 3] =
            [(1, operands::for_sums), (2, operands::for_products), (3, operands::for_comparisons)];
        let first = match self.kind {
            Kind::Multiply => 1,
            Kind::Compare => 2,
            _ => 0,
        };
        (0..all.len()).map(|offset| all[(first + offset) % all.len()]).all(|(seed, operands)| {
            let mut random = generator(seed);
            (0..CASES).all(|_| {
                let (a, b) = operands(&mut random);
                self.answers(a, b)
            })
        })
    }

    fn converts(&mut self) -> bool {
        let format = Format::BINARY32;
        let mut random = generator(4);
        let numbers =
            operands::edges_of_conversions().chain((0..CASES).map(|_| operands::for_conversions(&mut random)));
        for number in numbers {
            let is_right = match self.kind {
                Kind::Encode => self.unit.evaluate([number.into()]) == [format.encode(number.into())],
                _ => self.unit.evaluate([format.encode(number.into())]) == [canonical(f32::from_bits(number))],
            };
            if !is_right {
                return false;
            }
        }
        let mut random = generator(5);
        self.kind == Kind::Encode
            || (0..RECODED_CASES).all(|_| {
                let (word, number) = operands::recoded(&mut random);
                self.unit.evaluate([word]) == [canonical(number)]
            })
    }
}
