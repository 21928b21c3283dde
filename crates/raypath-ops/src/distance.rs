//! Distances between vectors, accumulated over beats of several lanes (Table VII, columns Euclidean and Angular).

use crate::operation::run_portable;
use crate::{Binary32, Bit, Circuit, Flags, Kernels, LaneMap, Num, Operation, Rounding, bundle};
use thiserror::Error;

/// Squared Euclidean distance with `N` dimensions per beat: a power of two, at most 64.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Euclidean<const N: usize> {
    /// How the sum of a beat is rounded.
    pub rounding: Rounding,
}

/// Dot product, and squared norm of the candidate, with `N` dimensions per beat: a power of two, at most 32. A datapath
/// has half as many angular lanes as Euclidean ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Angular<const N: usize> {
    /// How the sums of a beat are rounded.
    pub rounding: Rounding,
}

bundle! {
    /// `N` dimensions of two vectors.
    pub struct Beat<C, const N: usize> {
        /// The query's coordinates.
        pub a: [Num<C>; N],
        /// The candidate's coordinates.
        pub b: [Num<C>; N],
        /// The lanes that count. A lane that is masked off contributes +0.0 for any values of its coordinates.
        pub mask: Flags<C, N>,
        /// This beat is the last of its vectors: the sums restart at zero after it.
        pub reset_accum: Bit<C>,
    }

    /// The input of [`Euclidean`] and [`Angular`], which share their ports.
    pub struct BeatInput<C, const N: usize> {
        /// The beat.
        pub euclidean: Beat<C, N>,
    }

    /// The sum up to and including this beat.
    pub struct EuclideanOutput<C> {
        /// Sum of squared differences over all beats since the last reset, including this one.
        pub euclidean_accumulator: Num<C>,
        /// The beat's reset.
        pub euclidean_reset_accum: Bit<C>,
    }

    /// The accumulator of Euclidean beats.
    pub struct EuclideanState<C> {
        /// Sum of squared differences since the last reset.
        pub accumulator: Num<C>,
    }

    /// The sums up to and including this beat.
    pub struct AngularOutput<C> {
        /// Sum of a·b over all beats since the last reset, including this one.
        pub angular_dot_product: Num<C>,
        /// Sum of b·b over the same beats.
        pub angular_norm: Num<C>,
        /// The beat's reset.
        pub angular_reset_accum: Bit<C>,
    }

    /// The accumulators of angular beats.
    pub struct AngularState<C> {
        /// Sum of a·b since the last reset.
        pub dot_product: Num<C>,
        /// Sum of b·b since the last reset.
        pub norm: Num<C>,
    }
}

impl<C: Circuit> EuclideanState<C> {
    /// An accumulator of zero.
    #[inline(always)]
    pub fn zero(c: C) -> Self {
        Self { accumulator: c.zero() }
    }
}

impl<C: Circuit> AngularState<C> {
    /// Accumulators of zero.
    #[inline(always)]
    pub fn zero(c: C) -> Self {
        Self { dot_product: c.zero(), norm: c.zero() }
    }
}

/// The stages for the levels of the adder trees, by preference: first the stages whose adders other operations need as
/// well. A tree with fewer levels omits the last stages of the list.
const EUCLIDEAN_TREE: [u32; 6] = [4, 6, 8, 9, 5, 7];
const ANGULAR_TREE: [u32; 5] = [4, 6, 8, 5, 7];
const TREE_TITLE: &str = "sums i + (i + half)";

/// The stage in which sums that round once are available.
const SUMMED: u32 = 6;
/// The stage of the accumulators if sums round once.
pub(crate) const ACCUMULATED: u32 = 8;

impl<const N: usize> Operation for Euclidean<N> {
    const NAME: &'static str = "euclidean";
    type Input<C: Circuit> = BeatInput<C, N>;
    type Output<C: Circuit> = EuclideanOutput<C>;
    type State<C: Circuit> = EuclideanState<C>;

    run_portable!();

