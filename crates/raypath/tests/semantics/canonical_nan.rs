//! A NaN at an output is 7fc00000 for every NaN at the inputs. (`answers` checks the raw bits of the netlist in every
//! test; the jobs here make every output number a NaN.)

use crate::semantics::answers::{answers, numbers};
use crate::semantics::random::mixed_jobs;
use raypath::ops::{Job, JobKind, Num, Outcome, Rules};

const NANS: [u32; 7] = [0x7fc0_0000, 0xffc0_0000, 0x7f80_0001, 0xff80_0001, 0x7fff_ffff, 0xffff_ffff, 0x7fd5_5555];

/// A job with this NaN in all numbers and with all lanes on.
fn full_of(nan: u32, kind: JobKind) -> Job {
    Job::from_ports(kind, |name| match name {
        _ if name.ends_with("mask") || name.ends_with("accum") => u64::MAX,
        _ if name.starts_with("ray_k") => 0,
        _ => nan.into(),
    })
}

#[test]
fn every_nan_result_is_canonical() {
    for rules in [Rules::Paper, Rules::Chisel] {
        for nan in NANS {
            let jobs = JobKind::ALL.map(|kind| full_of(nan, kind));
            for outcome in answers(rules, &jobs) {
                let bits: Vec<u32> = numbers(&outcome).into_iter().map(Num::to_bits).collect();
                // Distances of boxes are never NaN: +∞ for a miss, at least 0 for a hit.
                let expected = if outcome.kind() == JobKind::Quadbox { 0x7f80_0000 } else { 0x7fc0_0000 };
                assert!(bits.iter().all(|&b| b == expected), "{nan:08x}: {outcome:?}");
            }
        }
    }
}

#[test]
fn one_nan_input_makes_canonical_nans() {
    let mut seen = [0; 4];
    for outcome in answers(Rules::Paper, &mixed_jobs(8000, 1)) {
        let nans = numbers(&outcome).into_iter().filter(|number| f32::from(*number).is_nan());
        seen[outcome.kind() as usize] += nans.inspect(|nan| assert_eq!(nan.to_bits(), 0x7fc0_0000)).count();
        if let Outcome::Quadbox(boxes) = outcome {
            assert!(boxes.tmin.iter().all(|&t| f32::from(t) >= 0.0 && t.to_bits() != 0x8000_0000));
        }
    }
    let [triangle, quadbox, euclidean, angular] = seen;
    assert!(triangle > 100 && euclidean > 100 && angular > 100, "{seen:?}");
    assert_eq!(quadbox, 0);
}
