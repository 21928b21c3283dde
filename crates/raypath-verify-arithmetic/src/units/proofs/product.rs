//! Lemmas that together state that a multiplier gives IEEE 754's product.
//!
//! With `M` and `N` for the significands of the operands as integers, and modulo 2 to the number of columns of their
//! product:
//!
//! 1. The reference multiplies `M` and `N`, unless an operand is zero, infinite or NaN.
//! 2. `multiplicand` is `M`, and `thrice` is `3 M`.
//! 3. Each row and its correction are a digit of `N` times `M`, plus a constant and the correction of the row above.
//! 4. Each row of full adders keeps the sum of its three rows.
//! 5. The product's upper bits, and whether a lower one is set, are those of the sum of the last two rows.
//! 6. With a free product in place of `M N` on both sides, the unit gives the canonical word of the reference's result,
//!    and its flags.
//!
//! From 3 and 4 [`derive_product`] derives that the sum of the last rows is `M N`. A multiplier with `*` has the lemmas
//! 1, 2 and 6, and one that states the operands of `*`.

use super::lemma::{Fault, Lemma, Signal, Text, is_chain};
use super::linear::{Equation, Sum, Term, derive_product, digit};
use raypath_float::{Format, Product, encode, mul, mul_by_short};
use raypath_hdl::verilog::text;
use raypath_verify::Error;
use std::fmt;

/// A multiplier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Multiplier {
    /// The format of the first operand and of the product.
    pub format: Format,
    /// Whether its text multiplies with `*`.
    pub inferred: bool,
    /// The bits of the second operand's significand, if they are fewer.
    pub short: Option<u32>,
    /// Whether it has the output `flags_o`.
    pub with_flags: bool,
}

impl fmt::Display for Multiplier {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("multiplication")?;
        if self.inferred {
            f.write_str(" with *")?;
        }
        if let Some(bits) = self.short {
            write!(f, " by {bits} bits")?;
        }
        write!(f, " at ({},{})", self.format.exponent(), self.format.significand())?;
        if self.with_flags { f.write_str(" with flags") } else { Ok(()) }
    }
}

/// Lemmas, and whether a multiplier's product follows from them; else why not.
type Theorem = (Vec<Lemma>, Result<(), String>);

/// A row to be added; its lowest bit is in column `low`.
#[derive(Clone)]
struct Row {
    signal: Signal,
    low: u32,
}

impl Multiplier {
    /// The lemmas about the unit's text, and whether its product follows from them; else why not.
    ///
    /// # Errors
    /// The unit cannot be built, or its text lacks a signal.
    pub fn theorem(self) -> Result<Theorem, Error> {
        let factor = self.format.narrowed(self.short.unwrap_or(self.format.significand()))?;
        let product = if self.inferred { Product::Inferred } else { Product::Booth };
        let unit = &match self.short {
            Some(bits) => mul_by_short(self.format, bits, product)?,
            None => mul(self.format, product, self.with_flags)?,
        };
        Unit { multiplier: self, factor, text: Text::new(unit.name(), text(unit)?) }.theorem()
    }
}

/// A multiplier's text.
struct Unit {
    multiplier: Multiplier,
    /// The format of the second operand.
    factor: Format,
    text: Text,
}

impl Unit {
    fn theorem(&self) -> Result<Theorem, Error> {
        let mut lemmas = vec![self.significand(0)?, self.significand(1)?];
        let follows = if self.multiplier.inferred {
            lemmas.extend([self.factors()?, self.operator()?]);
            Ok(())
        } else {
            lemmas.push(self.multiples()?);
            let (of_rows, follows) = self.rows()?;
            lemmas.extend(of_rows);
            follows
        };
        lemmas.push(self.rounding()?);
        let follows = follows.and_then(|()| is_chain(&lemmas, &self.text));
        Ok((lemmas, follows))
    }

    /// The bits of the significands.
    fn widths(&self) -> (u32, u32) {
        (self.multiplier.format.significand(), self.factor.significand())
    }

    fn columns(&self) -> u32 {
        let (s, n) = self.widths();
        s + n
    }

    /// A lemma about the unit without free inputs but the signals that it takes.
    fn lemma(&self, name: String, takes: Vec<Signal>, gives: Vec<Signal>, statement: String, fault: Fault) -> Lemma {
        Lemma {
            name,
            unit: self.text.clone(),
            free: takes.clone(),
            takes,
            gives,
            reference: Vec::new(),
            statement,
            rest: String::new(),
            faults: vec![fault],
        }
    }

