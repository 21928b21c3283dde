use super::{fields, rules};
use crate::verify::coverage::operands::{CLASSES, class};
use crate::verify::layout::{Field, Layout};
use raypath_float::Format;
use raypath_ops::JobKind;

rules! {
    /// What decides about a beat of a distance.
    BeatRule {
        MaskAll = "7: all lanes count",
        MaskSome = "7: some lanes count",
        MaskOne = "7: one lane counts",
        MaskNone = "7: no lane counts",
        MaskedNan = "7: a lane that does not count holds NaN",
        MaskedInfinity = "7: a lane that does not count holds ±∞",
        MaskedNumber = "7: a lane that does not count holds another number",
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

/// What a beat finds: known only when it leaves, so that jobs lost in a reset have none of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Onto {
    /// The code of the sum before it.
    pub sum: u64,
    /// Another kind of job left since the last of this.
    pub after_others: bool,
    /// A reset lost a sum that was not zero since.
    pub after_loss: bool,
}

impl BeatRule {
    /// The first rule that is known only when a beat leaves; all behind it are too.
    pub const FIRST_AT_EXIT: Self = Self::OntoZero;

    /// Tells each rule that a beat exercises as it enters.
    pub fn each(kind: JobKind, format: Format, layout: &Layout, words: &[u64], mut tell: impl FnMut(Self)) {
        let word = |wanted: Field| fields(layout, kind, words).find(|(field, _)| *field == wanted).map_or(0, |f| f.1);
        let lanes = layout.fields(kind).iter().filter(|field| matches!(field, Field::Lane { of_candidate: true, .. }));
        let (mask, lanes) = (word(Field::Mask), lanes.count() as u32);
        let counting = mask.count_ones();
        tell(match counting {
            0 => Self::MaskNone,
            _ if counting == lanes => Self::MaskAll,
            1 => Self::MaskOne,
            _ => Self::MaskSome,
        });
        tell(if word(Field::Reset) & 1 == 1 { Self::Last } else { Self::NotLast });
        for (field, code) in fields(layout, kind, words) {
            if let Field::Lane { lane, .. } = field
                && mask >> lane & 1 == 0
            {
                tell(match CLASSES[class(format, code)] {
                    "+∞" | "−∞" => Self::MaskedInfinity,
                    name if name.starts_with("NaN") => Self::MaskedNan,
                    _ => Self::MaskedNumber,
                });
            }
        }
    }

    /// Tells each rule that a beat has exercised when it leaves.
    pub fn each_at_exit(format: Format, onto: Onto, mut tell: impl FnMut(Self)) {
        tell(match CLASSES[class(format, onto.sum)] {
            "+0" | "−0" => Self::OntoZero,
            "+∞" | "−∞" => Self::OntoInfinity,
            name if name.starts_with("NaN") => Self::OntoNan,
            _ => Self::OntoNumber,
        });
        tell(if onto.after_others { Self::AfterOthers } else { Self::Adjacent });
        if onto.after_loss {
            tell(Self::AfterLoss);
        }
    }
}
