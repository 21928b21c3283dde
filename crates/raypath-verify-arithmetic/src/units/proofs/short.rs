//! The two sides of claims about units whose results have short significands, rounded in one direction.
//!
//! A product whose factors have at most half of the format's bits is exact before it is rounded, and is compared with
//! symfpu's product in the short format, rounded in that direction. A longer product is compared with symfpu's, rounded
//! to nearest in the format, and then rounded as a word: words of IEEE 754 are in the order of magnitudes, so adding
//! ones below the kept bits rounds away from zero. The units' own rules are stated here once more: results below twice
//! the least normal number are zeros, and what is too large for the format is infinite.

use raypath_float::{Format, Narrow};
use raypath_verify::Error;

/// The direction of a rounding in words.
pub fn direction(to: Narrow) -> &'static str {
    if to.away { "away from" } else { "toward" }
}

/// The drivers of `ours` and `expected` for a product.
pub fn product(f: Format, to: Narrow) -> Result<String, Error> {
    let (short, bits) = (f.narrowed(to.bits)?, to.bits);
    let (recoded, ieee) = (short.recoded_width(), short.ieee_width());
    let ours = format!(
        "wire [{top}:0] recoded_a, recoded_b;\n\
         raypath_fp_encode_{short} u_encode_a (.ieee_i(a), .recoded_o(recoded_a));\n\
         raypath_fp_encode_{short} u_encode_b (.ieee_i(b), .recoded_o(recoded_b));\n\
         raypath_fp_mul_{f}_s{bits}_{to} u_unit (.a_i(recoded_a), .b_i(recoded_b), .product_o(ours));\n\
         wire [{last}:0] rounded; wire overflows;\n",
        top = recoded - 1,
        last = ieee - 1,
    );
    let lost = f.significand() - bits;
    let reference = if 2 * bits <= f.significand() {
        // Toward positive for positive products, toward negative for others.
        let mode =
            if to.away { format!(", .rm(a[{0}] ^ b[{0}] ? 5'b01000 : 5'b00100)", ieee - 1) } else { String::new() };
        format!("symfpu u_reference (.a(a), .b(b){mode}, .o(rounded), .OF(overflows));\n")
    } else {
        format!(
            "wire [{last}:0] nearest;\n\
             symfpu u_reference (.a({{a, {lost}'d0}}), .b({{b, {lost}'d0}}), .o(nearest));\n\
             {}assign overflows = 0;\n",
            round_word(f, to, "nearest"),
            last = f.ieee_width() - 1,
        )
    };
    Ok(ours + &reference + &expected(short))
}

/// The drivers of `ours` and `expected` for a shortening.
pub fn shortening(f: Format, to: Narrow) -> Result<String, Error> {
    let (short, margin, last) = (f.narrowed(to.bits)?, to.margin, f.ieee_width() - 1);
    let infinity = (1_u64 << (f.ieee_width() - 1)) - (1 << (f.significand() - 1));
    // Numbers move by units in the last place, but not beyond zero or infinity; others do not move.
    let moved = match to.away {
        true => format!(
            "a[{0}:0] >= {last}'d{infinity} - {last}'d{margin} ? {last}'d{infinity} : a[{0}:0] + {last}'d{margin}",
            last - 1
        ),
        false => format!("a[{0}:0] < {last}'d{margin} ? {last}'d0 : a[{0}:0] - {last}'d{margin}", last - 1),
    };
    let text = format!(
        "wire [{recoded}:0] recoded_a;\n\
         raypath_fp_encode_{f} u_encode (.ieee_i(a), .recoded_o(recoded_a));\n\
         raypath_narrow_{f}_{to} u_unit (.number_i(recoded_a), .narrow_o(ours));\n\
         wire [{last}:0] moved; wire [{short_last}:0] rounded; wire overflows = 0;\n\
         assign moved = {{a[{last}], a[{0}:0] >= {last}'d{infinity} ? a[{0}:0] : ({moved})}};\n",
        last - 1,
        recoded = f.recoded_width() - 1,
        short_last = short.ieee_width() - 1,
    );
    Ok(text + &round_word(f, to, "moved") + &expected(short))
}

/// Rounds a word in the IEEE 754 layout to a shorter one. A NaN keeps the top bit of its fraction.
fn round_word(f: Format, to: Narrow, word: &str) -> String {
    let (last, lost) = (f.ieee_width() - 1, f.significand() - to.bits);
    let (e, s) = (f.exponent(), f.significand());
    let up = if to.away { (1_u64 << lost) - 1 } else { 0 };
    format!(
        "wire is_finite_word = ~(&{word}[{high}:{low}]);\n\
         wire [{last}:0] stepped = {{1'b0, {word}[{0}:0]}} + (is_finite_word ? {width}'d{up} : {width}'d0);\n\
         wire is_nan_word = ~is_finite_word && (|{word}[{below}:0]);\n\
         assign rounded = {{{word}[{last}], is_nan_word ? {{{short}{{1'b1}}}} : stepped[{0}:{lost}]}};\n",
        last - 1,
        high = e + s - 2,
        low = s - 1,
        below = s - 2,
        width = f.ieee_width(),
        short = e + to.bits - 1,
    )
}

/// `expected`, recoded, from the rounded number and whether it is too large for the format.
fn expected(short: Format) -> String {
    let (e, s, last) = (short.exponent(), short.significand(), short.ieee_width() - 1);
    let (high, low) = (e + s - 2, s - 1);
    format!(
        "wire is_nan = (&rounded[{high}:{low}]) && (|rounded[{below}:0]);\n\
         wire is_small = rounded[{high}:{low}] < 2;\n\
         wire [{last}:0] wanted = is_nan ? {width}'d{nan} : overflows ? {{rounded[{last}], {{{e}{{1'b1}}}}, {low}'d0}} :\n\
         is_small ? {{rounded[{last}], {last}'d0}} : rounded;\n\
         raypath_fp_encode_{short} u_expected (.ieee_i(wanted), .recoded_o(expected));\n",
        below = s - 2,
        width = short.ieee_width(),
        nan = short.nan(),
    )
}