    fn signals(&self, names: &[&str]) -> Result<Vec<Signal>, Error> {
        names.iter().map(|name| self.text.signal(name)).collect()
    }

    /// Commands for the reference, whose multiplication becomes an input and two outputs. With flags, also for the
    /// reference that rounds toward zero, `symfpu_truncated`.
    fn reference(&self, with_flags: bool) -> Vec<String> {
        let (e, s) = (self.multiplier.format.exponent(), self.multiplier.format.significand());
        let width = 2 * s;
        let multiplication = ["A", "B", "Y"].map(|port| format!("symfpu/r:{port}_WIDTH={width} %i"));
        let in_mode = |mode: &str| {
            [
                format!("symfpu -eb {e} -sb {s} -op mul -rm {mode}"),
                // Its assertions would become outputs.
                "chformal -remove".to_string(),
                "select -assert-count 1 symfpu/t:$mul".to_string(),
                format!("select -assert-count 1 symfpu/t:$mul {}", multiplication.join(" ")),
                "rename -enumerate -pattern product_% symfpu/t:$mul".to_string(),
                "expose -evert -sep _ symfpu/t:$mul".to_string(),
            ]
        };
        if !with_flags {
            return in_mode("RNE").into();
        }
        let truncated = in_mode("RTZ").into_iter().chain(["rename symfpu symfpu_truncated".to_string()]);
        truncated.chain(in_mode("RNE")).collect()
    }

    /// The operands in the layout of IEEE 754, as inputs.
    fn operands(&self) -> [Signal; 2] {
        [Signal::new("a", self.multiplier.format.ieee_width()), Signal::new("b", self.factor.ieee_width())]
    }

    /// Wires for the operands in the reference's format, and for whether they are zero, infinite or NaN.
    fn reference_operands(&self) -> String {
        let (s, n) = self.widths();
        let width = self.multiplier.format.ieee_width();
        let padding = if s > n { format!(", {}'d0", s - n) } else { String::new() };
        let is_special = |word: &str| format!("(&{word}[{}:{}] || ~|{word}[{}:0])", width - 2, s - 1, width - 2);
        format!(
            "wire [{0}:0] reference_a = a, reference_b = {{b{padding}}};\n\
             wire special_a = {1}, special_b = {2};\n",
            width - 1,
            is_special("reference_a"),
            is_special("reference_b"),
        )
    }

    /// Lemma 1, for one of the operands.
    fn significand(&self, operand: usize) -> Result<Lemma, Error> {
        let (s, n) = self.widths();
        let (name, port) = [("a", "A"), ("b", "B")][operand];
        let (format, bits) = [(self.multiplier.format, s), (self.factor, n)][operand];
        let module = encode(format)?;
        let unit = Text::new(module.name(), text(&module)?);
        let padding = if s > bits { format!(", {}'d0", s - bits) } else { String::new() };
        let statement = format!(
            "{}wire [{top}:0] found;\n\
             symfpu u_reference (.a(reference_a), .b(reference_b), .product_0_Y({width}'d0), .product_0_{port}(found));\n\
             assign ieee_i = {name};\n\
             assign differ = ~special_{name} && (found != {{{s}'d1, recoded_o[{}:0]{padding}}});",
            self.reference_operands(),
            bits - 2,
            top = 2 * s - 1,
            width = 2 * s,
            s = s + 1,
        );
        Ok(Lemma {
            name: format!("the significand of {name}"),
            takes: vec![unit.signal("ieee_i")?],
            gives: vec![unit.signal("recoded_o")?],
            unit,
            free: self.operands().into(),
            reference: self.reference(false),
            statement,
            rest: String::new(),
            faults: vec![Fault::new("empty_2", "~", "")],
        })
    }

    /// Lemma 2.
    fn multiples(&self) -> Result<Lemma, Error> {
        let (s, _) = self.widths();
        let statement = format!(
            "wire [{}:0] significand = {{1'b1, a_i[{}:0]}};\n\
             assign differ = multiplicand != significand || thrice != significand + (significand << 1);",
            s + 1,
            s - 2
        );
        let (takes, gives) = (self.signals(&["a_i"])?, self.signals(&["multiplicand", "thrice"])?);
        let fault = Fault::new("triple_above", " + ", " - ");
        Ok(self.lemma("multiples".to_string(), takes, gives, statement, fault))
    }

