//! Shifting right without forgetting what was shifted out.

use raypath_hdl::Wire;

/// `word` shifted right by `amount`, whatever that is; the lowest bit of the result is also set where a set bit was
/// lost ("sticky"). Rounding needs no more. `amount` must have more bits than the width of `word` needs.
pub(crate) fn shift_right_sticky<'m>(word: Wire<'m>, amount: Wire<'m>) -> Wire<'m> {
    let m = word.builder();
    let layers = word.width().next_power_of_two().ilog2();
    let far = amount.bits(amount.width() - 1, layers).any().named("far");
    (0..layers).rev().fold(word, |word, layer| {
        let step = 1 << layer;
        let lost = word.lower(step).any().extend(word.width());
        let shifted = (word.shift_right(m.constant(layers, step.into())) | lost).named(&format!("shifted_{step}"));
        (far | amount.bit(layer)).mux(shifted, word).named(&format!("aligned_{step}"))
    })
}
