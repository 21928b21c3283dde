//! Floating-point units as functions that may be any: what is known of them are the laws that other proofs show.

use super::conversion::{Conversion, direction_name};
use super::design::{Design, UnitModule};
use super::script::{Script, Term};
use raypath_float::Format;
use raypath_ops::{Narrowing, RESIDUE_BITS};
use std::collections::BTreeMap;

/// The units of a design.
#[derive(Clone, Copy)]
pub(super) struct Units<'d> {
    pub design: &'d Design,
    pub format: Format,
    /// The registers between the stages hold numbers in the layout of IEEE 754.
    pub ieee_registers: bool,
    /// Whether to state what units do with NaNs and infinities. It matters if the design reads signs at the ports
    /// before it encodes, where a NaN may have another sign than the word that the encoder writes; and if a fault
    /// shows only there.
    pub states_classes: bool,
    /// NaNs at the ports have the sign 0.
    pub positive_nans: bool,
}

/// What the names of multipliers begin with.
const MULTIPLIERS: [&str; 3] = ["mul", "mul_inferred", "mul_dsp"];

/// The results of a unit of two operands.
pub(super) struct Results {
    pub number: Term,
    pub exceptions: Option<Term>,
}

impl Units<'_> {
    /// A sum or a product. The order of the operands does not matter, and a multiplier with a residue has the products of
    /// the others.
    pub fn binary(&self, script: &mut Script, stem: &str, a: Term, b: Term, output: &str) -> Results {
        let orders = [[("a", a), ("b", b)], [("a", b), ("b", a)]];
        let commutative = |script: &mut Script, output: &str| {
            let [result, exchanged] = orders.map(|operands| self.apply(script, stem, &operands, output));
            let (result, exchanged) = result.zip(exchanged)?;
            script.assume(&format!("(= {result} {exchanged})"));
            Some(result)
        };
        let number = commutative(script, output).unwrap_or_else(|| script.free(self.format.recoded_width()));
        let exceptions = commutative(script, "flags");
        if stem == "mul" {
            for (multiplier, operands) in MULTIPLIERS.iter().flat_map(|multiplier| orders.map(|of| (multiplier, of))) {
                if let Some(same) = self.apply(script, &format!("{multiplier}_residue"), &operands, output) {
                    script.assume(&format!("(= {same} {number})"));
                }
            }
        }
        self.is_canonical(script, number);
        self.keeps_nan(script, &[a, b], number);
        Results { number, exceptions }
    }

    /// The residue of a product.
    pub fn residue(&self, script: &mut Script, a: Term, b: Term) -> Term {
        for stem in MULTIPLIERS.map(|multiplier| format!("{multiplier}_residue")) {
            if let Some(residue) = self.apply(script, &stem, &[("a", a), ("b", b)], "residue") {
                let exchanged = self.apply(script, &stem, &[("a", b), ("b", a)], "residue");
                exchanged.into_iter().for_each(|other| script.assume(&format!("(= {residue} {other})")));
                return residue;
            }
        }
        script.free(RESIDUE_BITS)
    }

    /// The result of a unit of one operand, a short number with zeros below.
    pub fn converted(&self, script: &mut Script, conversion: Conversion, operand: Term) -> Term {
        let name = conversion.module(self.format);
        let (port_in, port_out) = conversion.ports();
        let result = self.chain(script, &self.modules(&[name]), &[(port_in, operand)], port_out);
        let Some(result) = result else {
            let result = conversion.definition(script, self.format, operand);
            self.is_kept(script, result);
            return result;
        };
        let result = self.padded(script, result);
        if matches!(conversion, Conversion::Narrow(_)) && self.ieee_registers {
            let [operand, can_be_stored] = [self.canonical(script, operand), self.can_be_stored(script, result)];
            script.assume(&format!("(=> {operand} {can_be_stored})"));
        }
        self.is_kept(script, result);
        result
    }

    /// What is known of a multiplier of short numbers: its product is that of the full multiplier, rounded.
    pub fn narrow_product(&self, script: &mut Script, (a, b): (Term, Term), to: Narrowing, rounded: Term) {
        let dropped = self.format.significand() - to.bits;
        let short = [a, b].map(|operand| script.slice(operand, operand.width - 1, dropped));
        let stem = format!("raypath_fp_mul_{}_s{1}_s{1}_{2}", self.layout(), to.bits, direction_name(to.direction));
        let modules = self.modules(&[stem]);
        for [a, b] in [short, [short[1], short[0]]] {
            if let Some(product) = self.chain(script, &modules, &[("a", a), ("b", b)], "product") {
                let product = self.padded(script, product);
                script.assume(&format!("(= {product} {rounded})"));
            }
        }
    }

    /// What is known of a multiplier by a short factor of `bits` bits, `b`: its product is that of the full one.
    pub fn product_by_short(&self, script: &mut Script, a: Term, (b, bits): (Term, u32), product: Term) {
        let layout = self.layout();
        let stems = MULTIPLIERS.map(|unit| format!("raypath_fp_{unit}_{layout}_by_s{bits}"));
        let modules = self.modules(&stems);
        let short = script.slice(b, b.width - 1, self.format.significand() - bits);
        if let Some(by_short) = self.chain(script, &modules, &[("a", a), ("b", short)], "product") {
            script.assume(&format!("(= {by_short} {product})"));
        }
    }

    /// The results of a comparison: less, equal, unordered. The unit reads `bits` bits of the significands, if there is
    /// such a unit.
    pub fn compare(&self, script: &mut Script, a: Term, b: Term, bits: u32) -> [Term; 3] {
        let dropped = self.format.significand() - bits;
        let narrow = self.modules(&[format!("raypath_fp_compare_e{}s{bits}", self.format.exponent())]);
        let is_short = !narrow.is_empty() && dropped > 0;
        let (modules, [a, b]) = match is_short {
            true => (narrow, [a, b].map(|operand| script.slice(operand, operand.width - 1, dropped))),
            false => (self.named("compare"), [a, b]),
        };
        let results = self.compared(script, &modules, a, b);
        if is_short {
            // A full comparison of short numbers gives the same.
            let zeros = script.constant(dropped, 0);
            let full = [a, b].map(|short| script.operator(short.width + dropped, "concat", &[short, zeros]));
            let full = self.compared(script, &self.named("compare"), full[0], full[1]);
            for (full, short) in full.into_iter().zip(results) {
                script.assume(&format!("(= {full} {short})"));
            }
        }
        if self.states_classes {
            let [a_is_nan, b_is_nan] = [a, b].map(|operand| is_nan(script, operand));
            let [less, equal, unordered] = results;
            script.assume(&format!("(=> (or {a_is_nan} {b_is_nan}) (= (concat {less} {equal} {unordered}) #b001))"));
            let [a_sign_and_class, b_sign_and_class] =
                [a, b].map(|operand| script.slice(operand, operand.width - 1, operand.width - 4));
            script.assume(&format!(
                "(=> (or (= {a_sign_and_class} #b0110) (= {b_sign_and_class} #b1110)) (= {less} #b0))"
            ));
        }
        results
    }

    /// The outputs of a comparison.
    fn compared(&self, script: &mut Script, modules: &[(&str, &UnitModule)], a: Term, b: Term) -> [Term; 3] {
        ["less", "equal", "unordered"].map(|output| {
            let result = self.chain(script, modules, &[("a", a), ("b", b)], output);
            result.unwrap_or_else(|| script.free(1))
        })
    }

    /// A sum that rounds once.
    pub fn sum(&self, script: &mut Script, terms: &[Term]) -> Term {
        let names: Vec<String> = (0..terms.len()).map(|number| format!("x_{number}")).collect();
        let operands: Vec<(&str, Term)> = names.iter().map(String::as_str).zip(terms.iter().copied()).collect();
        let sum = self.apply(script, &format!("sum_{}", terms.len()), &operands, "sum");
        let sum = sum.unwrap_or_else(|| script.free(self.format.recoded_width()));
        self.is_canonical(script, sum);
        self.keeps_nan(script, terms, sum);
        sum
    }

    /// The number at a port, recoded.
    pub fn encoded(&self, script: &mut Script, value: Term) -> Term {
        if value.width == self.format.recoded_width() {
            if self.ieee_registers {
                self.is_canonical(script, value);
            }
            return value;
        }
        let encoded = self.apply(script, "encode", &[("ieee", value)], "recoded");
        let encoded = encoded.unwrap_or_else(|| script.free(self.format.recoded_width()));
        self.is_canonical(script, encoded);
        let alike = self.alike(script, value, encoded);
        script.assume(&alike);
        encoded
    }

    /// A recoded number of `bits` bits as it is at a port of this width. A decoder of short numbers gives what the full
    /// one does, without the zeros below.
    pub fn decoded(&self, script: &mut Script, value: Term, bits: u32, width: u32) -> Term {
        if value.width == width {
            return value;
        }
        let decoded = self.apply(script, "decode", &[("recoded", value)], "ieee");
        let decoded = decoded.unwrap_or_else(|| script.free(width));
        let dropped = self.format.significand() - bits;
        let modules = if dropped > 0 { self.modules(&[self.short_decoder(bits)]) } else { Vec::new() };
        let short = script.slice(value, value.width - 1, dropped);
        if let Some(short) = self.chain(script, &modules, &[("recoded", short)], "ieee") {
            let zeros = script.constant(dropped, 0);
            script.assume(&format!("(= {decoded} (concat {short} {zeros}))"));
        }
        decoded
    }

    /// What is known of a number of `bits` bits: a register in the layout of IEEE 754 can have a decoder of short
    /// numbers, which gives what the full one does.
    pub fn is_short(&self, script: &mut Script, number: Term, bits: u32) {
        if self.ieee_registers {
            let decoders =
                (bits..self.format.significand()).filter(|bits| !self.modules(&[self.short_decoder(*bits)]).is_empty());
            for bits in decoders {
                self.decoded(script, number, bits, self.format.ieee_width());
            }
        }
    }

    /// The name of the decoder of numbers of so many bits.
    fn short_decoder(&self, bits: u32) -> String {
        format!("raypath_fp_decode_e{}s{bits}", self.format.exponent())
    }

    /// What is known of the conversions of a constant.
    pub fn is_constant(&self, script: &mut Script, recoded: Term, ieee: u64) {
        if self.ieee_registers {
            let ieee = script.constant(self.format.ieee_width(), ieee);
            for (stem, operand, output, result) in
                [("encode", ("ieee", ieee), "recoded", recoded), ("decode", ("recoded", recoded), "ieee", ieee)]
            {
                if let Some(converted) = self.apply(script, stem, &[operand], output) {
                    script.assume(&format!("(= {converted} {result})"));
                }
            }
        }
    }

    /// A short number with zeros below.
    pub fn padded(&self, script: &mut Script, value: Term) -> Term {
        match self.format.recoded_width() - value.width {
            0 => value,
            missing => {
                let zeros = script.constant(missing, 0);
                script.operator(value.width + missing, "concat", &[value, zeros])
            }
        }
    }

    /// What is known of a result: it is one of the words that the recoded format writes
    /// (docs/reference/formats.md), and a register in the layout of IEEE 754 keeps it.
    pub fn is_canonical(&self, script: &mut Script, result: Term) {
        let canonical = self.canonical(script, result);
        script.assume(&canonical);
        if self.ieee_registers {
            let kept = self.kept(script, result);
            script.assume(&kept);
        }
    }

    /// What is known of any number: a register in the layout of IEEE 754 keeps it if it can be stored.
    fn is_kept(&self, script: &mut Script, number: Term) {
        if self.ieee_registers {
            let [can_be_stored, kept] = [self.can_be_stored(script, number), self.kept(script, number)];
            script.assume(&format!("(=> {can_be_stored} {kept})"));
        }
    }

    /// Whether a number that is decoded and encoded again is what it was, with its sign and class, as a condition.
    fn kept(&self, script: &mut Script, number: Term) -> String {
        let ieee = self.decoded(script, number, self.format.significand(), self.format.ieee_width());
        let again = self.apply(script, "encode", &[("ieee", ieee)], "recoded").unwrap_or(number);
        let alike = self.alike(script, ieee, number);
        let [ieee_sign, sign] = [ieee, number].map(|term| script.slice(term, term.width - 1, term.width - 1));
        format!("(and (= {again} {number}) {alike} (= {ieee_sign} {sign}))")
    }

    /// Whether a number is one of the words that the recoded format writes, as a condition.
    fn canonical(&self, script: &mut Script, number: Term) -> String {
        let (exponent, fraction, width) = (self.format.exponent(), self.format.fraction_width(), number.width);
        let class = script.slice(number, width - 2, width - 4);
        let magnitude = script.slice(number, width - 2, 0);
        // The least and the greatest finite magnitude, infinity, NaN.
        let least = (1_u64 << exponent) + 2 - (1 << (exponent - 1)) - u64::from(fraction);
        let greatest = (((1_u64 << exponent) + (1 << (exponent - 1))) << fraction) - 1;
        let infinity = 0b110_u64 << (exponent - 2 + fraction);
        let nan = (0b111_u64 << (exponent - 2 + fraction)) | (1 << (fraction - 1));
        let [zero, least, greatest, infinity, nan] =
            [0, least << fraction, greatest, infinity, nan].map(|value| script.constant(width - 1, value));
        let sign = script.slice(number, width - 1, width - 1);
        format!(
            "(or (= {magnitude} {zero}) (= {magnitude} {infinity}) (and (= {magnitude} {nan}) (= {sign} #b0)) \
             (and (bvuge {magnitude} {least}) (bvule {magnitude} {greatest}) (distinct {class} #b000)))"
        )
    }

    /// Whether the recoded format writes a number and it is not subnormal, as a condition.
    pub fn can_be_stored(&self, script: &mut Script, number: Term) -> String {
        let canonical = self.canonical(script, number);
        let magnitude = script.slice(number, number.width - 2, 0);
        let (exponent, fraction) = (self.format.exponent(), self.format.fraction_width());
        let least = ((1_u64 << exponent) + 2 - (1 << (exponent - 1))) << fraction;
        let [zero, least] = [0, least].map(|value| script.constant(magnitude.width, value));
        format!("(and {canonical} (or (= {magnitude} {zero}) (bvuge {magnitude} {least})))")
    }

    /// The result is NaN if an operand is.
    fn keeps_nan(&self, script: &mut Script, operands: &[Term], result: Term) {
        if self.states_classes {
            for &operand in operands {
                let [operand, result] = [operand, result].map(|term| is_nan(script, term));
                script.assume(&format!("(=> {operand} {result})"));
            }
        }
    }

    /// Whether a number in the layout of IEEE 754 and recoded has the same class and, unless it is NaN, the same sign.
    fn alike(&self, script: &mut Script, ieee: Term, recoded: Term) -> String {
        let (fraction, width) = (self.format.fraction_width(), ieee.width);
        let [sign, magnitude] =
            [(width - 1, width - 1), (width - 2, 0)].map(|(high, low)| script.slice(ieee, high, low));
        let [recoded_sign, class] =
            [(width, width), (width - 1, width - 3)].map(|(high, low)| script.slice(recoded, high, low));
        let infinity = script.constant(width - 1, ((1_u64 << self.format.exponent()) - 1) << fraction);
        let zero = script.constant(width - 1, 0);
        let nan = if self.positive_nans {
            format!("(=> (= {class} #b111) (and (= {sign} #b0) (= {recoded_sign} #b0)))")
        } else {
            "true".to_string()
        };
        format!(
            "(and (= (= {magnitude} {zero}) (= {class} #b000)) (= (bvugt {magnitude} {infinity}) (= {class} #b111)) \
             (or (= {class} #b111) (= {sign} {recoded_sign})) {nan})"
        )
    }

    /// An output of the unit with this name; none if the design has no such unit.
    fn apply(&self, script: &mut Script, stem: &str, operands: &[(&str, Term)], output: &str) -> Option<Term> {
        self.chain(script, &self.named(stem), operands, output)
    }

    /// An output of the parts of a unit: what leaves a part by some name enters the next by the same name.
    fn chain(
        &self,
        script: &mut Script,
        parts: &[(&str, &UnitModule)],
        operands: &[(&str, Term)],
        output: &str,
    ) -> Option<Term> {
        let mut values: Vec<(String, Term)> = operands.iter().map(|(name, term)| (name.to_string(), *term)).collect();
        for (module, ports) in parts {
            let find = |name: &str| values.iter().rev().find(|(known, _)| known == name).map(|(_, term)| *term);
            let mut outputs: Vec<(String, Term)> = Vec::new();
            for (name, width) in &ports.outputs {
                let operands = ports.operands(name).map(find).collect::<Option<Vec<Term>>>()?;
                outputs.push((name.clone(), unit_output(script, module, name, &operands, *width)));
            }
            values.extend(outputs);
        }
        let is_operand = |index: usize| index < operands.len();
        values
            .iter()
            .enumerate()
            .rev()
            .find(|(index, (name, _))| name == output && !is_operand(*index))
            .map(|(_, (_, term))| *term)
    }

    /// The modules of a unit of the format, whole or in parts.
    fn named(&self, stem: &str) -> Vec<(&str, &UnitModule)> {
        let layout = self.layout();
        let variants = ["", "_flags", "_inferred", "_inferred_flags", "_dsp", "_dsp_flags"];
        self.modules(&variants.map(|variant| format!("raypath_fp_{stem}{variant}_{layout}")))
    }

    /// The modules of units with these names, whole or in parts, which come in their order.
    fn modules(&self, names: &[String]) -> Vec<(&str, &UnitModule)> {
        let all = self.design.modules.iter().filter_map(|(name, ports)| {
            let (unit, part) = name.split_once("_part_").unwrap_or((name, "1_of_1"));
            let number: u32 = part.split_once('_')?.0.parse().ok()?;
            names.iter().any(|name| name == unit).then_some(((unit, number), (name.as_str(), ports)))
        });
        all.collect::<BTreeMap<_, _>>().into_values().collect()
    }

    fn layout(&self) -> String {
        format!("e{}s{}", self.format.exponent(), self.format.significand())
    }
}