    /// Lemma 2 of a multiplier with `*`.
    fn factors(&self) -> Result<Lemma, Error> {
        let (s, n) = self.widths();
        let statement = format!(
            "assign differ = factor != {{1'b1, a_i[{}:0]}} || other_factor != {{1'b1, b_i[{}:0]}};",
            s - 2,
            n - 2
        );
        let (takes, gives) = (self.signals(&["a_i", "b_i"])?, self.signals(&["factor", "other_factor"])?);
        Ok(self.lemma("factors".to_string(), takes, gives, statement, Fault::new("factor", "1'b1", "1'b0")))
    }

    /// That a multiplier with `*` multiplies its factors.
    fn operator(&self) -> Result<Lemma, Error> {
        let (takes, gives) = (self.signals(&["factor", "other_factor"])?, self.signals(&["whole"])?);
        // As the text has it, so that Yosys merges the two before any proof.
        let statement = format!("assign differ = whole != {0}'(factor) * {0}'(other_factor);", self.columns());
        Ok(self.lemma("the operator *".to_string(), takes, gives, statement, Fault::new("whole", "*", "+")))
    }

    /// Lemmas 3 to 5, and whether the product follows from their equations.
    fn rows(&self) -> Result<(Vec<Lemma>, Result<(), String>), Error> {
        let (_, n) = self.widths();
        let mut lemmas = Vec::new();
        let mut equations = Vec::new();
        let mut rows = Vec::new();
        let digits = (n - 1) / 3 + 1;
        for number in 0..digits {
            let (lemma, equation, row) = self.row(number, digits)?;
            lemmas.push(lemma);
            equations.push(equation);
            rows.push(row);
        }
        // The multiplier's hidden bit.
        let factor = self.text.signal("multiplicand")?;
        let sum = || Sum::new(self.columns());
        equations.push(Equation {
            left: sum().plus_signal(&factor, n - 1),
            right: sum().plus(Term::Bit(n - 1), 1 << (n - 1)),
        });
        rows.push(Row { signal: factor, low: n - 1 });
        let mut adders = 0;
        while rows.len() > 2 {
            let mut next = Vec::new();
            for chunk in rows.chunks(3) {
                let [a, b, c] = chunk else {
                    next.extend_from_slice(chunk);
                    continue;
                };
                let (lemma, equation, sums) = self.full_adders([a, b, c].map(Row::clone), adders)?;
                lemmas.push(lemma);
                equations.push(equation);
                next.extend(sums);
                adders += 1;
            }
            rows = next;
        }
        let last = rows.iter().fold(sum(), |sum, row| sum.plus_signal(&row.signal, row.low));
        lemmas.push(self.last_sum(&rows, &last)?);
        let equations: Vec<&Equation> = equations.iter().collect();
        Ok((lemmas, derive_product(&last, &equations, n - 1, n)))
    }

