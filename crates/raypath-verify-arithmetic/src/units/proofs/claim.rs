//! Claims about units, and the miters that would show them wrong.

use super::{short, sum};
use crate::units::bench::{chain, unrolled};
use raypath_float::{
    DivSqrt, Format, Narrow, add, add_parts, compare, decode, div, encode, mul, mul_inferred_parts, mul_narrow_parts,
    mul_parts, narrow, sqrt, sum_parts,
};
use raypath_hdl::Module;
use raypath_hdl::verilog::text;
use raypath_tools::ToolError;
use raypath_verify::Error;
use raypath_verify::sat::{Miter, SOURCE};
use std::fmt;
use std::sync::Arc;

/// A claim about a unit in a format, for a set of operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Claim {
    /// The unit, and what it should compute.
    pub subject: Subject,
    /// The number format.
    pub format: Format,
    /// The operands.
    pub operands: Operands,
}

/// A unit, and what it should compute.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Subject {
    /// The adder between encoders and decoder, for sums.
    Add,
    /// The adder with the second operand's sign inverted, for differences: as the datapath subtracts.
    Sub,
    /// The multiplier between encoders and decoder.
    Mul,
    /// The multiplier with `*` between encoders and decoder.
    MulInferred,
    /// The combinational divider between encoders and decoder.
    Div,
    /// The combinational square root between encoder and decoder.
    Sqrt,
    /// The comparator behind encoders.
    Compare,
    /// The encoder and then the decoder: every number is unchanged, and every NaN becomes the canonical one.
    RoundTrip,
    /// The adder split into this many parts, against the unsplit one, for all recoded words.
    AddParts(u32),
    /// The multiplier split into this many parts, against the unsplit one, for all recoded words.
    MulParts(u32),
    /// The multiplier with `*` split into this many parts, against the unsplit one, for all recoded words.
    MulInferredParts(u32),
    /// The multiplier of short numbers, whose product is rounded to the format and then in one direction, so that it is
    /// as short as they are.
    ShortProduct(Narrow),
    /// The rounding to a shorter significand in one direction.
    Shortening(Narrow),
    /// The sum of this many terms, rounded once, between encoders and decoder, against its definition in
    /// docs/reference/semantics.md.
    Sum(u32),
    /// The divider or the square root in another form, against the combinational one, for all recoded words.
    Divided(DivSqrt, Form),
}

/// A form of a divider or square root.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Split into this many parts.
    Parts(u32),
    /// Iterative, with this many digits a cycle, from any idle state.
    Iterative(u32),
}

/// The operands of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operands {
    /// All operands.
    All,
    /// Operands with this difference of biased exponents: the first minus the second.
    ExponentDifference(i64),
    /// Operands of which one has a biased exponent that is larger by this or more: the first, or the second.
    Apart {
        /// The least difference.
        least: u32,
        /// Whether the first operand has the larger exponent.
        first: bool,
    },
}

impl Subject {
    /// The deliberate fault that the claim's negative control must find: a piece of the unit's text, which must occur
    /// exactly once, and its replacement. Like real defects, it shows for few operands: in a rounding, at the end of a
    /// range, or for a pair of zeros.
    pub fn fault(self) -> (&'static str, &'static str) {
        match self {
            Self::Add | Self::Sub | Self::AddParts(_) => ("~(half & quarter)", "~(half | quarter)"),
            Self::Mul | Self::MulParts(_) | Self::MulInferred | Self::MulInferredParts(_) => {
                ("= exponent_sum < ", "= exponent_sum <= ")
            }
            Self::Div | Self::Sqrt | Self::Divided(..) => ("below_half)) | sticky", "below_half)) & sticky"),
            Self::Compare => ("a_negative & ~both_zero", "a_negative"),
            Self::ShortProduct(_) => ("< LeastKept", "<= LeastKept"),
            Self::Shortening(Narrow { away: false, margin: 1.., .. }) => (" & ordinary", ""),
            Self::Shortening(_) => ("< LeastKept", "<= LeastKept"),
            Self::RoundTrip => ("exponent < ", "exponent <= "),
            Self::Sum(_) => ("& (below_guard | ", "& (below_guard & "),
        }
    }
}

impl Claim {
    /// A claim about all operands.
    pub fn all(subject: Subject, format: Format) -> Self {
        Self { subject, format, operands: Operands::All }
    }

