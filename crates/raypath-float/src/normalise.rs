//! Shifting a word's leading one to the top, and counting the zeros passed.
//!
//! Each layer looks whether the upper half of what is left is empty. The counting tree and the shifter of the textbook
//! are one here: a layer's answer is a bit of the count as well as its multiplexers' select.

use raypath_hdl::Wire;

/// A word shifted left until its top bit is set, and by how much. A word of zeros gives zero, and a count of ones.
pub(crate) struct Normalised<'m> {
    pub word: Wire<'m>,
    pub count: Wire<'m>,
}

pub(crate) fn normalise(word: Wire<'_>) -> Normalised<'_> {
    let m = word.builder();
    let layers = word.width().next_power_of_two().ilog2();
    let mut count = Vec::new();
    let word = (0..layers).rev().fold(word, |word, layer| {
        let step = 1 << layer;
        let empty = (!word.upper(step).any()).named(&format!("empty_{step}"));
        count.push(empty);
        empty.mux(word.shift_left(m.constant(layers, step.into())), word).named(&format!("normalised_{step}"))
    });
    Normalised { word, count: m.concat(&count).named("leading_zeros") }
}