    /// Lemma 3 for a digit.
    fn row(&self, number: u32, digits: u32) -> Result<(Lemma, Equation, Row), Error> {
        let ((s, n), columns) = (self.widths(), self.columns());
        let (low, is_last) = ((3 * number).saturating_sub(2), number + 1 == digits);
        let row = self.text.signal(&format!("row_{number}"))?;
        let above = number.checked_sub(1).map(|above| self.text.signal(&format!("correction_{above}"))).transpose()?;
        let correction = (!is_last).then(|| self.text.signal(&format!("correction_{number}"))).transpose()?;
        // The weight of the bit above the multiple.
        let beyond = 1_i128 << (s + 2 + 3 * number);
        let constant = match number {
            _ if digits == 1 => 0,
            _ if is_last => beyond,
            0 => beyond << 3,
            _ => 7 * beyond,
        };
        let mut left = Sum::new(columns).plus_signal(&row, low);
        let mut right = Sum::new(columns).plus(Term::Digit(number), 1 << (3 * number)).plus(Term::One, constant);
        if let Some(correction) = &correction {
            left = left.plus_signal(correction, 3 * number + 1);
        }
        if let Some(above) = &above {
            right = right.plus_signal(above, low);
        }
        let equation = Equation { left, right };
        let case = |bits: u32| {
            let value = digit(bits);
            let magnitudes = ["multiplicand", "multiplicand << 1", "thrice", "multiplicand << 2"];
            let magnitude = magnitudes[(value.unsigned_abs() as usize).checked_sub(1)?];
            Some(format!("4'd{bits}: digit = {}({magnitude});\n", if value < 0 { "-" } else { "" }))
        };
        let cases: String = (0..16).filter_map(case).collect();
        let statement = format!(
            "wire [{}:0] multiplier = {{{}'d0, b_i[{}:0], 1'b0}};\n\
             reg [{}:0] digit;\n\
             always @* case (multiplier[{}:{}])\n{cases}default: digit = 0;\nendcase\n{}",
            3 * digits,
            3 * digits + 1 - n,
            n - 2,
            columns - 1,
            3 * number + 3,
            3 * number,
            self.differ(&equation),
        );
        let takes = self.signals(&["b_i", "multiplicand", "thrice"])?.into_iter().chain(above).collect();
        let gives = std::iter::once(row.clone()).chain(correction).collect();
        let fault = Fault::new(format!("three_{number}"), "&", "|");
        let lemma = self.lemma(format!("row {number}"), takes, gives, statement, fault);
        Ok((lemma, equation, Row { signal: row, low }))
    }

    /// Lemma 4 for three rows.
    fn full_adders(&self, mut rows: [Row; 3], number: u32) -> Result<(Lemma, Equation, [Row; 2]), Error> {
        rows.sort_by_key(|row| row.low);
        let [sum, carry] = [format!("sum_{number}"), format!("carry_{number}")].map(|name| self.text.signal(&name));
        let sums = [Row { signal: sum?, low: rows[0].low }, Row { signal: carry?, low: rows[1].low }];
        let total = |rows: &[Row]| {
            rows.iter().fold(Sum::new(self.columns()), |total, row| total.plus_signal(&row.signal, row.low))
        };
        let equation = Equation { left: total(&sums), right: total(&rows) };
        let signals = |rows: &[Row]| rows.iter().map(|row| row.signal.clone()).collect();
        let fault = Fault::new(format!("carry_out_{number}"), "~", "");
        let name = format!("full adders {number}");
        let lemma = self.lemma(name, signals(&rows), signals(&sums), self.differ(&equation), fault);
        Ok((lemma, equation, sums))
    }

    /// That an equation does not hold.
    fn differ(&self, equation: &Equation) -> String {
        let name = |term: &Term| match term {
            Term::Signal(name) => name.clone(),
            _ => "digit".to_string(),
        };
        let [left, right] = [&equation.left, &equation.right].map(|sum| sum.expression(name));
        let top = self.columns() - 1;
        format!("wire [{top}:0] left = {left};\nwire [{top}:0] right = {right};\nassign differ = left != right;")
    }

    /// Lemma 5.
    fn last_sum(&self, rows: &[Row], last: &Sum) -> Result<Lemma, Error> {
        let sum = last.expression(|term| match term {
            Term::Signal(name) => name.clone(),
            _ => String::new(),
        });
        let (columns, [upper, lower]) = (self.columns(), self.split());
        let statement = format!(
            "wire [{}:0] product = {sum};\n\
             assign differ = word != product{upper} || sticky != (|product{lower});",
            columns - 1
        );
        let takes = rows.iter().map(|row| row.signal.clone()).collect();
        let gives = self.signals(&["word", "sticky"])?;
        let fault = Fault::new("high_carry_2", "|", "^");
        Ok(self.lemma("the last sum".to_string(), takes, gives, statement, fault))
    }

    /// The bits of a product that `word` has, and those that `sticky` represents.
    fn split(&self) -> [String; 2] {
        let (_, n) = self.widths();
        [format!("[{}:{}]", self.columns() - 1, n - 2), format!("[{}:0]", n - 3)]
    }