    /// The miter, whose output is 1 for operands for which the claim is wrong; with the deliberate fault or without it.
    ///
    /// # Errors
    /// The unit cannot be built, or the fault's text is not exactly once in it.
    pub fn miter(&self, with_fault: bool) -> Result<Miter, Error> {
        let (f, ieee) = (self.format, self.format.ieee_width());
        let whole = |unit: Arc<Module>| text(&unit);
        let joined = |parts: Vec<Arc<Module>>| text(&chain(&parts)?);
        let conversions = || Ok::<_, raypath_hdl::Error>(text(&encode(f)?)? + &text(&decode(f)?)?);
        let (mut unit, rest, reference) = match self.subject {
            Subject::Add => (whole(add(f)?)?, conversions()?, Some("-op add -rm RNE")),
            Subject::Sub => (whole(add(f)?)?, conversions()?, Some("-op sub -rm RNE")),
            Subject::Mul => (whole(mul(f)?)?, conversions()?, Some("-op mul -rm RNE")),
            Subject::MulInferred => {
                (whole(mul_inferred_parts(f, 1, false)?.remove(0))?, conversions()?, Some("-op mul -rm RNE"))
            }
            Subject::Div => (whole(div(f)?)?, conversions()?, Some("-op div -rm RNE")),
            Subject::Sqrt => (whole(sqrt(f)?)?, conversions()?, Some("-op sqrt -rm RNE")),
            Subject::Compare => (whole(compare(f)?)?, conversions()?, Some("-compare")),
            Subject::RoundTrip => (text(&decode(f)?)?, text(&encode(f)?)?, None),
            Subject::ShortProduct(to @ Narrow { bits, away, .. }) => {
                let unit = mul_narrow_parts(f, bits, to, 1)?.remove(0);
                let short = f.narrowed(bits)?;
                let operation = match away {
                    _ if 2 * bits > f.significand() => "-op mul -rm RNE",
                    true => "-op mul -rm DYN",
                    false => "-op mul -rm RTZ",
                };
                (whole(unit)?, text(&encode(short)?)? + &text(&decode(short)?)?, Some(operation))
            }
            Subject::Shortening(to) => {
                (whole(narrow(f, to)?)?, text(&encode(f)?)? + &text(&decode(f.narrowed(to.bits)?)?)?, None)
            }
            Subject::Sum(terms) => (whole(sum_parts(f, terms, 1)?.remove(0))?, conversions()?, None),
            Subject::AddParts(count) => (joined(add_parts(f, count, false)?)?, whole(add(f)?)?, None),
            Subject::MulParts(count) => (joined(mul_parts(f, count, false)?)?, whole(mul(f)?)?, None),
            Subject::MulInferredParts(count) => (
                joined(mul_inferred_parts(f, count, false)?)?,
                whole(mul_inferred_parts(f, 1, false)?.remove(0))?,
                None,
            ),
            Subject::Divided(function, form) => {
                let [ours, reference] = in_form(f, function, form)?;
                (whole(ours)?, whole(reference)?, None)
            }
        };
        if with_fault {
            let (from, to) = self.subject.fault();
            let times = unit.matches(from).count();
            if times != 1 {
                let found = format!("{self}: found '{from}' {times} times in the unit's text");
                let expected = "it once, as the place of the deliberate fault";
                return Err(ToolError::unexpected("raypath", found, expected).into());
            }
            unit = unit.replace(from, to);
        }
        let mut commands = Vec::new();
        if let Some(operation) = reference {
            let significand = match self.subject {
                Subject::ShortProduct(Narrow { bits, .. }) if 2 * bits <= f.significand() => bits,
                _ => f.significand(),
            };
            commands.push(format!("symfpu -eb {} -sb {significand} {operation}", f.exponent()));
            // Its assertions would become outputs.
            commands.push("chformal -remove".to_string());
            commands.push(format!("select -assert-min {MIN_CELLS} symfpu/c:*"));
        }
        commands.extend(["unit.sv", "rest.sv", "miter.sv"].map(|file| format!("read_verilog -sv {SOURCE}{file}")));
        commands.extend(["hierarchy -check -top miter", "proc"].map(String::from));
        if reference.is_some() {
            commands.push("select -assert-count 1 miter/t:symfpu".to_string());
        }
        let inputs = self.inputs()?;
        for side in ["ours", "expected"] {
            for (input, _) in inputs.iter().filter(|(input, _)| !input.starts_with(STATE)) {
                commands.push(format!("select -assert-min 1 miter/w:{side} %ci* miter/w:{input} %i"));
            }
        }
        Ok(Miter {
            name: self.to_string(),
            sources: [("unit.sv", unit), ("rest.sv", rest), ("miter.sv", self.miter_text(ieee)?)]
                .map(|(name, text)| (name.to_string(), text))
                .into(),
            commands,
            inputs,
        })
    }