/// An output of a unit.
///
/// The order of the terms does not matter to a sum that rounds once. Here it does not matter to the first part, from
/// whose outputs only the next parts read: as these may be any functions, the parts together can still be any sum.
pub(super) fn unit_output(script: &mut Script, module: &str, output: &str, operands: &[Term], width: u32) -> Term {
    let name = format!("{module}.{output}");
    let is_first = !module.contains("_part_") || module.contains("_part_1_of_");
    match module.starts_with("raypath_fp_sum_") && is_first {
        true => script.apply_to_all(module, &name, operands, width),
        false => script.apply(&name, operands, width),
    }
}

/// Whether a recoded number is NaN, as a condition.
fn is_nan(script: &mut Script, number: Term) -> String {
    let class = script.slice(number, number.width - 2, number.width - 4);
    format!("(= {class} #b111)")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_unit_come_in_their_order() {
        let mut design = Design::default();
        let names = (1..=10).map(|part| format!("raypath_fp_add_e8s24_part_{part}_of_10"));
        let names: Vec<String> = names.chain(["raypath_fp_add_residue_e8s24".to_string()]).collect();
        design.modules.extend(names.iter().map(|name| (name.clone(), UnitModule::default())));
        let format = Format::BINARY32;
        let units =
            Units { design: &design, format, ieee_registers: false, states_classes: false, positive_nans: false };
        let found: Vec<&str> = units.named("add").into_iter().map(|(name, _)| name).collect();
        assert_eq!(found, names[..10]);
    }
}
