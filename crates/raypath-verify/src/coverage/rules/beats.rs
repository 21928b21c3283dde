//! The rules of the distance operations.

use super::rounded::{Rule, fields};
use crate::coverage::operands::{CLASSES, class};
use crate::layout::{Field, Layout};
use raypath_float::Format;
use raypath_ops::JobKind;

/// The accumulator that a beat finds. It is known when the beat leaves, so that jobs lost in a reset have none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AccumulatorState {
    /// The word of the sum before the beat.
    pub sum: u64,
    /// Whether another operation's job left since the last beat of this one.
    pub after_others: bool,
    /// Whether a reset has cleared a sum that was not zero since then.
    pub after_loss: bool,
}

/// The number of the rules that are known when a beat enters.
pub const RULES_AT_ENTRY: usize = 9;

/// What a beat of a distance can exercise, as far as it is known when it enters.
pub fn rules_at_entry(kind: JobKind, format: Format, layout: &Layout, words: &[u64]) -> [Rule; RULES_AT_ENTRY] {
    let word = |wanted: Field| fields(layout, kind, words).find(|(field, _)| *field == wanted).map_or(0, |f| f.1);
    let lanes = layout.fields(kind).iter().filter(|field| matches!(field, Field::Lane { of_candidate: true, .. }));
    let (mask, lanes) = (word(Field::Mask), lanes.count() as u32);
    let enabled = mask.count_ones();
    let is_some = enabled != 0 && enabled != lanes;
    let masked = |is: &dyn Fn(&str) -> bool| {
        fields(layout, kind, words).any(|(field, code)| {
            matches!(field, Field::Lane { lane, .. } if mask >> lane & 1 == 0) && is(CLASSES[class(format, code)])
        })
    };
    let is_last = word(Field::Reset) & 1 == 1;
    [
        ("7: all lanes are enabled", enabled != 0 && enabled == lanes),
        ("7: some lanes are enabled", is_some && enabled != 1),
        ("7: one lane is enabled", is_some && enabled == 1),
        ("7: no lane is enabled", enabled == 0),
        ("7: a masked lane holds NaN", masked(&is_nan)),
        ("7: a masked lane holds ±∞", masked(&is_infinite)),
        ("7: a masked lane holds another number", masked(&|class| !is_nan(class) && !is_infinite(class))),
        ("the beat carries reset", is_last),
        ("the beat does not carry reset", !is_last),
    ]
}

/// What a beat can exercise that is known only when it leaves.
pub fn rules_at_exit(format: Format, found: AccumulatorState) -> [Rule; 7] {
    let class = CLASSES[class(format, found.sum)];
    let is_zero = class == "+0" || class == "−0";
    [
        ("added to a sum of zero", is_zero),
        ("added to a sum that is a number", !is_zero && !is_infinite(class) && !is_nan(class)),
        ("added to a sum of ±∞", is_infinite(class)),
        ("added to a sum of NaN", is_nan(class)),
        ("right behind a beat of its kind", !found.after_others),
        ("other jobs since the last beat of its kind", found.after_others),
        ("the first after a reset that lost a sum", found.after_loss),
    ]
}

fn is_infinite(class: &str) -> bool {
    class == "+∞" || class == "−∞"
}

fn is_nan(class: &str) -> bool {
    class.starts_with("NaN")
}