    /// Whether both sides are units of ours, from one description: they may be equal before any proof.
    pub fn compares_own_units(&self) -> bool {
        use Subject::{AddParts, Divided, MulInferredParts, MulParts};
        matches!(self.subject, AddParts(_) | MulParts(_) | MulInferredParts(_) | Divided(..))
    }

    /// Whether the second operand is not used. The terms of a sum are in the first one.
    pub fn is_unary(&self) -> bool {
        matches!(
            self.subject,
            Subject::RoundTrip
                | Subject::Shortening(_)
                | Subject::Sqrt
                | Subject::Sum(_)
                | Subject::Divided(DivSqrt::Root, _)
        )
    }

    /// The miter's inputs, with their widths.
    fn inputs(&self) -> Result<Vec<(String, u32)>, Error> {
        let f = self.format;
        let width = match self.subject {
            _ if self.compares_own_units() => f.recoded_width(),
            Subject::ShortProduct(Narrow { bits, .. }) => f.narrowed(bits)?.ieee_width(),
            Subject::Sum(terms) => terms * f.ieee_width(),
            _ => f.ieee_width(),
        };
        let ports: &[(&str, u32)] = match (self.subject, self.operands) {
            _ if self.is_unary() => &[("free_a", width)],
            (_, Operands::All | Operands::Apart { .. }) => &[("free_a", width), ("free_b", width)],
            (_, Operands::ExponentDifference(_)) => &[("free_a", f.significand()), ("free_b", width)],
        };
        let operands = ports.iter().map(|&(name, width)| (name.to_string(), width));
        Ok(operands.chain(self.state()?).collect())
    }

    /// The first values of an iterative unit's registers, with their widths.
    fn state(&self) -> Result<Vec<(String, u32)>, Error> {
        let Subject::Divided(function, form) = self.subject else { return Ok(Vec::new()) };
        let [ours, _] = in_form(self.format, function, form)?;
        let names = ours.inputs().iter().map(|port| &port.name).filter(|name| name.starts_with(STATE));
        Ok(names.map(|name| (name.clone(), ours.port_width(name).unwrap_or_default())).collect())
    }

    /// The text of the module `miter`. Messages about counterexamples show its wires `a`, `b`, `ours` and `wanted`.
    fn miter_text(&self, ieee: u32) -> Result<String, Error> {
        let (f, e, s) = (self.format, self.format.exponent(), self.format.significand());
        let recoded = f.recoded_width();
        let inputs: Vec<String> =
            self.inputs()?.iter().map(|(name, width)| format!("input [{}:0] {name}", width - 1)).collect();
        let (unit_ports, width) = match self.subject {
            _ if self.compares_own_units() => (recoded, recoded),
            Subject::Compare => (ieee, 3),
            Subject::Sum(terms) => (terms * ieee, ieee),
            Subject::ShortProduct(Narrow { bits, .. }) => [f.narrowed(bits)?.ieee_width(); 2].into(),
            Subject::Shortening(Narrow { bits, .. }) => (ieee, f.narrowed(bits)?.ieee_width()),
            _ => (ieee, ieee),
        };
        let mut lines = vec![
            format!("module miter ({}, output differ);", inputs.join(", ")),
            format!("wire [{0}:0] a, b; wire [{1}:0] ours, expected; wire valid;", unit_ports - 1, width - 1),
        ];
        lines.push(match self.operands {
            _ if self.is_unary() => "assign a = free_a; assign b = 0; assign valid = 1;".to_string(),
            Operands::All => "assign a = free_a; assign b = free_b; assign valid = 1;".to_string(),
            Operands::Apart { least, first } => {
                let (larger, smaller) = if first { ("a", "b") } else { ("b", "a") };
                let exponent = |name: &str| format!("{{1'b0, free_{name}[{}:{}]}}", e + s - 2, s - 1);
                format!(
                    "assign a = free_a; assign b = free_b; assign valid = {} >= {} + {}'d{least};",
                    exponent(larger),
                    exponent(smaller),
                    e + 1
                )
            }
            Operands::ExponentDifference(difference) => format!(
                "wire [{top}:0] exponent = {{2'b00, free_b[{high}:{low}]}} + {value};\n\
                 assign a = {{free_a[{low}], exponent[{}:0], free_a[{}:0]}}; assign b = free_b;\n\
                 assign valid = exponent[{top}:{e}] == 0;",
                e - 1,
                s - 2,
                top = e + 1,
                high = e + s - 2,
                low = s - 1,
                value = format_args!("{}'d{}", e + 2, difference.rem_euclid(1 << (e + 2))),
            ),
        });
        lines.push(self.sides(recoded)?);
        let is_nan = |word: &str| format!("((&{word}[{}:{}]) && (|{word}[{}:0]))", e + s - 2, s - 1, s - 2);
        let wanted = match self.subject {
            // The reference may return any NaN, our units return the canonical one.
            Subject::Add
            | Subject::Sub
            | Subject::Mul
            | Subject::MulInferred
            | Subject::Div
            | Subject::Sqrt
            | Subject::RoundTrip => {
                format!("{} ? {ieee}'d{} : expected", is_nan("expected"), f.nan())
            }
            Subject::Compare => {
                lines.push(format!("assign expected[0] = {} || {};", is_nan("a"), is_nan("b")));
                "expected".to_string()
            }
            // The drivers of `expected` have the canonical NaN.
            _ => "expected".to_string(),
        };
        lines.push(format!("wire [{}:0] wanted = {wanted};", width - 1));
        lines.push("assign differ = valid && (ours != wanted);\nendmodule\n".to_string());
        Ok(lines.join("\n"))
    }

