//! The rules of the distance operations.

use super::declare::{fields, rules};
use crate::coverage::operands::{CLASSES, class};
use crate::layout::{Field, Layout};
use raypath_float::Format;
use raypath_ops::JobKind;

rules! {
    /// What a beat of a distance can exercise.
    BeatRule {
        MaskAll = "7: all lanes are enabled",
        MaskSome = "7: some lanes are enabled",
        MaskOne = "7: one lane is enabled",
        MaskNone = "7: no lane is enabled",
        MaskedNan = "7: a masked lane holds NaN",
        MaskedInfinity = "7: a masked lane holds ±∞",
        MaskedNumber = "7: a masked lane holds another number",
        Last = "the beat carries reset",
        NotLast = "the beat does not carry reset",
        OntoZero = "added to a sum of zero",
        OntoNumber = "added to a sum that is a number",
        OntoInfinity = "added to a sum of ±∞",
        OntoNan = "added to a sum of NaN",
        Adjacent = "right behind a beat of its kind",
        AfterOthers = "other jobs since the last beat of its kind",
        AfterLoss = "the first after a reset that lost a sum",
    }
}

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

impl BeatRule {
    /// The first of the rules that are known when a beat leaves; all later rules are too.
    pub const FIRST_AT_EXIT: Self = Self::OntoZero;

    /// Calls `visit` with each rule that a beat exercises, as far as it is known when it enters.
    pub fn each(kind: JobKind, format: Format, layout: &Layout, words: &[u64], mut visit: impl FnMut(Self)) {
        let word = |wanted: Field| fields(layout, kind, words).find(|(field, _)| *field == wanted).map_or(0, |f| f.1);
        let lanes = layout.fields(kind).iter().filter(|field| matches!(field, Field::Lane { of_candidate: true, .. }));
        let (mask, lanes) = (word(Field::Mask), lanes.count() as u32);
        let enabled = mask.count_ones();
        visit(match enabled {
            0 => Self::MaskNone,
            _ if enabled == lanes => Self::MaskAll,
            1 => Self::MaskOne,
            _ => Self::MaskSome,
        });
        visit(if word(Field::Reset) & 1 == 1 { Self::Last } else { Self::NotLast });
        for (field, code) in fields(layout, kind, words) {
            if let Field::Lane { lane, .. } = field
                && mask >> lane & 1 == 0
            {
                visit(match CLASSES[class(format, code)] {
                    "+∞" | "−∞" => Self::MaskedInfinity,
                    name if name.starts_with("NaN") => Self::MaskedNan,
                    _ => Self::MaskedNumber,
                });
            }
        }
    }

    /// Calls `visit` with each rule that is known when a beat leaves.
    pub fn each_at_exit(format: Format, found: AccumulatorState, mut visit: impl FnMut(Self)) {
        visit(match CLASSES[class(format, found.sum)] {
            "+0" | "−0" => Self::OntoZero,
            "+∞" | "−∞" => Self::OntoInfinity,
            name if name.starts_with("NaN") => Self::OntoNan,
            _ => Self::OntoNumber,
        });
        visit(if found.after_others { Self::AfterOthers } else { Self::Adjacent });
        if found.after_loss {
            visit(Self::AfterLoss);
        }
    }
}
