//! A key against the separators of a B-tree's node (Barnes et al., "Extending GPU Ray-Tracing Units for Hierarchical
//! Search Acceleration", MICRO 2024).
//!
//! Needs 36 comparators in stage 4, of which boxes have 24 there, and encoders for 37 numbers, of which the others have 32.
//! Sorted separators answer the key like a thermometer: so the index comes out of choices alone, and nothing is counted.

use crate::{draw, exact};
use rand::{Rng, RngExt};
use raypath_lab::{Registered, Study, inventory};
use raypath_ops::{Binary32, Bit, Circuit, Num, Operation, Word, array_of, bundle};

/// Separators of a node, so that it has one more child.
pub const SEPARATORS: usize = 36;

/// Which child of a node a key belongs to.
///
/// Child i has the keys from separator i - 1, which is one of them, to separator i, which is not: a key that equals a
/// separator goes to its right. -0 equals +0. Separators are in ascending order; where there are fewer than
/// [`SEPARATORS`], +∞ stands for the rest, or NaN, which no key reaches, not even +∞. A NaN key belongs to child 0.
/// Among separators that are in no order a binary search goes on, whose answer is some child.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KeyCompare;

bundle! {
    /// A key and a node.
    pub struct KeyCompareInput<C> {
        /// The key.
        pub key: Num<C>,
        /// The node's separators, ascending.
        pub separator: [Num<C>; SEPARATORS],
    }
}

bundle! {
    /// The child.
    pub struct KeyCompareOutput<C> {
        /// How many separators the key reaches: the child's index, 0 to 36.
        pub child_index: Word<C, 6>,
    }
}

impl Operation for KeyCompare {
    const NAME: &'static str = "key_compare";
    type Input<C: Circuit> = KeyCompareInput<C>;
    type Output<C: Circuit> = KeyCompareOutput<C>;
    type State<C: Circuit> = ();

    #[inline(always)]
    fn run<C: Circuit>(&self, c: C, input: KeyCompareInput<C>, _state: ()) -> (KeyCompareOutput<C>, ()) {
        let KeyCompareInput { key, separator } = input;

        c.stage(4, "the key against every separator; the index by a tree of choices");
        let reached: [Bit<C>; SEPARATORS] = array_of!(i => key.compare(separator[i]).greater_or_equal());
        c.label(format_args!("reached"), &reached);

        let mut child: [Word<C, 6>; SEPARATORS + 1] = array_of!(i => c.word(i as u32));
        for half in [1, 2, 4, 8, 16, 32] {
            for first in (0..=SEPARATORS - half).step_by(2 * half) {
                child[first] = reached[first + half - 1].select(child[first + half], child[first]);
            }
        }
        c.label(format_args!("child"), &child[0]);

        (KeyCompareOutput { child_index: child[0] }, ())
    }
}

inventory::submit!(Registered(|| Study::of(KeyCompare)
    .purpose("a key against 36 separators: nodes of B-trees")
    .stimulus(stimulus)
    .oracle("counting", judge)
    .into()));

/// A node of any number of children, its separators close together, spread out or equal, and a key at or between them.
pub fn stimulus(rng: &mut impl Rng) -> KeyCompareInput<Binary32> {
    let count = if rng.random() { SEPARATORS } else { rng.random_range(0..=SEPARATORS) };
    let kind = rng.random_range(0..4);
    let mut number = || match kind {
        0 => draw::whole(rng),
        1 => draw::spread(rng, -149..128),
        2 if rng.random_bool(0.2) => draw::edge(rng),
        _ => rng.random_range(-1.0..1.0),
    };
    let mut separators: Vec<f32> = (0..count).map(|_| number()).filter(|number| !number.is_nan()).collect();
    let other = number();
    separators.sort_by(f32::total_cmp);
    let some = separators.get(rng.random_range(0..SEPARATORS)).copied().unwrap_or(other);
    let key = match rng.random_range(0..8) {
        0..3 => some,
        3 => some.next_up(),
        4 => some.next_down(),
        5 => draw::edge(rng),
        _ => other,
    };
    let padding = if rng.random_bool(0.3) { f32::NAN } else { f32::INFINITY };
    separators.resize(SEPARATORS, padding);
    KeyCompareInput { key: key.into(), separator: std::array::from_fn(|i| separators[i].into()) }
}

/// Counts the separators, by their places among all numbers, that are not above the key.
///
/// # Errors
/// An answer that is not that count, or a job whose separators are not sorted: it has no right answer.
pub fn judge(job: &KeyCompareInput<Binary32>, answer: &KeyCompareOutput<Binary32>) -> Result<(), String> {
    let places: Vec<Option<i64>> = job.separator.iter().map(|&separator| exact::order(separator)).collect();
    if !places.is_sorted_by_key(|place| place.unwrap_or(i64::MAX)) {
        return Err("the job's separators are not in ascending order".to_string());
    }
    let key = exact::order(job.key);
    let expected = key.map_or(0, |key| places.iter().flatten().filter(|&&place| place <= key).count());
    let found = u32::from(answer.child_index) as usize;
    if found != expected {
        return Err(format!("child_index is {found}, but the key reaches {expected} separators"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{check, jobs};

    check!(KeyCompare, KeyCompareInput, KeyCompareOutput);

    fn child(key: f32, separators: &[f32], padding: f32) -> u32 {
        let separator = std::array::from_fn(|i| separators.get(i).copied().unwrap_or(padding).into());
        let job = KeyCompareInput { key: key.into(), separator };
        let (answer, ()) = KeyCompare.run(Binary32, job, ());
        judge(&job, &answer).expect("a right answer");
        answer.child_index.into()
    }

    #[test]
    fn keys_at_the_edges() {
        let (inf, nan) = (f32::INFINITY, f32::NAN);
        let ten_to_thirty = [10.0, 20.0, 30.0];
        let found = [-inf, 9.0, 10.0, 19.0, 20.0, 30.0, f32::MAX, inf].map(|key| child(key, &ten_to_thirty, inf));
        assert_eq!(found, [0, 0, 1, 1, 2, 3, 3, 36]);
        assert_eq!(child(inf, &ten_to_thirty, nan), 3);
        assert_eq!(child(nan, &ten_to_thirty, inf), 0);
        assert_eq!((child(-0.0, &[0.0], inf), child(0.0, &[-0.0, 0.0], inf)), (1, 2));
        assert_eq!(child(5.0, &[5.0; 36], inf), 36);
        assert_eq!((child(0.0, &[f32::from_bits(1)], inf), child(-f32::from_bits(1), &[-0.0], inf)), (0, 0));
    }

    #[test]
    fn every_child_is_reached() {
        let separators: Vec<f32> = (1..=36).map(|i| i as f32).collect();
        for key in 0..=36 {
            assert_eq!(child(key as f32, &separators, f32::INFINITY), key);
        }
    }

    #[test]
    fn wrong_answers_are_refused() {
        for job in jobs(stimulus, 1000) {
            let (right, ()) = KeyCompare.run(Binary32, job, ());
            for child in (0..64).filter(|&child| child != u32::from(right.child_index)) {
                assert!(judge(&job, &KeyCompareOutput { child_index: Word::truncate(child) }).is_err());
            }
        }
        let mut job = jobs(stimulus, 1)[0];
        (job.separator[0], job.separator[1]) = (2.0.into(), 1.0.into());
        assert!(judge(&job, &KeyCompareOutput { child_index: Word::truncate(0) }).is_err());
    }
}
