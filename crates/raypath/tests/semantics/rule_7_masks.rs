//! Ruling 7: a masked-off lane contributes +0.0 for any contents.

use crate::semantics::answers::answers;
use raypath::ops::{Beat, BeatInput, Flags, Job, Num, Outcome, Rules};

const HOLDS: [u32; 10] = [
    0x7fc0_0000,
    0xffc0_1234,
    0x7f80_0001, // NaNs, one of them signalling
    0x7f80_0000,
    0xff80_0000, // infinities
    0x7f7f_ffff,
    0xff7f_ffff, // whose squares overflow
    0x0000_0001,
    0x8000_0000,
    0x42f6_0000,
];

fn beat<const N: usize>(a: [u32; N], b: [u32; N], mask: u64) -> Beat<raypath::ops::Binary32, N> {
    Beat { a: a.map(Num::from_bits), b: b.map(Num::from_bits), mask: Flags::from_mask(mask), reset_accum: true.into() }
}

fn sums(outcome: &Outcome) -> Vec<u32> {
    crate::semantics::answers::numbers(outcome).into_iter().map(Num::to_bits).collect()
}

/// One masked-off lane at a time has such a number in a, in b, or in both; the others are 3 and 1.
#[test]
fn a_masked_off_lane_counts_for_nothing() {
    let (three, one) = (3f32.to_bits(), 1f32.to_bits());
    let mut jobs = Vec::new();
    let mut expected = Vec::new();
    for held in HOLDS {
        for which in 1..4 {
            for lane in 0..16 {
                let (mut a, mut b) = ([three; 16], [one; 16]);
                if which & 1 == 1 {
                    a[lane] = held;
                }
                if which & 2 == 2 {
                    b[lane] = held;
                }
                jobs.push(Job::Euclidean(BeatInput { euclidean: beat(a, b, !(1 << lane)) }));
                expected.push(vec![60f32.to_bits()]); // 15 · (3 − 1)²
                if lane < 8 {
                    let half = |v: [u32; 16]| std::array::from_fn(|i| v[i]);
                    jobs.push(Job::Angular(BeatInput { euclidean: beat::<8>(half(a), half(b), !(1 << lane)) }));
                    expected.push(vec![21f32.to_bits(), 7f32.to_bits()]); // 7 · 3·1, 7 · 1²
                }
            }
        }
    }
    for rules in [Rules::Paper, Rules::Chisel] {
        for (i, outcome) in answers(rules, &jobs).iter().enumerate() {
            assert_eq!(sums(outcome), expected[i], "job {i}: {:?}", jobs[i]);
        }
    }
}

/// With all lanes off the sum is +0.0, bit for bit.
#[test]
fn a_beat_without_lanes_is_plus_zero() {
    for held in HOLDS {
        let jobs = [
            Job::Euclidean(BeatInput { euclidean: beat([held; 16], [held; 16], 0) }),
            Job::Angular(BeatInput { euclidean: beat([held; 8], [held; 8], 0) }),
        ];
        let outcomes = answers(Rules::Paper, &jobs);
        assert_eq!(sums(&outcomes[0]), [0]);
        assert_eq!(sums(&outcomes[1]), [0, 0]);
    }
}

/// A lane that is not masked off contributes its NaN and infinities to the sum.
#[test]
fn a_lane_that_counts_contributes_what_it_holds() {
    for lane in 0..8 {
        let mut a = [1f32.to_bits(); 16];
        a[lane] = 0xff80_0000;
        let low = std::array::from_fn(|i| a[i]);
        let jobs = [
            Job::Euclidean(BeatInput { euclidean: beat(a, [0; 16], !0) }),
            Job::Angular(BeatInput { euclidean: beat::<8>(low, [1f32.to_bits(); 8], !0) }),
            Job::Angular(BeatInput { euclidean: beat::<8>(low, [0; 8], !0) }),
        ];
        let outcomes = answers(Rules::Paper, &jobs);
        assert_eq!(sums(&outcomes[0]), [0x7f80_0000]);
        assert_eq!(sums(&outcomes[1]), [0xff80_0000, 8f32.to_bits()]);
        assert_eq!(sums(&outcomes[2]), [0x7fc0_0000, 0], "−∞·0");
    }
}
