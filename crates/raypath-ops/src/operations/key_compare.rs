//! A key against the separators of a B-tree's node (Barnes et al., "Extending GPU Ray-Tracing Units for Hierarchical
//! Search Acceleration", MICRO 2024).
//!
//! It uses 36 comparators in stage 4, of which a datapath for boxes has 24, and encoders for 37 numbers, of which the
//! paper's datapath has 32. The comparisons with sorted separators form a thermometer code, from which a tree of
//! multiplexers selects the index without counting.

use crate::{Bit, Circuit, Num, Operation, Word, bundle};

/// The number of separators of a node, which has one more child.
pub const SEPARATORS: usize = 36;

/// Finds the child of a node to which a key belongs.
///
/// Child i has the keys from separator i - 1 (included) to separator i (excluded). -0 equals +0, and a NaN key belongs
/// to child 0. The separators must be in ascending order. If there are fewer than [`SEPARATORS`], the remaining ones
/// must be +∞, or NaN, which is greater than every key. For unsorted separators the result is the index of some child.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KeyCompare;

bundle! {
    /// A key and a node.
    pub struct KeyCompareInput<C> {
        /// The key.
        pub key: Num<C>,
        /// The separators of the node, in ascending order.
        pub separator: [Num<C>; SEPARATORS],
    }

    /// The child of the key.
    pub struct KeyCompareOutput<C> {
        /// The index of the child, 0 to 36: the number of separators that are not greater than the key.
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

        c.stage(4, "the key against every separator; the index by a tree of multiplexers");
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
