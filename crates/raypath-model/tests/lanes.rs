//! Jobs side by side in SIMD lanes, with every instruction set that this machine has, against the same jobs one by one
//! in software arithmetic.

use crate::common::EDGES;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_float::Format;
use raypath_model::{Batch, Functional, Packed, Soft, blank, levels, pack, unpack};
use raypath_ops::{
    AngularOutput, BeatInput, Binary32, BoxBits, EuclideanOutput, Family, Job, JobKind, Of, Operation, Outcome, RayBox,
    RayBoxInput, RayBoxOutput, RayTriangleInput, RayTriangleOutput, Rounding, Rules,
};

const JOBS: usize = 16 * 200;

/// Words of random jobs: ordinary numbers of both signs, many edges among them, and equal ones.
fn words(kind: JobKind, seed: u64) -> Vec<Vec<u64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut words = Vec::new();
    Job::<16, 8>::from_words_in(Binary32, kind, &[]).words(&mut words);
    let count = words.len();
    (0..JOBS)
        .map(|_| {
            let edges = [0.0, 0.02, 0.3][rng.random_range(0..3)];
            let mut job: Vec<u64> = (0..count)
                .map(|_| match rng.random_bool(edges) {
                    true => EDGES[rng.random_range(0..EDGES.len())].into(),
                    false => rng.random_range(-2.0f32..2.0).to_bits().into(),
                })
                .collect();
            if let JobKind::Euclidean | JobKind::Angular = kind {
                // The last two words are the mask and the end of a vector.
                job[count - 2] = if rng.random_bool(0.5) { u64::MAX } else { rng.random() };
                job[count - 1] = rng.random_bool(0.2).into();
            } else if rng.random_bool(0.3) {
                let from = rng.random_range(0..count);
                job[rng.random_range(0..count)] = job[from];
            }
            job
        })
        .collect()
}

/// The outcomes in software arithmetic, one job after another, in canonical words. Every sixteenth job uses the same
/// model, as in a block.
/// All rules, and several widths of boxes.
const RULES: [Rules; 6] = [
    Rules::Paper,
    Rules::Chisel,
    Rules::Bounds(BoxBits(8)),
    Rules::Bounds(BoxBits(12)),
    Rules::Bounds(BoxBits(13)),
    Rules::Bounds(BoxBits(24)),
];

fn answers(kind: JobKind, rules: Rules, rounding: Rounding, jobs: &[Vec<u64>]) -> Vec<Vec<u64>> {
    let soft = Soft { format: Format::BINARY32 };
    let mut datapaths = vec![Functional::<16, 8, Soft>::over(soft, rules).rounding(rounding); 16];
    let answer = |(i, words): (usize, &Vec<u64>)| {
        let mut answered = Vec::new();
        datapaths[i % 16].run(&Job::from_words_in(soft, kind, words)).words(&mut answered);
        answered
    };
    jobs.iter().enumerate().map(answer).collect()
}

fn check<I, O>(
    kind: JobKind,
    jobs: &[Vec<u64>],
    input: impl Fn(Job) -> Of<I, Binary32>,
    run: impl Fn(&mut Batch, &[Of<I, Packed>], &mut [Of<O, Packed>]),
    output: impl Fn(Of<O, Binary32>) -> Outcome,
) where
    I: Family,
    O: Family,
{
    let inputs: Vec<Of<I, Binary32>> =
        jobs.iter().map(|words| input(Job::from_words_in(Binary32, kind, words))).collect();
    let blocks = pack::<I>(&inputs);
    let cases = RULES.map(|rules| (rules, Rounding::Unit)).into_iter().chain([(Rules::Paper, Rounding::Sum)]);
    for (rules, rounding) in cases {
        let expected = answers(kind, rules, rounding, jobs);
        for level in levels() {
            let mut batch = Batch::at(level, rules).rounding(rounding);
            let mut outputs = vec![blank::<O>(); blocks.len()];
            // In two calls, between which the sums remain.
            let (first, rest) = outputs.split_at_mut(7);
            run(&mut batch, &blocks[..7], first);
            run(&mut batch, &blocks[7..], rest);
            for (i, (answer, expected)) in unpack::<O>(&outputs, JOBS).zip(&expected).enumerate() {
                let mut words = Vec::new();
                output(answer).words(&mut words);
                assert_eq!(words, *expected, "{kind} job {i}, {rules}, rounding {rounding}, {level:?}: {:x?}", jobs[i]);
            }
        }
    }
}

/// Defines a test of the jobs of one kind.
macro_rules! side_by_side {
    ($test:ident, $kind:ident, $seed:literal, $method:ident, $input:ty, $output:ty) => {
        #[test]
        fn $test() {
            let input = |job| if let Job::$kind(input) = job { input } else { unreachable!() };
            let jobs = words(JobKind::$kind, $seed);
            check::<$input, $output>(
                JobKind::$kind,
                &jobs,
                input,
                |batch, jobs, outputs| batch.$method(jobs, outputs),
                Outcome::$kind,
            );
        }
    };
}

side_by_side!(boxes_side_by_side, Quadbox, 1, quadbox, RayBoxInput<Binary32>, RayBoxOutput<Binary32>);
side_by_side!(triangles_side_by_side, Triangle, 2, triangle, RayTriangleInput<Binary32>, RayTriangleOutput<Binary32>);
side_by_side!(euclidean_beats_side_by_side, Euclidean, 3, euclidean, BeatInput<Binary32, 16>, EuclideanOutput<Binary32>);
side_by_side!(angular_beats_side_by_side, Angular, 4, angular, BeatInput<Binary32, 8>, AngularOutput<Binary32>);

/// Computing over blocks directly gives the same results.
#[test]
fn blocks_compute_as_jobs_do() {
    let jobs: Vec<Vec<u64>> = words(JobKind::Quadbox, 5);
    let inputs: Vec<_> = jobs
        .iter()
        .map(|words| match Job::<16, 8>::from_words_in(Binary32, JobKind::Quadbox, words) {
            Job::Quadbox(input) => input,
            _ => unreachable!(),
        })
        .collect();
    let run =
        |block: &RayBoxInput<Packed>| RayBox { rules: Rules::Paper, is_conservative: false }.run(Packed, *block, ()).0;
    let blocks: Vec<_> = pack::<RayBoxInput<Binary32>>(&inputs).iter().map(run).collect();
    for (answer, expected) in unpack::<RayBoxOutput<Binary32>>(&blocks, JOBS).zip(answers(
        JobKind::Quadbox,
        Rules::Paper,
        Rounding::Unit,
        &jobs,
    )) {
        let mut words = Vec::new();
        Outcome::Quadbox(answer).words(&mut words);
        assert_eq!(words, expected);
    }
}