    #[inline(always)]
    fn run_with<C: Circuit, K: Kernels<C>>(
        &self,
        c: C,
        kernels: K,
        input: BeatInput<C, N>,
        state: EuclideanState<C>,
    ) -> (EuclideanOutput<C>, EuclideanState<C>) {
        let reset_accum = input.euclidean.reset_accum;
        let sum = squares_of(c, kernels, self.rounding, &input.euclidean);

        c.stage_or(10, ACCUMULATED, "accumulated");
        let accumulator = state.accumulator + sum;
        c.label(format_args!("accumulator"), &accumulator);
        let next = EuclideanState { accumulator: reset_accum.select(c.zero(), accumulator) };
        (EuclideanOutput { euclidean_accumulator: accumulator, euclidean_reset_accum: reset_accum }, next)
    }
}

impl<const N: usize> Operation for Angular<N> {
    const NAME: &'static str = "angular";
    type Input<C: Circuit> = BeatInput<C, N>;
    type Output<C: Circuit> = AngularOutput<C>;
    type State<C: Circuit> = AngularState<C>;

    run_portable!();

    #[inline(always)]
    fn run_with<C: Circuit, K: Kernels<C>>(
        &self,
        c: C,
        kernels: K,
        input: BeatInput<C, N>,
        state: AngularState<C>,
    ) -> (AngularOutput<C>, AngularState<C>) {
        let reset_accum = input.euclidean.reset_accum;
        let [dot_sum, norm_sum] = products_of(c, kernels, self.rounding, &input.euclidean);

        c.stage_or(9, ACCUMULATED, "both accumulated");
        let (dot_product, norm) = (state.dot_product + dot_sum, state.norm + norm_sum);
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

bundle! {
    /// One dimension of two vectors.
    pub struct Lane<C> {
        /// The query's coordinate.
        pub a: Num<C>,
        /// The candidate's coordinate.
        pub b: Num<C>,
        /// Whether the dimension counts.
        pub counts: Bit<C>,
    }
}

/// The lanes of a beat.
#[inline(always)]
fn lanes_of<C: Circuit, const N: usize>(beat: &Beat<C, N>) -> [Lane<C>; N] {
    // Not `array_of!`: the compiler would keep the array in memory, which costs SIMD most of its speed.
    std::array::from_fn(|i| Lane { a: beat.a[i], b: beat.b[i], counts: beat.mask.0[i] })
}

/// The sum of a beat's squared differences.
#[inline(always)]
pub(crate) fn squares_of<C: Circuit, const N: usize>(
    c: C,
    kernels: impl Kernels<C>,
    rounding: Rounding,
    beat: &Beat<C, N>,
) -> Num<C> {
    let lanes = lanes_of(beat);
    let squares = kernels.map(c, &SquaredDifference, &(), &lanes);
    c.label(format_args!("square"), &squares);

    const { assert!(N.is_power_of_two() && N <= 64, "lanes are a power of two, 64 at most") };
    if rounding == Rounding::Sum {
        return sum_of_halves(c, squares);
    }
    let [sum] = tree(c, kernels, &EUCLIDEAN_TREE, ["sum"], [squares]);
    sum
}

/// The sums of a beat's products a·b and b·b.
#[inline(always)]
pub(crate) fn products_of<C: Circuit, const N: usize>(
    c: C,
    kernels: impl Kernels<C>,
    rounding: Rounding,
    beat: &Beat<C, N>,
) -> [Num<C>; 2] {
    let lanes = lanes_of(beat);
    let products = kernels.map(c, &Products, &(), &lanes);
    let dots: [Num<C>; N] = array_of!(i => products[i][0]);
    let norms: [Num<C>; N] = array_of!(i => products[i][1]);
    c.label(format_args!("dot"), &dots);
    c.label(format_args!("norm"), &norms);

    const { assert!(N.is_power_of_two() && N <= 32, "lanes are a power of two, 32 at most") };
    if rounding == Rounding::Sum {
        begin_sums(c, N);
        c.stage(SUMMED, "both sums, rounded once");
        // The norms first, because their squares are in the registers of the lower half of Euclidean squares.
        let (norm, dot) = (Num::sum(norms), Num::sum(dots));
        c.label(format_args!("dot_sum"), &dot);
        c.label(format_args!("norm_sum"), &norm);
        return [dot, norm];
    }
    tree(c, kernels, &ANGULAR_TREE, ["dot_sum", "norm_sum"], [dots, norms])
}

/// The sum of both halves of the lanes, each rounded once. The halves have as many lanes as an angular beat, so that
/// hardware computes both by the same units.
#[inline(always)]
fn sum_of_halves<C: Circuit, const N: usize>(c: C, lanes: [Num<C>; N]) -> Num<C> {
    begin_sums(c, N / 2);
    c.stage(SUMMED, "sum of each half, rounded once");
    let halves = match N {
        2 => halves::<C, N, 1>(lanes),
        4 => halves::<C, N, 2>(lanes),
        8 => halves::<C, N, 4>(lanes),
        16 => halves::<C, N, 8>(lanes),
        32 => halves::<C, N, 16>(lanes),
        _ => halves::<C, N, 32>(lanes),
    };
    c.label(format_args!("half"), &halves);

    c.stage(SUMMED + 1, "sum of the halves");
    let sum = halves[0] + halves[1];
    c.label(format_args!("sum"), &sum);
    sum
}

/// Describes the stages in which the sums of `terms` terms begin. Two terms are an addition.
#[inline(always)]
fn begin_sums<C: Circuit>(c: C, terms: usize) {
    if terms > 2 {
        c.stage(SUMMED - 2, "terms of the sums aligned");
        c.stage(SUMMED - 1, "terms added");
    }
}

/// The sums of the lower and the upper half of `N` lanes.
#[inline(always)]
fn halves<C: Circuit, const N: usize, const HALF: usize>(lanes: [Num<C>; N]) -> [Num<C>; 2] {
    let half = |first: usize| Num::sum::<HALF>(array_of!(i => lanes[(first + i) % N]));
    [half(0), half(HALF)]
}

/// (a - b)² of each lane.
struct SquaredDifference;

impl LaneMap for SquaredDifference {
    type Shared = ();
    type Item = Lane<Binary32>;
    type Output = Num<Binary32>;

    #[inline(always)]
    fn run<C: Circuit, K: Kernels<C>, const N: usize>(
        &self,
        c: C,
        _kernels: K,
        _shared: &(),
        lanes: &[Lane<C>; N],
    ) -> [Num<C>; N] {
        c.stage(2, "a - b, zero where masked off");
        let difference: [Num<C>; N] = array_of!(i => lanes[i].counts.select(lanes[i].a - lanes[i].b, c.zero()));
        c.label(format_args!("difference"), &difference);

        c.stage(3, "squares");
        array_of!(i => difference[i] * difference[i])
    }
}

/// a·b and b·b of each lane.
struct Products;

impl LaneMap for Products {
    type Shared = ();
    type Item = Lane<Binary32>;
    type Output = [Num<Binary32>; 2];

    #[inline(always)]
    fn run<C: Circuit, K: Kernels<C>, const N: usize>(
        &self,
        c: C,
        _kernels: K,
        _shared: &(),
        lanes: &[Lane<C>; N],
    ) -> [[Num<C>; 2]; N] {
        c.stage(2, "masked lanes to zero");
        let query: [Num<C>; N] = array_of!(i => lanes[i].counts.select(lanes[i].a, c.zero()));
        let candidate: [Num<C>; N] = array_of!(i => lanes[i].counts.select(lanes[i].b, c.zero()));
        c.label(format_args!("query"), &query);
        c.label(format_args!("candidate"), &candidate);

        c.stage(3, "a b and b b");
        let dots: [Num<C>; N] = array_of!(i => query[i] * candidate[i]);
        let norms: [Num<C>; N] = array_of!(i => candidate[i] * candidate[i]);
        array_of!(i => [dots[i], norms[i]])
    }
}

/// The sums of `K` sets of `N` lanes. Each level adds lane i + half to lane i, until one lane is left.
#[inline(always)]
fn tree<C: Circuit, const K: usize, const N: usize>(
    c: C,
    kernels: impl Kernels<C>,
    preference: &[u32],
    names: [&'static str; K],
    mut lanes: [[Num<C>; N]; K],
) -> [Num<C>; K] {
    level::<C, _, K, N, 32>(c, kernels, preference, names, &mut lanes);
    level::<C, _, K, N, 16>(c, kernels, preference, names, &mut lanes);
    level::<C, _, K, N, 8>(c, kernels, preference, names, &mut lanes);
    level::<C, _, K, N, 4>(c, kernels, preference, names, &mut lanes);
    level::<C, _, K, N, 2>(c, kernels, preference, names, &mut lanes);
    level::<C, _, K, N, 1>(c, kernels, preference, names, &mut lanes);
    array_of!(k => lanes[k][0])
}

/// The level of the tree that leaves `HALF` lanes, if the tree has one.
#[inline(always)]
fn level<C: Circuit, F: Kernels<C>, const K: usize, const N: usize, const HALF: usize>(
    c: C,
    kernels: F,
    preference: &[u32],
    names: [&'static str; K],
    lanes: &mut [[Num<C>; N]; K],
) {
    if HALF >= N {
        return;
    }
    c.stage(stage(preference, N, HALF), TREE_TITLE);
    for (name, lanes) in names.into_iter().zip(lanes) {
        let pairs: [[Num<C>; 2]; HALF] = array_of!(i => [lanes[i], lanes[i + HALF]]);
        lanes[..HALF].copy_from_slice(&kernels.map(c, &Sum { name }, &(), &pairs));
    }
}

/// The stage of the level that leaves `half` of `lanes` lanes. Levels take the preferred stages in ascending order.
#[inline(always)]
fn stage(preference: &[u32], lanes: usize, half: usize) -> u32 {
    let (levels, before) = (lanes.ilog2() as usize, (lanes / half).ilog2() as usize - 1);
    let chosen = preference.iter().take(levels);
    let comes_now = |stage: &&u32| chosen.clone().filter(|other| other < stage).count() == before;
    chosen.clone().find(comes_now).copied().unwrap_or_default()
}

/// The sum of lane i and lane i + half. `name` labels it.
struct Sum {
    name: &'static str,
}

impl LaneMap for Sum {
    type Shared = ();
    type Item = [Num<Binary32>; 2];
    type Output = Num<Binary32>;

    #[inline(always)]
    fn run<C: Circuit, K: Kernels<C>, const N: usize>(
        &self,
        c: C,
        _kernels: K,
        _shared: &(),
        pairs: &[[Num<C>; 2]; N],
    ) -> [Num<C>; N] {
        let name = self.name;
        array_of!(i => {
            let sum = pairs[i][0] + pairs[i][1];
            c.label(format_args!("{name}_{N}_{i}"), &sum);
            sum
        })
    }
}

/// The reason why two vectors have no distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum VectorError {
    /// The vectors have different dimensions.
    #[error("a query of {query} dimensions and a candidate of {candidate}, expected as many")]
    Unequal {
        /// Dimensions of the query.
        query: usize,
        /// Dimensions of the candidate.
        candidate: usize,
    },
    /// The vectors have no dimensions.
    #[error("vectors of 0 dimensions, expected at least 1")]
    Empty,
}

impl<const N: usize> Beat<Binary32, N> {
    /// The beats of two vectors, `N` dimensions each. Lanes beyond the end of the vectors are masked off. The last beat
    /// has `reset_accum` set: its result is the distance of the vectors, and the next pair starts at zero.
    ///
    /// ```
    /// use raypath_ops::{Beat, Binary32};
    ///
    /// let beats: Vec<Beat<Binary32, 16>> = Beat::of(&[1.0; 20], &[3.0; 20])?.collect();
    /// assert_eq!(beats.len(), 2);
    /// assert_eq!(beats[1].mask.to_array()[..6], [true, true, true, true, false, false]);
    /// assert!(!bool::from(beats[0].reset_accum) && bool::from(beats[1].reset_accum));
    /// # Ok::<(), raypath_ops::VectorError>(())
    /// ```
    ///
    /// # Errors
    /// Vectors of different dimensions, or of 0 dimensions.
    pub fn of<'v>(query: &'v [f32], candidate: &'v [f32]) -> Result<impl Iterator<Item = Self> + 'v, VectorError> {
        if query.len() != candidate.len() {
            return Err(VectorError::Unequal { query: query.len(), candidate: candidate.len() });
        }
        if query.is_empty() {
            return Err(VectorError::Empty);
        }
        let last = (query.len() - 1) / N;
        let beats = query.chunks(N).zip(candidate.chunks(N)).enumerate();
        Ok(beats.map(move |(index, (a, b))| Self {
            a: lanes(a),
            b: lanes(b),
            mask: Flags::new(std::array::from_fn(|lane| lane < a.len())),
            reset_accum: (index == last).into(),
        }))
    }
}

fn lanes<const N: usize>(chunk: &[f32]) -> [Num<Binary32>; N] {
    std::array::from_fn(|lane| chunk.get(lane).copied().unwrap_or(0.0).into())
}
