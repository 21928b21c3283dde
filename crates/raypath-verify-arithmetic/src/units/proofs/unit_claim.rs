//! What is claimed of the units.
//!
//! Units compute with recoded numbers. A number of IEEE 754 has one canonical word, which the encoder gives. For all
//! operands a unit gives the canonical word of the result of IEEE 754: `unit(encode(a), encode(b))` is
//! `encode(a op b)`, where Yosys's command `symfpu` generates the operation. So the words between units are canonical
//! if those at the inputs are, and what a pipeline of units computes is what the operations compute.

use super::claim::{Claim, instance, texts};
use super::digits::{begins_digits, rounds_digits};
use super::words::{canonical_form, encoders, is_canonical, is_nan};
use super::{short, sum};
use crate::units::bench::{chain, unrolled};
use raypath_float::{
    DivSqrt, Format, Narrow, compare, compare_narrow, decode, decode_narrow, encode, mul_narrow, narrow, sum,
};
use raypath_hdl::Module;
use raypath_rtl::{Microarchitecture, Multiplier, UnitLatency};
use raypath_verify::Error;
use std::sync::Arc;

/// A unit of one operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// The adder.
    Add,
    /// The multiplier of gates.
    Mul,
    /// The multiplier with `*`.
    MulInferred,
    /// The multiplier that adds products of at most 18 by 18 bits.
    MulDsp,
    /// The combinational divider.
    Div,
    /// The combinational square root.
    Sqrt,
}

/// The operands of a claim about two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operands {
    /// All pairs.
    All,
    /// Those with this difference of biased exponents: the first minus the second.
    Difference(i64),
    /// Those of which the first has a biased exponent that is larger by this or more.
    FirstLarger(u32),
    /// Those of which the second has.
    SecondLarger(u32),
}

/// What a claim is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnitClaim {
    /// A unit gives the canonical word of IEEE 754's result for canonical words; an adder also its exceptions.
    Rounds(Unit, Operands),
    /// A unit in parts gives the words of the whole one, for all words.
    Parts(Unit, u32),
    /// A unit with flags gives the words of the one without, for all words.
    WithFlags(Unit),
    /// A divider or square root with this many digits a cycle gives the words of the combinational one, from any idle
    /// state.
    Iterative(DivSqrt, u32),
    /// The part of a divider or square root that rounds gives canonical words, for all digits that begin with a 1 in
    /// one of two places and exponents in range, or a settled class.
    RoundsDigits(DivSqrt),
    /// The part with the first digits gives such digits, exponents and classes for canonical words.
    BeginsDigits(DivSqrt),
    /// For words of the classes zero, infinity and NaN, the adder's result depends on the class only, and on the sign
    /// of zeros and infinities.
    AddsIgnoredBits,
    /// The same of the comparator.
    ComparesIgnoredBits,
    /// The same of the multiplier, by the products of zeros, infinities and NaN.
    MultipliesIgnoredBits,
    /// The comparator behind encoders.
    Compares,
    /// The encoder gives canonical words.
    Encodes,
    /// The encoder and then the decoder: every number is unchanged, and every NaN becomes the canonical one.
    RoundTrip,
    /// The decoder and then the encoder: canonical words are unchanged, and all others of the classes zero, infinity
    /// and NaN become canonical.
    Canonises,
    /// The multiplier of short numbers, whose product is rounded to the format and then in one direction, so that it is
    /// as short as they are.
    ShortProduct(Narrow),
    /// Such a multiplier in parts gives the words of the whole one, for all words.
    ShortProductParts(Narrow, u32),
    /// The rounding to a shorter significand in one direction.
    Shortening(Narrow),
    /// The comparator of numbers with so many bits gives the result of the other for them, for all words.
    ComparesShort(u32),
    /// The decoder of numbers with so many bits gives the upper bits of the other's result, for words that are special
    /// or in the normal range.
    DecodesShort(u32),
    /// The sum of this many terms rounds once, as docs/reference/semantics.md defines.
    Sum(u32),
}

