//! Batches of jobs of one operation, computed in SIMD lanes.

use crate::kernels::baseline;
use crate::rounding::ShortLanes;
use crate::{BLOCK, BlockSlice, BlockValue, LaneRounding, Lanes, Native, Packed, SimdKernels, dispatch};
use fearless_simd::{Level, Simd};
use raypath_ops::{
    Angular, AngularOutput, AngularState, BeatInput, Binary32, Bit, Bundle, Circuit, Euclidean, EuclideanOutput,
    EuclideanState, Family, Field, Num, Of, Operation, Path, RayBox, RayBoxInput, RayBoxOutput, RayTriangle,
    RayTriangleInput, RayTriangleOutput, Rounding, Rules, Source, array_of,
};

/// Sixteen functional models over binary32, computed in SIMD lanes. Each returns the results of a
/// [`Functional`](crate::Functional), bit for bit except for the signs and payloads of NaNs. Jobs are in blocks of
/// sixteen, one for each model; see [`pack`] and [`unpack`].
///
/// ```
/// use raypath_model::{Batch, blank, pack, unpack};
/// use raypath_ops::{Aabb, Binary32, Ray, RayBoxInput, RayBoxOutput, Rules};
///
/// let ray = Ray::new([0.0, 0.0, -5.0], [0.0, 0.0, 1.0], f32::INFINITY)?;
/// let job = |x| RayBoxInput { ray, aabb: [Aabb::new([x, -1.0, -1.0], [x + 1.0, 1.0, 1.0]); 4] };
/// let jobs = [0.0, 1.5].map(job);
///
/// let blocks = pack::<RayBoxInput<Binary32>>(&jobs);
/// let mut answers = vec![blank::<RayBoxOutput<Binary32>>(); blocks.len()];
/// Batch::<16, 8>::new(Rules::Paper).quadbox(&blocks, &mut answers);
/// let answers = unpack::<RayBoxOutput<Binary32>>(&answers, jobs.len());
/// let hits: Vec<bool> = answers.map(|answer| answer.is_intersect.to_array()[0]).collect();
/// assert_eq!(hits, [true, false]);
/// # Ok::<(), raypath_ops::RayError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Batch<const E: usize = 16, const A: usize = 8> {
    settings: Settings,
    euclidean: EuclideanState<Packed>,
    angular: AngularState<Packed>,
}

#[derive(Debug, Clone, Copy)]
struct Settings {
    rules: Rules,
    rounding: Rounding,
    is_conservative: bool,
    level: Level,
    short: Option<ShortLanes>,
}

impl<const E: usize, const A: usize> Batch<E, A> {
    /// Sixteen models whose accumulators are zero, for the widest registers of this machine.
    pub fn new(rules: Rules) -> Self {
        Self::at(Level::new(), rules)
    }

    /// As [`new`](Self::new), with the instruction set `level`.
    pub fn at(level: Level, rules: Rules) -> Self {
        let (euclidean, angular) = (EuclideanState::zero(Packed), AngularState::zero(Packed));
        let settings = Settings { rules, rounding: Rounding::Unit, is_conservative: false, level, short: None };
        Self { settings, euclidean, angular }
    }

    /// The same models with another rounding of sums; [`Rounding::Unit`] by default.
    pub fn rounding(self, rounding: Rounding) -> Self {
        Self { settings: Settings { rounding, ..self.settings }, ..self }
    }

    /// The same models with [conservative](RayBox::is_conservative) boxes, or without them as by default.
    pub fn conservative(self, is_conservative: bool) -> Self {
        Self { settings: Settings { is_conservative, ..self.settings }, ..self }
    }

    /// The same models in a short format, for the rules `paper` and `chisel`; sums round after every addition.
    pub fn short(self, short: Option<ShortLanes>) -> Self {
        Self { settings: Settings { short, ..self.settings }, ..self }
    }

    /// Computes blocks of jobs into `answers`; stops at the end of the shorter slice.
    pub fn quadbox(&self, jobs: &[RayBoxInput<Packed>], answers: &mut [RayBoxOutput<Packed>]) {
        quadbox(self.settings, jobs, answers);
    }