    /// The drivers of `ours` and `expected`.
    fn sides(&self, recoded: u32) -> Result<String, Error> {
        let f = self.format;
        let encoders = format!(
            "wire [{0}:0] recoded_a, recoded_b;\n\
             raypath_fp_encode_{f} u_encode_a (.ieee_i(a), .recoded_o(recoded_a));\n\
             raypath_fp_encode_{f} u_encode_b (.ieee_i(b), .recoded_o(recoded_b));\n",
            recoded - 1
        );
        let arithmetic = |unit: &str, second: &str, output: &str| {
            format!(
                "{encoders}wire [{0}:0] recoded_result, second;\n\
                 assign second = {second};\n\
                 raypath_fp_{unit}_{f} u_unit (.a_i(recoded_a), .b_i(second), .{output}(recoded_result));\n\
                 raypath_fp_decode_{f} u_decode (.recoded_i(recoded_result), .ieee_o(ours));\n\
                 symfpu u_reference (.a(a), .b(b), .o(expected));",
                recoded - 1
            )
        };
        let parts = |count: u32, unit: &str, output: &str| {
            format!(
                "chain_of_raypath_fp_{unit}_{f}_part_1_of_{count} u_unit (.a_i(a), .b_i(b), .{output}(ours));\n\
                 raypath_fp_{unit}_{f} u_whole (.a_i(a), .b_i(b), .{output}(expected));"
            )
        };
        Ok(match self.subject {
            Subject::Add => arithmetic("add", "recoded_b", "sum_o"),
            Subject::Sub => {
                arithmetic("add", &format!("{{~recoded_b[{0}], recoded_b[{1}:0]}}", recoded - 1, recoded - 2), "sum_o")
            }
            Subject::Mul => arithmetic("mul", "recoded_b", "product_o"),
            Subject::MulInferred => arithmetic("mul_inferred", "recoded_b", "product_o"),
            Subject::Div => arithmetic("div", "recoded_b", "result_o"),
            Subject::Sqrt => format!(
                "wire [{0}:0] recoded_a, recoded_result;\n\
                 raypath_fp_encode_{f} u_encode (.ieee_i(a), .recoded_o(recoded_a));\n\
                 raypath_fp_sqrt_{f} u_unit (.a_i(recoded_a), .result_o(recoded_result));\n\
                 raypath_fp_decode_{f} u_decode (.recoded_i(recoded_result), .ieee_o(ours));\n\
                 symfpu u_reference (.a(a), .o(expected));",
                recoded - 1
            ),
            Subject::Compare => format!(
                "{encoders}raypath_fp_compare_{f} u_unit (.a_i(recoded_a), .b_i(recoded_b), .less_o(ours[2]), \
                 .equal_o(ours[1]), .unordered_o(ours[0]));\n\
                 symfpu u_reference (.a(a), .b(b), .lessThan(expected[2]), .ieee754Equal(expected[1]));"
            ),
            Subject::RoundTrip => format!(
                "wire [{0}:0] recoded_a;\n\
                 raypath_fp_encode_{f} u_encode (.ieee_i(a), .recoded_o(recoded_a));\n\
                 raypath_fp_decode_{f} u_decode (.recoded_i(recoded_a), .ieee_o(ours));\n\
                 assign expected = a;",
                recoded - 1
            ),
            Subject::ShortProduct(to) => short::product(f, to)?,
            Subject::Shortening(to) => short::shortening(f, to)?,
            Subject::Sum(terms) => sum::sides(f, terms),
            Subject::AddParts(count) => parts(count, "add", "sum_o"),
            Subject::MulParts(count) => parts(count, "mul", "product_o"),
            Subject::MulInferredParts(count) => parts(count, "mul_inferred", "product_o"),
            Subject::Divided(function, form) => {
                let sides = in_form(f, function, form)?.into_iter().zip(["ours", "expected"]);
                let instance = |(module, result): (Arc<Module>, &str)| {
                    let connected = module.inputs().iter().map(|port| match port.name.as_str() {
                        "a_i" => ".a_i(a), ".to_string(),
                        "b_i" => ".b_i(b), ".to_string(),
                        state => format!(".{state}({state}), "),
                    });
                    let connected: String = connected.collect();
                    format!("{} u_{result} ({connected}.result_o({result}));", module.name())
                };
                sides.map(instance).collect::<Vec<_>>().join("\n")
            }
        })
    }
}