impl Unit {
    /// The unit in parts.
    fn parts(self, f: Format, count: u32, with_flags: bool) -> Result<Vec<Arc<Module>>, raypath_hdl::Error> {
        match self {
            Self::Add => built(count, Multiplier::Booth).adder_parts(f, with_flags),
            Self::Mul => built(count, Multiplier::Booth).multiplier_parts(f, with_flags),
            Self::MulInferred => built(count, Multiplier::Inferred).multiplier_parts(f, with_flags),
            Self::MulDsp => built(count, Multiplier::Dsp).multiplier_parts(f, with_flags),
            Self::Div => DivSqrt::Quotient.parts(f, count),
            Self::Sqrt => DivSqrt::Root.parts(f, count),
        }
    }

    /// The unit in one module.
    fn whole(self, f: Format, with_flags: bool) -> Result<Arc<Module>, raypath_hdl::Error> {
        Ok(self.parts(f, 1, with_flags)?.remove(0))
    }

    /// The operation in `symfpu`, a deliberate fault, and the name in messages.
    fn description(self) -> (&'static str, (&'static str, &'static str), &'static str) {
        const PRODUCT: (&str, &str) = (" < MinExpSum", " <= MinExpSum");
        match self {
            Self::Add => ("add", ("~(half & quarter)", "~(half | quarter)"), "addition"),
            Self::Mul => ("mul", PRODUCT, "multiplication"),
            Self::MulInferred => ("mul", PRODUCT, "multiplication with *"),
            Self::MulDsp => ("mul", PRODUCT, "multiplication in DSP blocks"),
            Self::Div => ("div", ROUNDING_FAULT, "division"),
            Self::Sqrt => ("sqrt", ROUNDING_FAULT, "square root"),
        }
    }
}

/// A datapath whose units have so many steps.
fn built(steps: u32, multiplier: Multiplier) -> Microarchitecture {
    let unit_latency = UnitLatency { sums: steps, products: steps };
    Microarchitecture { unit_latency, multiplier, ..Microarchitecture::DEFAULT }
}

const ROUNDING_FAULT: (&str, &str) = ("below_half)) | sticky", "below_half)) & sticky");