    /// Computes blocks of jobs into `answers`; stops at the end of the shorter slice.
    pub fn triangle(&self, jobs: &[RayTriangleInput<Packed>], answers: &mut [RayTriangleOutput<Packed>]) {
        triangle(self.settings, jobs, answers);
    }

    /// Computes blocks of beats in order into `answers`; stops at the end of the shorter slice. The accumulators remain
    /// for the next call.
    pub fn euclidean(&mut self, beats: &[BeatInput<Packed, E>], answers: &mut [EuclideanOutput<Packed>]) {
        by_rounding!(self.settings, |rounding| Euclidean::<E> { rounding }, beats, answers, &mut self.euclidean);
    }

    /// Computes blocks of beats in order into `answers`; stops at the end of the shorter slice. The accumulators remain
    /// for the next call.
    pub fn angular(&mut self, beats: &[BeatInput<Packed, A>], answers: &mut [AngularOutput<Packed>]) {
        by_rounding!(self.settings, |rounding| Angular::<A> { rounding }, beats, answers, &mut self.angular);
    }
}

/// Runs an operation, with a call for each rounding, so that it is a constant in each. Sums that round once are
/// integers in each lane, which wide registers do not make faster.
macro_rules! by_rounding {
    ($settings:expr, $op:expr, $jobs:expr, $answers:expr, $state:expr) => {{
        let (Settings { rounding, level, short, .. }, op) = ($settings, $op);
        match (short, rounding) {
            (Some(lanes), _) => run_blocks_in(lanes, &op(Rounding::Unit), $jobs, $answers, $state),
            (None, Rounding::Unit) => {
                dispatch!(level, simd => run_blocks(simd, &op(Rounding::Unit), $jobs, $answers, $state));
            }
            (None, Rounding::Sum) => run_blocks(baseline(), &op(Rounding::Sum), $jobs, $answers, $state),
        }
    }};
}
use by_rounding;

/// Boxes, with a call for each of the rules, so that they are constants in each. Not generic, so that other crates do not
/// compile it once more.
fn quadbox(settings: Settings, jobs: &[RayBoxInput<Packed>], answers: &mut [RayBoxOutput<Packed>]) {
    let Settings { rules, is_conservative, level, short, .. } = settings;
    let op = |rules| RayBox { rules, is_conservative };
    match (short, rules) {
        (Some(lanes), Rules::Chisel) => run_blocks_in(lanes, &op(Rules::Chisel), jobs, answers, &mut ()),
        (Some(lanes), _) => run_blocks_in(lanes, &op(Rules::Paper), jobs, answers, &mut ()),
        (None, Rules::Paper) => {
            dispatch!(level, simd => run_blocks(simd, &op(Rules::Paper), jobs, answers, &mut ()));
        }
        // For comparisons with the original, which need no wide registers.
        (None, Rules::Chisel) => run_blocks(baseline(), &op(Rules::Chisel), jobs, answers, &mut ()),
        (None, Rules::Bounds(bits)) => {
            dispatch!(level, simd => run_blocks(simd, &op(Rules::Bounds(bits)), jobs, answers, &mut ()));
        }
    }
}

/// Triangles; see [`quadbox`].
fn triangle(settings: Settings, jobs: &[RayTriangleInput<Packed>], answers: &mut [RayTriangleOutput<Packed>]) {
    let op = |rounding| RayTriangle { rules: settings.rules, rounding };
    by_rounding!(settings, op, jobs, answers, &mut ());
}

/// The instruction sets with which this machine can run a [`Batch`], the widest first.
pub fn levels() -> Vec<Level> {
    let best = Level::new();
    #[cfg(target_arch = "x86_64")]
    let levels = [best.as_avx512().map(Simd::level), best.as_avx2().map(Simd::level), best.as_sse2().map(Simd::level)];
    #[cfg(not(target_arch = "x86_64"))]
    let levels = [Some(best)];
    levels.into_iter().flatten().collect()
}

