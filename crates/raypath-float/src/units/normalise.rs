//! Normalising shift: moves the leading one of a word to the top, and counts the leading zeros.
//!
//! The zeros are first counted in groups of four, in parallel with the shifts. Within the last group, the select of a
//! layer's multiplexers is also a bit of the count.

use raypath_hdl::Wire;

/// A word shifted left until the leading one is in either of the top two places. A word of zeros stays as it is.
pub(crate) struct Normalised<'m> {
    pub word: Wire<'m>,
    /// Half the shift, rounded down; all ones where the word is zero.
    shift: Wire<'m>,
}

impl<'m> Normalised<'m> {
    /// Shifts `word`, of at least three bits.
    pub fn of(word: Wire<'m>) -> Self {
        let m = word.builder();
        let width = word.width();
        let layers = width.next_power_of_two().ilog2();
        let mut empties = Vec::new();
        if layers > 2 {
            let group = |number: u32| {
                width
                    .checked_sub(4 * number + 4)
                    .map_or_else(|| word.lower(width % 4), |low| word.bits(low + 3, low))
                    .any()
            };
            // Each layer reads half of the remaining groups; groups after the last that is read are not built.
            let mut looked_at = (1 << (layers - 2)) - 1;
            let present = width.div_ceil(4).min(looked_at);
            let mut groups: Vec<Wire<'m>> = (0..present).map(group).collect();
            if present < looked_at {
                groups.push(m.constant(looked_at - present, 0));
            }
            let mut groups = m.concat(&groups).named("filled_fours");
            for layer in (2..layers).rev() {
                let step = 1_u32 << layer;
                let empty = (!groups.upper(looked_at / 2 + 1).any()).named(&format!("empty_{step}"));
                empties.push((step, empty));
                looked_at /= 2;
                if looked_at > 0 {
                    groups = empty
                        .mux(groups.lower(looked_at), groups.upper(looked_at))
                        .named(&format!("filled_behind_{step}"));
                }
            }
        }
        let mut word = word;
        for &(step, empty) in &empties {
            word =
                empty.mux(word.shift_left(m.constant(layers, step.into())), word).named(&format!("normalised_{step}"));
        }
        let empty = (!word.upper(2).any()).named("empty_2");
        word = empty.mux(word.shift_left(m.constant(layers, 2)), word).named("normalised_2");
        let mut shift: Vec<Wire<'m>> = empties.iter().map(|x| x.1).collect();
        shift.push(empty);
        Self { word, shift: m.concat(&shift) }
    }

    /// The number of leading zeros; all ones if the word is zero.
    pub fn leading_zeros(&self) -> Wire<'m> {
        self.word.builder().concat(&[self.shift, !self.word.top()]).named("leading_zeros")
    }

    /// The last layer: `width` bits below the leading one, or zeros where `keep` is not set. `width` is at most the
    /// number of bits below the top.
    pub fn fraction(&self, width: u32, keep: Wire<'m>) -> Wire<'m> {
        let (word, m) = (self.word, self.word.builder());
        let top = word.width() - 1;
        let stay = (keep & word.top()).named("stay");
        let advance = (keep & !word.top()).named("advance");
        let advanced = match (top - 1).checked_sub(width) {
            Some(low) => {
                if low > 0 {
                    m.unused("unused_low", &[word.lower(low)]);
                }
                word.bits(top - 2, low)
            }
            None => m.concat(&[word.lower(top - 1), m.constant(1, 0)]),
        };
        (word.bits(top - 1, top - width) & stay.replicate(width)) | (advanced & advance.replicate(width))
    }
}