impl UnitClaim {
    /// The claim in a format.
    ///
    /// # Errors
    /// The unit cannot be built.
    pub fn claim(self, f: Format) -> Result<Claim, Error> {
        let (ieee, recoded) = (f.ieee_width(), f.recoded_width());
        let named = |name: &str| format!("{name} at ({},{})", f.exponent(), f.significand());
        let conversions = || texts([&encode(f)?, &decode(f)?]);
        let any = "assign valid = 1;\n";
        let claim = match self {
            Self::Rounds(unit, operands) => rounds(f, unit, operands)?,
            Self::Parts(unit, count) => {
                let (_, fault, name) = unit.description();
                let sides = [unit.whole(f, false)?, chain(&unit.parts(f, count, false)?)?];
                Claim { name: format!("{name} in {count} parts"), fault, ..alike(&sides)? }
            }
            Self::WithFlags(unit) => {
                let (_, fault, name) = unit.description();
                let sides = [unit.whole(f, true)?, unit.whole(f, false)?];
                Claim { name: format!("{name} with flags"), fault, ..alike(&sides)? }
            }
            Self::Iterative(function, digits) => {
                let unit = function.iterative(f, digits, 0)?;
                let ours = unrolled(&unit, DivSqrt::iterative_latency(f, digits))?;
                let name = if function == DivSqrt::Root { "square root" } else { "division" };
                let name = format!("{name} with {digits} digits a cycle");
                Claim { name, fault: ROUNDING_FAULT, ..alike(&[ours, function.parts(f, 1)?.remove(0)])? }
            }
            Self::RoundsDigits(function) => rounds_digits(f, function)?,
            Self::BeginsDigits(function) => begins_digits(f, function)?,
            Self::AddsIgnoredBits => Claim {
                name: "ignored bits in addition".to_string(),
                fault: ("~special_sum & ~nan_or_zero_sum", "~nan_or_zero_sum"),
                ..ignored_bits(f, &Unit::Add.whole(f, false)?)?
            },
            Self::MultipliesIgnoredBits => {
                let (sign, zeros) = (recoded - 1, recoded - 4);
                let product = format!(
                    "raypath_fp_mul_{f} u_unit (.a_i(a), .b_i(b), .product_o(ours));\n\
                     wire nan = class_a == 7 || class_b == 7 ||\n\
                     class_a == 0 && class_b == 6 || class_a == 6 && class_b == 0;\n\
                     wire infinite = class_a == 6 || class_b == 6;\n\
                     assign expected = nan ? {{1'b0, 3'd7, {zeros}'d{}}} :\n\
                     {{a[{sign}] ^ b[{sign}], infinite ? 3'd6 : 3'd0, {zeros}'d0}};\n\
                     assign valid = special_a || special_b;\n",
                    1_u64 << (f.significand() - 2),
                );
                Claim {
                    name: "ignored bits in multiplication".to_string(),
                    unit: texts([&Unit::Mul.whole(f, false)?])?,
                    inputs: ["a", "b"].map(|name| (name.to_string(), recoded)).into(),
                    width: recoded,
                    body: canonical_form(f, "a") + &canonical_form(f, "b") + &product,
                    fault: ("settled ? {{2{special}}", "special ? {{2{special}}"),
                    ..Claim::default()
                }
            }
            Self::ComparesIgnoredBits => Claim {
                name: "ignored bits in comparison".to_string(),
                fault: ("equal | both_zero", "equal"),
                ..ignored_bits(f, &compare(f)?)?
            },
            Self::Compares => {
                let nan = |word| is_nan(f, word);
                Claim {
                    name: "comparison".to_string(),
                    unit: texts([&compare(f)?])?,
                    rest: texts([&encode(f)?])?,
                    inputs: [("a".to_string(), ieee), ("b".to_string(), ieee)].into(),
                    width: 3,
                    body: encoders(f, &["a", "b"])
                        + &format!(
                            "raypath_fp_compare_{f} u_unit (.a_i(recoded_a), .b_i(recoded_b), .less_o(ours[2]), \
                             .equal_o(ours[1]), .unordered_o(ours[0]));\n\
                             symfpu u_reference (.a(a), .b(b), .lessThan(expected[2]), .ieee754Equal(expected[1]));\n\
                             assign expected[0] = {} || {};\n{any}",
                            nan("a"),
                            nan("b")
                        ),
                    reference: Some(format!("-eb {} -sb {} -compare", f.exponent(), f.significand())),
                    fault: ("a_negative & ~both_zero", "a_negative"),
                    ..Claim::default()
                }
            }
            Self::Encodes => Claim {
                name: "canonical words of the encoder".to_string(),
                unit: texts([&encode(f)?])?,
                inputs: [("a".to_string(), ieee)].into(),
                width: recoded,
                body: encoders(f, &["a"])
                    + &is_canonical(f, "recoded_a")
                    + &format!(
                        "assign ours = recoded_a;\n\
                         assign expected = canonical_recoded_a ? recoded_a : ~recoded_a;\n{any}"
                    ),
                fault: ("exponent & {", "exponent | {"),
                ..Claim::default()
            },
            Self::RoundTrip => Claim {
                name: "encoding and decoding".to_string(),
                unit: texts([&decode(f)?])?,
                rest: texts([&encode(f)?])?,
                inputs: [("a".to_string(), ieee)].into(),
                width: ieee,
                body: encoders(f, &["a"])
                    + &format!(
                        "raypath_fp_decode_{f} u_decode (.recoded_i(recoded_a), .ieee_o(ours));\n\
                         assign expected = {} ? {ieee}'d{} : a;\n{any}",
                        is_nan(f, "a"),
                        f.nan()
                    ),
                fault: ("exponent < ", "exponent <= "),
                ..Claim::default()
            },
            Self::Canonises => Claim {
                name: "decoding and encoding".to_string(),
                unit: conversions()?,
                inputs: [("a".to_string(), recoded)].into(),
                width: recoded,
                body: is_canonical(f, "a")
                    + &canonical_form(f, "a")
                    + &format!(
                        "wire [{}:0] ieee;\n\
                         raypath_fp_decode_{f} u_decode (.recoded_i(a), .ieee_o(ieee));\n\
                         raypath_fp_encode_{f} u_encode (.ieee_i(ieee), .recoded_o(ours));\n\
                         assign expected = form_a;\nassign valid = canonical_a || special_a;\n",
                        ieee - 1
                    ),
                fault: ("exponent < ", "exponent <= "),
                ..Claim::default()
            },
            Self::ShortProduct(to) => {
                let (unit, short) = (mul_narrow(f, to.bits, to)?, f.narrowed(to.bits)?);
                let is_exact = 2 * to.bits <= f.significand();
                let significand = if is_exact { to.bits } else { f.significand() };
                let mode = if !is_exact { "RNE" } else { [&"RTZ", &"DYN"][usize::from(to.away)] };
                Claim {
                    name: format!("multiplication of {} bits rounded {} zero", to.bits, short::direction(to)),
                    unit: texts([&unit])?,
                    rest: texts([&encode(short)?])?,
                    inputs: ["a", "b"].map(|name| (name.to_string(), short.ieee_width())).into(),
                    width: short.recoded_width(),
                    body: short::product(f, to)? + any,
                    reference: Some(format!("-eb {} -sb {significand} -op mul -rm {mode}", f.exponent())),
                    fault: ("< LeastKept", "<= LeastKept"),
                    ..Claim::default()
                }
            }
            Self::ShortProductParts(to, count) => {
                let whole = mul_narrow(f, to.bits, to)?;
                let parts = built(count, Multiplier::Booth).divided(&whole, count)?;
                let sides = [whole, chain(&parts)?];
                let name = format!("multiplication of {} bits in {count} parts", to.bits);
                Claim { name, fault: ("< LeastKept", "<= LeastKept"), ..alike(&sides)? }
            }
            Self::ComparesShort(bits) => {
                let short = compare_narrow(f, bits)?;
                let lost = f.significand() - bits;
                let side = |module: &Arc<Module>, name: &str, padding: &str| {
                    instance(module, &format!("u_{name}"), |port| match port {
                        "less_o" => format!("{name}[2]"),
                        "equal_o" => format!("{name}[1]"),
                        "unordered_o" => format!("{name}[0]"),
                        operand => format!("{{{}{padding}}}", operand.trim_end_matches("_i")),
                    })
                };
                Claim {
                    name: format!("comparison of {bits} bits"),
                    unit: texts([&short])?,
                    rest: texts([&compare(f)?])?,
                    inputs: ["a", "b"].map(|name| (name.to_string(), recoded - lost)).into(),
                    width: 3,
                    body: side(&short, "ours", "") + &side(&compare(f)?, "expected", &format!(", {lost}'d0")) + any,
                    is_alike: true,
                    fault: ("a_negative & ~both_zero", "a_negative"),
                    ..Claim::default()
                }
            }
            Self::DecodesShort(bits) => {
                let (short, lost, normal) =
                    (decode_narrow(f, bits)?, f.significand() - bits, (1 << (f.exponent() - 1)) + 2);
                let wire = |port: &str| (if port.ends_with("_i") { "a" } else { "ours" }).to_string();
                Claim {
                    name: format!("decoding of {bits} bits"),
                    unit: texts([&short])?,
                    rest: texts([&decode(f)?])?,
                    inputs: [("a".to_string(), recoded - lost)].into(),
                    width: ieee - lost,
                    body: format!("wire [{}:0] padded = {{a, {lost}'d0}};\nwire [{}:0] ieee;\n", recoded - 1, ieee - 1)
                        + &canonical_form(f, "padded")
                        + &instance(&short, "u_unit", wire)
                        + &format!(
                            "raypath_fp_decode_{f} u_decode (.recoded_i(padded), .ieee_o(ieee));\n\
                             assign expected = ieee[{}:{lost}];\n\
                             assign valid = special_padded || padded[{}:{}] >= {normal};\n",
                            ieee - 1,
                            recoded - 2,
                            f.significand() - 1
                        ),
                    is_alike: true,
                    fault: ("~special", "special"),
                    ..Claim::default()
                }
            }
            Self::Shortening(to @ Narrow { bits, margin, away }) => {
                let short = f.narrowed(bits)?;
                Claim {
                    name: format!("rounding {} zero to {bits} bits with a margin of {margin}", short::direction(to)),
                    unit: texts([&narrow(f, to)?])?,
                    rest: texts([&encode(f)?, &encode(short)?])?,
                    inputs: [("a".to_string(), ieee)].into(),
                    width: short.recoded_width(),
                    body: short::shortening(f, to)? + any,
                    fault: if margin > 0 && !away { (" & ordinary", "") } else { ("< LeastKept", "<= LeastKept") },
                    ..Claim::default()
                }
            }
            Self::Sum(terms) => Claim {
                name: format!("sums of {terms} terms"),
                unit: texts([&sum(f, terms)?])?,
                rest: texts([&encode(f)?])?,
                inputs: [("a".to_string(), terms * ieee)].into(),
                width: recoded,
                body: sum::sides(f, terms) + any,
                fault: ("& (below_guard | ", "& (below_guard & "),
                ..Claim::default()
            },
        };
        Ok(Claim { name: named(&claim.name), ..claim })
    }
}

