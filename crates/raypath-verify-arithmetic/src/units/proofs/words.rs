//! SystemVerilog about words in IEEE 754's layout and recoded words.

use raypath_float::Format;

/// The operands' recoded words: `recoded_a` is that of `a`.
pub fn encoders(f: Format, operands: &[&str]) -> String {
    let encoder = |operand: &&str| {
        format!(
            "wire [{}:0] recoded_{operand};\n\
             raypath_fp_encode_{f} u_encode_{operand} (.ieee_i({operand}), .recoded_o(recoded_{operand}));\n",
            f.recoded_width() - 1
        )
    };
    operands.iter().map(encoder).collect()
}

/// Whether a word in IEEE 754's layout is NaN.
pub fn is_nan(f: Format, word: &str) -> String {
    let (e, s) = (f.exponent(), f.significand());
    format!("((&{word}[{}:{}]) && (|{word}[{}:0]))", e + s - 2, s - 1, s - 2)
}

/// The wire `canonical_<word>`: whether a recoded word is canonical, by the table of docs/reference/formats.md.
pub fn is_canonical(f: Format, word: &str) -> String {
    let (e, s) = (f.exponent(), f.significand());
    let (top, normal) = (e + s - 1, (1 << (e - 1)) + 2);
    format!(
        "wire [{e}:0] exponent_{word} = {word}[{top}:{low}];\n\
         wire [{s}:0] below_{word} = ({wide}'d1 << ({normal} - exponent_{word})) - {wide}'d1;\n\
         wire canonical_{word} = exponent_{word}[{e}:{class}] == 0 || exponent_{word}[{e}:{class}] == 6 ? \
         {word}[{rest}:0] == 0 :\n\
         exponent_{word}[{e}:{class}] == 7 ? {word}[{rest}:0] == {nan} && !{word}[{sign}] :\n\
         exponent_{word} >= {least} && exponent_{word} <= {greatest} &&\n\
         (exponent_{word} >= {normal} || ({word}[{fraction}:0] & below_{word}) == 0);\n",
        low = s - 1,
        wide = s + 1,
        class = e - 2,
        rest = top - 3,
        nan = 1_u64 << (s - 2),
        sign = top + 1,
        least = normal - (s - 1),
        greatest = (3 << (e - 1)) - 1,
        fraction = s - 2,
    )
}

/// The wires `special_<word>`, whether a recoded word is zero, infinite or NaN, and `form_<word>`, its canonical form if
/// it is, and otherwise the word.
pub fn canonical_form(f: Format, word: &str) -> String {
    let (e, s) = (f.exponent(), f.significand());
    let top = e + s - 1;
    let zeros = top - 2;
    format!(
        "wire [2:0] class_{word} = {word}[{top}:{zeros}];\n\
         wire special_{word} = class_{word} == 0 || class_{word} == 6 || class_{word} == 7;\n\
         wire [{sign}:0] form_{word} = class_{word} == 7 ? {{1'b0, 3'd7, {zeros}'d{nan}}} :\n\
         special_{word} ? {{{word}[{sign}:{zeros}], {zeros}'d0}} : {word};\n",
        sign = top + 1,
        nan = 1_u64 << (s - 2),
    )
}