/// Packs jobs into blocks of sixteen. The last block is filled with copies of the last job.
pub fn pack<F: Family>(jobs: &[Of<F, Binary32>]) -> Vec<Of<F, Packed>> {
    let block = |jobs: &[Of<F, Binary32>]| F::gather(array_of!(i => &jobs[i.min(jobs.len() - 1)]), &Packed);
    jobs.chunks(BLOCK).map(block).collect()
}

/// Unpacks the first `count` items of blocks, or all if there are fewer.
pub fn unpack<F: Family>(blocks: &[Of<F, Packed>], count: usize) -> impl Iterator<Item = Of<F, Binary32>> {
    let jobs = |block: &Of<F, Packed>| -> [Of<F, Binary32>; BLOCK] { F::scatter(*block, &Packed) };
    blocks.iter().flat_map(jobs).take(count)
}

/// A block of zeros, into which results are written.
pub fn blank<F: Family>() -> Of<F, Packed> {
    <Of<F, Packed> as Bundle<Packed>>::build(&mut Path::unnamed(), &mut Zeros)
}

struct Zeros;

impl Source<Packed> for Zeros {
    fn num(&mut self, _: Field<'_>) -> Num<Packed> {
        Packed.zero()
    }
    fn bit(&mut self, _: Field<'_>) -> Bit<Packed> {
        Packed.bit(false)
    }
    fn word(&mut self, _: Field<'_>, width: u32) -> (Packed, BlockValue<u32>) {
        (Packed, Packed.constant_word(width, 0))
    }
}

/// Runs an operation on blocks of jobs into `answers`; stops at the end of the shorter slice. Each lane has its own
/// state. Call it inside [`dispatch`].
#[inline(always)]
pub fn run_blocks<S: Simd, O: Operation>(
    simd: S,
    op: &O,
    jobs: &[O::Input<Packed>],
    answers: &mut [O::Output<Packed>],
    state: &mut O::State<Packed>,
) where
    O::Input<Binary32>: Family<Of<Packed> = O::Input<Packed>, Of<Lanes<S>> = O::Input<Lanes<S>>>,
    O::Output<Binary32>: Family<Of<Packed> = O::Output<Packed>, Of<Lanes<S>> = O::Output<Lanes<S>>>,
    O::State<Binary32>: Family<Of<Packed> = O::State<Packed>, Of<Lanes<S>> = O::State<Lanes<S>>>,
{
    run_blocks_in(Lanes::new(simd), op, jobs, answers, state);
}

/// As [`run_blocks`], over lanes that may round their results.
#[inline(always)]
pub fn run_blocks_in<S: Simd, R: LaneRounding<S, Native>, O: Operation>(
    lanes: Lanes<S, Native, R>,
    op: &O,
    jobs: &[O::Input<Packed>],
    answers: &mut [O::Output<Packed>],
    state: &mut O::State<Packed>,
) where
    O::Input<Binary32>: Family<Of<Packed> = O::Input<Packed>, Of<Lanes<S, Native, R>> = O::Input<Lanes<S, Native, R>>>,
    O::Output<Binary32>:
        Family<Of<Packed> = O::Output<Packed>, Of<Lanes<S, Native, R>> = O::Output<Lanes<S, Native, R>>>,
    O::State<Binary32>: Family<Of<Packed> = O::State<Packed>, Of<Lanes<S, Native, R>> = O::State<Lanes<S, Native, R>>>,
{
    for first in (0..BLOCK).step_by(Lanes::<S>::COUNT) {
        let part = BlockSlice { lanes, first };
        let mut now = <O::State<Binary32> as Family>::gather([&*state], &part);
        for (job, answer) in jobs.iter().zip(&mut *answers) {
            let input = <O::Input<Binary32> as Family>::gather([job], &part);
            let (output, next) = op.run_with(lanes, SimdKernels, input, now);
            <O::Output<Binary32> as Family>::put(&output, answer, &part);
            now = next;
        }
        <O::State<Binary32> as Family>::put(&now, state, &part);
    }
}
