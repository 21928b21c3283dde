//! Distances between vectors, a beat of lanes at a time, accumulated over beats (Table VII, columns Euclidean and
//! Angular).

use crate::bundle::bundle;
use crate::circuit::{Bit, Circuit, Flags, Num};
use crate::operation::Operation;

/// Squared Euclidean distance, `N` dimensions a beat: a power of two, at most 64.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Euclidean<const N: usize>;

/// Dot product and squared norm of the candidate, `N` dimensions a beat: half as many as a Euclidean beat has, so a
/// power of two, at most 32.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Angular<const N: usize>;

bundle! {
    /// `N` dimensions of two vectors.
    pub struct Beat<C, const N: usize> {
        /// The query's coordinates.
        pub a: [Num<C>; N],
        /// The candidate's coordinates.
        pub b: [Num<C>; N],
        /// Lanes that count; a lane that does not contributes +0.0 whatever it holds.
        pub mask: Flags<C, N>,
        /// This beat is the last of its vector: the sums begin again at zero after it.
        pub reset_accum: Bit<C>,
    }
}

bundle! {
    /// One beat.
    pub struct EuclideanInput<C, const N: usize> {
        /// The beat.
        pub euclidean: Beat<C, N>,
    }
}

bundle! {
    /// The sum so far.
    pub struct EuclideanOutput<C> {
        /// Sum of squared differences over all beats since the last reset, this one included.
        pub euclidean_accumulator: Num<C>,
        /// The beat's reset.
        pub euclidean_reset_accum: Bit<C>,
    }
}

bundle! {
    /// What a Euclidean beat leaves for the next.
    pub struct EuclideanState<C> {
        /// Sum of squared differences since the last reset.
        pub accumulator: Num<C>,
    }
}

bundle! {
    /// One beat, on the same ports as a Euclidean one.
    pub struct AngularInput<C, const N: usize> {
        /// The beat.
        pub euclidean: Beat<C, N>,
    }
}

bundle! {
    /// The sums so far.
    pub struct AngularOutput<C> {
        /// Sum of a·b over all beats since the last reset, this one included.
        pub angular_dot_product: Num<C>,
        /// Sum of b·b over the same.
        pub angular_norm: Num<C>,
        /// The beat's reset.
        pub angular_reset_accum: Bit<C>,
    }
}

bundle! {
    /// What an angular beat leaves for the next.
    pub struct AngularState<C> {
        /// Sum of a·b since the last reset.
        pub dot_product: Num<C>,
        /// Sum of b·b since the last reset.
        pub norm: Num<C>,
    }
}

/// Stages for the levels of the halving trees. First come those whose adders are there for other operations as well;
/// a tree with fewer levels leaves out the later ones. A Euclidean tree may end where an angular one accumulates.
const EUCLIDEAN_TREE: [u32; 6] = [4, 6, 8, 9, 5, 7];
const ANGULAR_TREE: [u32; 5] = [4, 6, 8, 5, 7];
const TREE_TITLE: &str = "sums i + (i + half)";

impl<const N: usize> Operation for Euclidean<N> {
    const NAME: &'static str = "euclidean";
    type Input<C: Circuit> = EuclideanInput<C, N>;
    type Output<C: Circuit> = EuclideanOutput<C>;
    type State<C: Circuit> = EuclideanState<C>;

    #[inline]
    fn run<C: Circuit>(
        &self,
        c: C,
        input: EuclideanInput<C, N>,
        state: EuclideanState<C>,
    ) -> (EuclideanOutput<C>, EuclideanState<C>) {
        let Beat { a, b, mask, reset_accum } = input.euclidean;

        c.stage(2, "a - b, zero where masked off");
        let difference: [Num<C>; N] = std::array::from_fn(|i| mask.0[i].select(a[i] - b[i], c.zero()));
        c.label(format_args!("difference"), &difference);

        c.stage(3, "squares");
        let mut lanes = difference.map(|d| d * d);
        c.label(format_args!("square"), &lanes);

        const { assert!(N.is_power_of_two() && N <= 64, "lanes are a power of two, 64 at most") };
        for (level, stage) in tree(&EUCLIDEAN_TREE, N) {
            c.stage(stage, TREE_TITLE);
            fold(c, "sum", &mut lanes, level);
        }

        c.stage(10, "accumulated");
        let accumulator = state.accumulator + lanes[0];
        c.label(format_args!("accumulator"), &accumulator);
        let next = EuclideanState { accumulator: reset_accum.select(c.zero(), accumulator) };
        (EuclideanOutput { euclidean_accumulator: accumulator, euclidean_reset_accum: reset_accum }, next)
    }
}

impl<const N: usize> Operation for Angular<N> {
    const NAME: &'static str = "angular";
    type Input<C: Circuit> = AngularInput<C, N>;
    type Output<C: Circuit> = AngularOutput<C>;
    type State<C: Circuit> = AngularState<C>;

    #[inline]
    fn run<C: Circuit>(
        &self,
        c: C,
        input: AngularInput<C, N>,
        state: AngularState<C>,
    ) -> (AngularOutput<C>, AngularState<C>) {
        let Beat { a, b, mask, reset_accum } = input.euclidean;

        c.stage(2, "masked lanes to zero");
        let unmask = |v: [Num<C>; N]| std::array::from_fn(|i| mask.0[i].select(v[i], c.zero()));
        let (query, candidate): ([Num<C>; N], [Num<C>; N]) = (unmask(a), unmask(b));
        c.label(format_args!("query"), &query);
        c.label(format_args!("candidate"), &candidate);

        c.stage(3, "a b and b b");
        let mut dots: [Num<C>; N] = std::array::from_fn(|i| query[i] * candidate[i]);
        let mut norms = candidate.map(|x| x * x);
        c.label(format_args!("dot"), &dots);
        c.label(format_args!("norm"), &norms);

        const { assert!(N.is_power_of_two() && N <= 32, "lanes are a power of two, 32 at most") };
        for (level, stage) in tree(&ANGULAR_TREE, N) {
            c.stage(stage, TREE_TITLE);
            fold(c, "dot_sum", &mut dots, level);
            fold(c, "norm_sum", &mut norms, level);
        }

        c.stage(9, "both accumulated");
        let (dot_product, norm) = (state.dot_product + dots[0], state.norm + norms[0]);
        c.label(format_args!("dot_product"), &dot_product);
        c.label(format_args!("norm"), &norm);
        let next = AngularState {
            dot_product: reset_accum.select(c.zero(), dot_product),
            norm: reset_accum.select(c.zero(), norm),
        };
        let output =
            AngularOutput { angular_dot_product: dot_product, angular_norm: norm, angular_reset_accum: reset_accum };
        (output, next)
    }
}

/// The levels of a halving tree over `lanes` lanes: the lanes that each leaves, and its stage.
#[inline]
fn tree(preference: &[u32], lanes: usize) -> impl Iterator<Item = (usize, u32)> {
    let chosen = &preference[..lanes.ilog2() as usize];
    let in_order = (1..=10).filter(move |stage| chosen.contains(stage));
    in_order.enumerate().map(move |(level, stage)| (lanes >> (level + 1), stage))
}

/// One level of the halving tree: lane i takes in lane i + half.
#[inline]
fn fold<C: Circuit>(c: C, name: &str, lanes: &mut [Num<C>], half: usize) {
    for i in 0..half {
        lanes[i] = lanes[i] + lanes[i + half];
        c.label(format_args!("{name}_{half}_{i}"), &lanes[i]);
    }
}
