//! The two sides of claims about sums of several terms that round once.
//!
//! The reference follows the definition in docs/reference/semantics.md, on integers: a finite number is a multiple of
//! the least subnormal one, and has a bit for each place from there to the greatest number.

use raypath_float::Format;

/// The drivers of `ours` and `expected`. The terms are in `a`, the first in the lowest bits.
pub fn sides(f: Format, terms: u32) -> String {
    let (width, s) = (f.ieee_width(), f.significand());
    let each = |text: &dyn Fn(u32) -> String| (0..terms).map(text).collect::<String>();
    let encoders = each(&|term| {
        format!(
            "wire [{0}:0] recoded_{term};\n\
             raypath_fp_encode_{f} u_encode_{term} (.ieee_i(a[{1} +: {width}]), .recoded_o(recoded_{term}));\n",
            f.recoded_width() - 1,
            term * width
        )
    });
    let ports = each(&|term| format!(".x_{term}_i(recoded_{term}), "));
    let places = s + (1 << f.exponent()) - 3;
    // ⌈log₂ n⌉.
    let growth = u32::BITS - (terms - 1).leading_zeros();
    format!(
        "{encoders}raypath_fp_sum_{terms}_{f} u_unit ({ports}.sum_o(ours));\n\
         reg [{last}:0] x, code;\n\
         reg nan, plus, minus, only_minus_zeros, up;\n\
         reg [{top}:0] size, sizes, window, sum, magnitude, kept, rest, half, shift;\n\
         integer term, place;\n\
         always @* begin\n\
         nan = 0; plus = 0; minus = 0; only_minus_zeros = 1; sizes = 0; sum = 0; shift = 0;\n\
         for (term = 0; term < {terms}; term = term + 1) begin\n\
         x = a[term * {width} +: {width}];\n\
         nan = nan | x[{last} - 1:0] > {infinity};\n\
         plus = plus | x == {infinity};\n\
         minus = minus | x == {minus_infinity};\n\
         only_minus_zeros = only_minus_zeros & x == {minus_zero};\n\
         size = x[{last} - 1:{s} - 1] == 0 ? x[{s} - 2:0] : {{1'b1, x[{s} - 2:0]}} << (x[{last} - 1:{s} - 1] - 1);\n\
         sizes = sizes | size;\n\
         end\n\
         for (place = 0; place <= {top}; place = place + 1)\n\
         window[place] = sizes >> (place + {s} + {growth}) == 0;\n\
         for (term = 0; term < {terms}; term = term + 1) begin\n\
         x = a[term * {width} +: {width}];\n\
         size = x[{last} - 1:{s} - 1] == 0 ? x[{s} - 2:0] : {{1'b1, x[{s} - 2:0]}} << (x[{last} - 1:{s} - 1] - 1);\n\
         sum = x[{last}] ? sum - (size & window) : sum + (size & window);\n\
         end\n\
         magnitude = sum[{top}] ? -sum : sum;\n\
         for (place = 0; place <= {top} - {s}; place = place + 1)\n\
         if (magnitude >> (place + {s}) != 0) shift = place + 1;\n\
         kept = magnitude >> shift;\n\
         rest = magnitude - (kept << shift);\n\
         half = (1 << shift) >> 1;\n\
         up = shift != 0 & (rest > half | rest == half & kept[0]);\n\
         kept = (shift << ({s} - 1)) + kept + up;\n\
         code = nan | plus & minus ? {nan} : plus ? {infinity} : minus ? {minus_infinity} :\n\
         sum == 0 ? (only_minus_zeros ? {minus_zero} : 0) :\n\
         {{sum[{top}], kept >= {infinity} ? {short}'d{infinity} : kept[{last} - 1:0]}};\n\
         end\n\
         raypath_fp_encode_{f} u_expected (.ieee_i(code), .recoded_o(expected));\n",
        last = width - 1,
        short = width - 1,
        // A sign, and room for the code of a sum beyond the greatest number.
        top = places + growth + s,
        nan = f.nan(),
        infinity = f.infinity(),
        minus_zero = 1_u64 << (width - 1),
        minus_infinity = f.infinity() | 1 << (width - 1),
    )
}
