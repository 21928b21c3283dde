//! The rules of the distance operations.

use super::job::{Job, Rule, rules};
use crate::coverage::operands::{CLASSES, class};
use crate::layout::Field;
use raypath_rtl::Semantics;

/// The accumulator that a beat finds. It is known when the beat leaves, so that jobs lost in a reset have none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AccumulatorState {
    /// The word of the sum before the beat.
    pub sum: u64,
    /// Whether another job left since the last beat of this accumulator.
    pub after_others: bool,
    /// Whether a reset has cleared a sum that was not zero since then.
    pub after_loss: bool,
}

impl AccumulatorState {
    /// That of an accumulator without beats.
    pub const EMPTY: Self = Self { sum: 0, after_others: true, after_loss: false };
}

/// What a beat of a distance can exercise, as far as it is known when it enters, and its accumulator.
pub fn rules_at_entry(job: &Job<'_>) -> (Vec<Rule>, Vec<usize>) {
    let lanes =
        job.fields.iter().filter(|field| matches!(field, Field::Lane { of_candidate: true, .. })).count() as u32;
    let mask = job.word(Field::Mask).unwrap_or(0);
    // An angular beat's mask has bits for the lanes that it lacks.
    let mask = mask & u64::MAX.checked_shr(64 - lanes).unwrap_or(0);
    let enabled = mask.count_ones();
    let is_some = enabled != 0 && enabled != lanes;
    let masked = |is: &dyn Fn(&str) -> bool| {
        job.each().any(|(field, code)| {
            matches!(field, Field::Lane { lane, .. } if mask >> lane & 1 == 0)
                && is(CLASSES[class(job.semantics.format, code)])
        })
    };
    let is_last = job.word(Field::Reset).is_some_and(|word| word & 1 == 1);
    let of_lanes = [
        Rule::new("7: some lanes are enabled", is_some && enabled != 1).impossible_if(lanes <= 2),
        Rule::new("7: one lane is enabled", is_some && enabled == 1).impossible_if(lanes <= 1),
    ];
    let others = rules([
        ("7: all lanes are enabled", enabled != 0 && enabled == lanes),
        ("7: no lane is enabled", enabled == 0),
        ("7: a masked lane holds NaN", masked(&is_nan)),
        ("7: a masked lane holds ±∞", masked(&is_infinite)),
        ("7: a masked lane holds another number", masked(&|class| !is_nan(class) && !is_infinite(class))),
        ("the beat carries reset", is_last),
        ("the beat does not carry reset", !is_last),
    ]);
    (
        of_lanes.into_iter().chain(others).collect(),
        job.word(Field::Accumulator).map(|word| word as usize).into_iter().collect(),
    )
}

/// What a beat can exercise that is known only when it leaves.
pub fn rules_at_exit(semantics: Semantics, found: AccumulatorState) -> Vec<Rule> {
    let class = CLASSES[class(semantics.format, found.sum)];
    let is_zero = class == "+0" || class == "−0";
    rules([
        ("added to a sum of zero", is_zero),
        ("added to a sum that is a number", !is_zero && !is_infinite(class) && !is_nan(class)),
        ("added to a sum of ±∞", is_infinite(class)),
        ("added to a sum of NaN", is_nan(class)),
        ("right behind a beat of its kind", !found.after_others),
        ("other jobs since the last beat of its kind", found.after_others),
        ("the first after a reset that lost a sum", found.after_loss),
    ])
}

fn is_infinite(class: &str) -> bool {
    class == "+∞" || class == "−∞"
}

fn is_nan(class: &str) -> bool {
    class.starts_with("NaN")
}
