//! Claims that dividers and square roots give canonical words, whatever their digits but the first two are.
//!
//! Digits that begin with as many ones as the rounding keeps, and one more, are left out: they are no quotient, because
//! 2 x / d is at most 4 - 2^(2 - s) for significands of s bits from 1 to 2.

use super::claim::{Claim, instance, texts};
use super::words::is_canonical;
use raypath_float::{DivSqrt, Format};
use raypath_hdl::Module;
use raypath_verify::Error;
use std::sync::Arc;

/// The parts between which a divider or square root is cut: the first two digits, and the rounding.
fn ends(f: Format, function: DivSqrt) -> Result<[Arc<Module>; 2], raypath_hdl::Error> {
    // A result has two digits more than the significand.
    let mut parts = function.parts(f, f.significand() / 2 + 2)?;
    let last = parts.pop().unwrap_or_else(|| parts[0].clone());
    Ok([parts.remove(0), last])
}

/// Whether `settled`, `sign`, `exponent` and the first two digits, in `first`, are what the rounding takes.
fn is_unrounded(f: Format) -> String {
    let (e, s) = (f.exponent(), f.significand());
    let least = (1 << (e - 1)) + 2 - (s + 1);
    format!(
        "wire fits = settled ? exponent[{low}:0] == 0 && (exponent[{e}:{class}] == 0 || exponent[{e}:{class}] == 6 || \
         (exponent[{e}:{class}] == 7 && !sign)) :\n\
         exponent >= {least} && exponent <= {greatest} && first != 0;\n",
        low = e - 3,
        class = e - 2,
        greatest = (3 << (e - 1)) - 1,
    )
}

/// That the part that rounds gives canonical words.
pub fn rounds_digits(f: Format, function: DivSqrt) -> Result<Claim, Error> {
    let [_, last] = ends(f, function)?;
    let name = |port: &str| port.trim_end_matches("_i").to_string();
    let inputs: Vec<(String, u32)> =
        last.inputs().iter().map(|port| (name(&port.name), last.port_width(&port.name).unwrap_or_default())).collect();
    let digits = last.port_width("digits_i").unwrap_or_default();
    let connected = instance(&last, "u_unit", |port| if port == "result_o" { "ours".into() } else { name(port) });
    Ok(Claim {
        name: format!("canonical words of the {}", if function == DivSqrt::Root { "square root" } else { "divider" }),
        unit: texts([&last])?,
        inputs,
        width: f.recoded_width(),
        body: connected
            + &is_canonical(f, "ours")
            + &format!("wire [1:0] first = digits[{}:{}];\n", digits - 1, digits - 2)
            + &is_unrounded(f)
            + &format!(
                "assign expected = canonical_ours ? ours : ~ours;\nassign valid = fits && !(&digits[{}:1]);\n",
                digits - 1
            ),
        fault: ("largest & carried", "largest & sticky"),
        ..Claim::default()
    })
}

/// That the part with the first digits gives what the rounding takes.
pub fn begins_digits(f: Format, function: DivSqrt) -> Result<Claim, Error> {
    let [first, _] = ends(f, function)?;
    let operands: Vec<String> = first.inputs().iter().map(|port| port.name.clone()).collect();
    let output = |port: &str| match port.trim_end_matches("_o") {
        "digits" => "first".to_string(),
        name @ ("settled" | "sign" | "exponent") => name.to_string(),
        _ if port.ends_with("_o") => String::new(),
        _ => port.to_string(),
    };
    let canonical: String = operands.iter().map(|operand| is_canonical(f, operand)).collect();
    let valid: Vec<String> = operands.iter().map(|operand| format!("canonical_{operand}")).collect();
    Ok(Claim {
        name: format!("first digits of the {}", if function == DivSqrt::Root { "square root" } else { "divider" }),
        unit: texts([&first])?,
        inputs: operands.iter().map(|operand| (operand.clone(), f.recoded_width())).collect(),
        width: f.exponent() + 2,
        body: format!("wire settled, sign; wire [{}:0] exponent; wire [1:0] first;\n", f.exponent())
            + &instance(&first, "u_unit", output)
            + &canonical
            + &is_unrounded(f)
            // Both sides depend on the operands.
            + "assign ours = {fits, exponent};\nassign expected = {1'b1, exponent};\n"
            + &format!("assign valid = {};\n", valid.join(" && ")),
        is_alike: true,
        fault: match function {
            DivSqrt::Root => ("+ HalfBias", "- HalfBias"),
            _ => ("= raised < MinRaisedExp", "= raised + 1 < MinRaisedExp"),
        },
        ..Claim::default()
    })
}