/// A unit between encoders, and the encoded result of `symfpu`.
fn rounds(f: Format, unit: Unit, operands: Operands) -> Result<Claim, Error> {
    let (operation, fault, name) = unit.description();
    let (e, s, ieee, recoded) = (f.exponent(), f.significand(), f.ieee_width(), f.recoded_width());
    let is_adder = unit == Unit::Add;
    let module = unit.whole(f, is_adder)?;
    let operand_names = if unit == Unit::Sqrt { &["a"][..] } else { &["a", "b"] };
    let word = |name: &str| (name.to_string(), ieee);
    let exponent = |name: &str| format!("{{1'b0, {name}[{}:{}]}}", e + s - 2, s - 1);
    let larger = |larger: &str, smaller: &str, least: u32| {
        let valid = format!("assign valid = {} >= {} + {}'d{least};\n", exponent(larger), exponent(smaller), e + 1);
        (vec![word("a"), word("b")], valid, format!(", {larger}'s exponent larger by {least} or more"))
    };
    let (inputs, setup, case) = match operands {
        Operands::All => {
            (operand_names.iter().map(|name| word(name)).collect(), "assign valid = 1;\n".to_string(), String::new())
        }
        Operands::FirstLarger(least) => larger("a", "b", least),
        Operands::SecondLarger(least) => larger("b", "a", least),
        Operands::Difference(difference) => {
            let setup = format!(
                "wire [{last}:0] a;\n\
                 wire [{top}:0] exponent = {{2'b00, b[{high}:{low}]}} + {0}'d{value};\n\
                 assign a = {{rest_of_a[{low}], exponent[{1}:0], rest_of_a[{2}:0]}};\n\
                 assign valid = exponent[{top}:{e}] == 0;\n",
                e + 2,
                e - 1,
                s - 2,
                last = ieee - 1,
                top = e + 1,
                high = e + s - 2,
                low = s - 1,
                value = difference.rem_euclid(1 << (e + 2)),
            );
            (vec![("rest_of_a".to_string(), s), word("b")], setup, format!(", exponents {difference} apart"))
        }
    };
    let connected = instance(&module, "u_unit", |port| match port {
        "a_i" => "recoded_a".to_string(),
        "b_i" => "recoded_b".to_string(),
        "flags_o" => format!("ours[{}:{recoded}]", recoded + 3),
        _ => format!("ours[{}:0]", recoded - 1),
    });
    let second = if operand_names.len() > 1 { ".b(b), " } else { "" };
    // No NaN is signalling, and a sum below the normal range is exact.
    let flags = format!(
        "assign expected[{}:{recoded}] = {{nv & ~{} & ~{}, of, 1'b0, nx}};\n",
        recoded + 3,
        is_nan(f, "a"),
        is_nan(f, "b")
    );
    let reference = format!(
        "wire [{}:0] result; wire nv, of, nx;\n\
         symfpu u_reference (.a(a), {second}.o(result), .NV(nv), .OF(of), .NX(nx));\n\
         raypath_fp_encode_{f} u_expected (.ieee_i(result), .recoded_o(expected[{}:0]));\n",
        ieee - 1,
        recoded - 1,
    );
    let body = [setup, encoders(f, operand_names), connected, reference];
    Ok(Claim {
        name: format!("{name}{case}"),
        unit: texts([&module])?,
        rest: texts([&encode(f)?])?,
        inputs,
        width: if is_adder { recoded + 4 } else { recoded },
        body: body.concat() + if is_adder { &flags } else { "" },
        reference: Some(format!("-eb {e} -sb {s} -op {operation} -rm RNE")),
        fault,
        ..Claim::default()
    })
}