/// What begins the names of inputs for the first values of registers.
const STATE: &str = "state_";

/// A divider or square root in a form, as combinational logic, and the combinational unit.
fn in_form(format: Format, function: DivSqrt, form: Form) -> Result<[Arc<Module>; 2], raypath_hdl::Error> {
    let ours = match form {
        Form::Parts(count) => chain(&function.parts(format, count)?)?,
        Form::Iterative(digits) => {
            unrolled(&function.iterative(format, digits, 0)?, DivSqrt::iterative_latency(format, digits))?
        }
    };
    Ok([ours, function.parts(format, 1)?.remove(0)])
}

/// Fewer cells than the smallest reference has: several hundred, at (3,3). An empty reference would prove anything.
const MIN_CELLS: u32 = 100;

impl fmt::Display for Claim {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.subject {
            Subject::Add => f.write_str("addition"),
            Subject::Sub => f.write_str("subtraction"),
            Subject::Mul => f.write_str("multiplication"),
            Subject::MulInferred => f.write_str("multiplication with *"),
            Subject::Compare => f.write_str("comparison"),
            Subject::RoundTrip => f.write_str("encoding and decoding"),
            Subject::Div => f.write_str("division"),
            Subject::Sqrt => f.write_str("square root"),
            Subject::Divided(function, form) => {
                f.write_str(if function == DivSqrt::Root { "the square root" } else { "the divider" })?;
                match form {
                    Form::Parts(count) => write!(f, " in {count} parts"),
                    Form::Iterative(1) => f.write_str(" with a digit a cycle"),
                    Form::Iterative(digits) => write!(f, " with {digits} digits a cycle"),
                }
            }
            Subject::ShortProduct(to) => {
                write!(f, "multiplication of {} bits rounded {} zero", to.bits, short::direction(to))
            }
            Subject::Shortening(to @ Narrow { bits, margin, .. }) => {
                write!(f, "rounding {} zero to {bits} bits", short::direction(to))?;
                if margin > 0 { write!(f, " with a margin of {margin}") } else { Ok(()) }
            }
            Subject::Sum(terms) => write!(f, "sums of {terms} terms"),
            Subject::AddParts(count) => write!(f, "the adder in {count} parts"),
            Subject::MulParts(count) => write!(f, "the multiplier in {count} parts"),
            Subject::MulInferredParts(count) => write!(f, "the multiplier with * in {count} parts"),
        }?;
        write!(f, " at ({},{})", self.format.exponent(), self.format.significand())?;
        match self.operands {
            Operands::All => Ok(()),
            Operands::Apart { least, first: true } => write!(f, ", first exponent larger by {least} or more"),
            Operands::Apart { least, first: false } => write!(f, ", second exponent larger by {least} or more"),
            Operands::ExponentDifference(difference) => write!(f, ", exponents {difference} apart"),
        }
    }
}
