//! Shift right with a sticky bit.

use raypath_hdl::Wire;

/// `word` shifted right by any `amount`. The lowest bit of the result is the sticky bit: it is also set if a set bit
/// was shifted out. If `zero` is set, `word` counts as zero; otherwise it must not be zero. `amount` must have more
/// bits than the binary representation of the width of `word`.
pub(crate) fn shift_right_sticky<'m>(word: Wire<'m>, amount: Wire<'m>, zero: Wire<'m>) -> Wire<'m> {
    let m = word.builder();
    let width = word.width();
    let layers = width.next_power_of_two().ilog2();
    let beyond = amount.bits(amount.width() - 1, layers).any().named("beyond");
    let vanishes = (beyond | zero).named("vanishes");
    let (mut word, mut lost) = (word, beyond);
    for layer in (0..layers).rev() {
        let step = 1 << layer;
        let select = amount.bit(layer);
        let shifted = word.shift_right(m.constant(layers, step.into()));
        let aligned = match layer {
            // The last layer selects neither word if no bit is left.
            0 => (word & (!select & !vanishes).replicate(width)) | (shifted & (select & !vanishes).replicate(width)),
            _ => select.mux(shifted, word),
        };
        let lost_here = lost | (select & word.lower(step).any()).hint(&format!("lost_by_{step}"));
        word = aligned.named(&format!("aligned_{step}"));
        lost = lost_here.named(&format!("lost_{step}"));
    }
    word | (lost & !zero).extend(width)
}