    /// Lemma 6. The product `p` is free, but as large as that of two significands of s and n bits, which is below
    /// (2^s - 1) 2^n. Where an operand is zero, infinite or NaN, the reference multiplies other numbers than the unit, so
    /// it has another product, `q`.
    fn rounding(&self) -> Result<Lemma, Error> {
        let (format, columns, [upper, lower]) = (self.multiplier.format, self.columns(), self.split());
        let (width, (s, n)) = (format.ieee_width(), self.widths());
        let product = match self.multiplier.inferred {
            true => "assign whole = p;".to_string(),
            false => format!("assign word = p{upper}; assign sticky = |p{lower};"),
        };
        let padding = if s > n { format!(", {}'d0", s - n) } else { String::new() };
        let flags = match self.multiplier.with_flags {
            // No NaN is signalling. A result is tiny if it is subnormal or zero when it is rounded toward zero, because
            // tininess is detected before rounding.
            true => format!(
                "symfpu_truncated u_truncated (.a(reference_a), .b(reference_b), .product_0_Y(reference_product), \
                 .o(truncated));\n\
                 wire tiny = ~|truncated[{}:{}];\n\
                 wire differ_in_flags = flags_o != {{NV & ~nan_a & ~nan_b, OF, NX & tiny, NX}};",
                width - 2,
                s - 1
            ),
            false => "wire differ_in_flags = 0;".to_string(),
        };
        let is_nan = |word: &str| format!("(&{word}[{}:{}] && |{word}[{}:0])", width - 2, s - 1, s - 2);
        let statement = format!(
            "{operands}{product}\n\
             wire [{recoded}:0] wanted; wire [{ieee}:0] expected, truncated; wire NV, OF, UF, NX;\n\
             raypath_fp_encode_{format} u_encode_a (.ieee_i(a), .recoded_o(a_i));\n\
             raypath_fp_encode_{factor} u_encode_b (.ieee_i(b), .recoded_o(b_i));\n\
             raypath_fp_encode_{format} u_encode (.ieee_i(expected), .recoded_o(wanted));\n\
             wire [{product_top}:0] reference_product = special_a || special_b ? q : {{p{padding}}};\n\
             symfpu u_reference (.a(reference_a), .b(reference_b), .product_0_Y(reference_product), .o(expected),\n\
             .NV(NV), .OF(OF), .UF(UF), .NX(NX));\n\
             wire nan_a = {nan_a}, nan_b = {nan_b};\n\
             {flags}\n\
             assign differ = |p[{top}:{below}] && ~&p[{top}:{n}] && (product_o != wanted || differ_in_flags);",
            operands = self.reference_operands(),
            recoded = format.recoded_width() - 1,
            ieee = width - 1,
            factor = self.factor,
            product_top = 2 * s - 1,
            nan_a = is_nan("reference_a"),
            nan_b = is_nan("reference_b"),
            top = columns - 1,
            below = columns - 2,
        );
        let taken: &[&str] = if self.multiplier.inferred { &["whole"] } else { &["word", "sticky"] };
        let given: &[&str] = if self.multiplier.with_flags { &["product_o", "flags_o"] } else { &["product_o"] };
        let products = [Signal::new("p", columns), Signal::new("q", 2 * s)];
        let mut rest = text(&encode(format)?)?;
        if self.factor != format {
            rest += &text(&encode(self.factor)?)?;
        }
        Ok(Lemma {
            name: "rounding".to_string(),
            unit: self.text.clone(),
            takes: self.signals(&[&["a_i", "b_i"], taken].concat())?,
            gives: self.signals(given)?,
            free: self.operands().into_iter().chain(products).collect(),
            reference: self.reference(self.multiplier.with_flags),
            statement,
            rest,
            faults: vec![Fault::new("vanishes", "<", "<=")],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_theorem_needs_each_of_its_lemmas() {
        let format = Format::new(5, 8).expect("a format");
        for inferred in [false, true] {
            let multiplier = Multiplier { format, inferred, short: None, with_flags: true };
            let (lemmas, follows) = multiplier.theorem().expect("a theorem");
            assert_eq!(follows, Ok(()));
            let text = &lemmas.last().expect("lemmas").unit;
            assert_eq!(is_chain(&lemmas, text), Ok(()));
            // The first two are about encoders.
            for missing in 2..lemmas.len() {
                let rest: Vec<Lemma> = [&lemmas[..missing], &lemmas[missing + 1..]].concat();
                assert!(is_chain(&rest, text).is_err(), "without {}", lemmas[missing].name);
            }
            let again = [&lemmas[..], &lemmas[2..3]].concat();
            assert!(is_chain(&again, text).is_err());
        }
    }
}