/// Two modules with the same inputs and the same first output.
fn alike(sides: &[Arc<Module>; 2]) -> Result<Claim, Error> {
    let [ours, expected] = sides;
    let result = &expected.outputs()[0].name;
    let connected = |module: &Module, side: &str| {
        let wire = |port: &str| match port {
            port if port == result => side.to_string(),
            port if port.ends_with("_o") => String::new(),
            port => port.to_string(),
        };
        instance(module, &format!("u_{side}"), wire)
    };
    let names = ours.inputs().iter().map(|port| port.name.clone());
    Ok(Claim {
        unit: texts([ours])?,
        rest: texts([expected])?,
        inputs: names.map(|name| (name.clone(), ours.port_width(&name).unwrap_or_default())).collect(),
        width: ours.port_width(result).unwrap_or_default(),
        body: connected(ours, "ours") + &connected(expected, "expected") + "assign valid = 1;\n",
        is_alike: true,
        ..Claim::default()
    })
}

/// A unit on two words of which one is zero, infinite or NaN, and on their canonical forms.
fn ignored_bits(f: Format, unit: &Arc<Module>) -> Result<Claim, Error> {
    let outputs: Vec<(&str, u32)> =
        unit.outputs().iter().map(|port| (port.name.as_str(), unit.port_width(&port.name).unwrap_or(1))).collect();
    let side = |side: &str, operand: &str| {
        instance(unit, &format!("u_{side}"), |port| {
            let mut low = 0;
            for &(name, width) in &outputs {
                if name == port {
                    return format!("{side}[{}:{low}]", low + width - 1);
                }
                low += width;
            }
            format!("{operand}{}", port.trim_end_matches("_i"))
        })
    };
    Ok(Claim {
        unit: texts([unit])?,
        inputs: ["a", "b"].map(|name| (name.to_string(), f.recoded_width())).into(),
        width: outputs.iter().map(|(_, width)| width).sum(),
        body: [canonical_form(f, "a"), canonical_form(f, "b"), side("ours", ""), side("expected", "form_")].concat()
            + "assign valid = special_a || special_b;\n",
        is_alike: true,
        ..Claim::default()
    })
}
