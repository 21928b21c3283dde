//! Tests that all operations share: random jobs are checked by the oracle, and all circuits give the same results.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use raypath_float::Format;
use raypath_model::{Soft, SoftNumber};
use raypath_ops::{Binary32, Bit, Concrete, Gather, Num, Scatter, Word};

/// Software arithmetic of binary32.
pub const SOFT: Soft = Soft { format: Format::BINARY32 };

/// `count` random jobs from a stimulus.
pub fn jobs<T>(stimulus: impl Fn(&mut ChaCha8Rng) -> T, count: usize) -> Vec<T> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    (0..count).map(|_| stimulus(&mut rng)).collect()
}

/// Converts from binary32 to software arithmetic, and back.
pub struct ToSoft;

impl Gather<Binary32, Soft, 1> for ToSoft {
    fn num(&self, [value]: [&Num<Binary32>; 1]) -> Num<Soft> {
        Num::new(SOFT, SOFT.number(value.to_bits().into()))
    }
    fn bit(&self, [value]: [&Bit<Binary32>; 1]) -> Bit<Soft> {
        Bit::new(SOFT, value.value)
    }
    fn word<const W: u32>(&self, [value]: [&Word<Binary32, W>; 1]) -> Word<Soft, W> {
        Word::new(SOFT, value.value)
    }
}

impl Scatter<Soft, Binary32, 1> for ToSoft {
    fn num(&self, value: Num<Soft>) -> [Num<Binary32>; 1] {
        let SoftNumber(bits) = value.value;
        [Num::from_bits(bits as u32)]
    }
    fn bit(&self, value: Bit<Soft>) -> [Bit<Binary32>; 1] {
        [value.value.into()]
    }
    fn word<const W: u32>(&self, value: Word<Soft, W>) -> [Word<Binary32, W>; 1] {
        [Word::truncate(value.value)]
    }
}

/// The tests of an operation, with the functions `stimulus` and `check` of its module.
macro_rules! check_operation {
    ($operation:expr, $input:ident, $output:ident) => {
        #[test]
        fn the_oracle_agrees() {
            for (i, job) in crate::test_support::jobs(stimulus, 20_000).iter().enumerate() {
                let (answer, ()) = $operation.run(Binary32, *job, ());
                check(job, &answer).unwrap_or_else(|wrong| panic!("job {i}: {wrong}\n{job:#?}\n{answer:#?}"));
            }
        }

        #[test]
        fn all_circuits_agree() {
            use crate::test_support::{SOFT, ToSoft, jobs};
            use raypath_model::{blank, levels, pack, run_blocks, unpack};
            use raypath_ops::Family;

            let jobs = jobs(stimulus, 16 * 100);
            let answers: Vec<$output<Binary32>> =
                jobs.iter().map(|job| $operation.run(Binary32, *job, ()).0).collect();
            for (job, answer) in jobs.iter().zip(&answers) {
                let (output, ()) = $operation.run(SOFT, <$input<Binary32>>::gather([job], &ToSoft), ());
                let [soft] = <$output<Binary32>>::scatter(output, &ToSoft);
                assert_eq!(soft, *answer, "in software: {job:#?}");
            }
            let blocks = pack::<$input<Binary32>>(&jobs);
            for level in levels() {
                let mut found = vec![blank::<$output<Binary32>>(); blocks.len()];
                fearless_simd::dispatch!(level, simd => run_blocks(simd, &$operation, &blocks, &mut found, &mut ()));
                for (found, answer) in unpack::<$output<Binary32>>(&found, jobs.len()).zip(&answers) {
                    assert_eq!(found, *answer, "{level:?}");
                }
            }
        }
    };
}
pub(crate) use check_operation;
