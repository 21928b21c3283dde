//! A key against the separators of a B-tree's node (Barnes et al., "Extending GPU Ray-Tracing Units for Hierarchical
//! Search Acceleration", MICRO 2024).
//!
//! Needs 36 comparators in stage 4, of which boxes have 24 there, and encoders for 37 numbers, of which the others have
//! 32. Sorted separators answer the key like a thermometer: so the index comes out of choices alone, and nothing is
//! counted.

use crate::{Bit, Circuit, Num, Operation, Word, bundle};

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
