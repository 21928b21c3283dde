//! Stimulus and oracle of [`KeyCompare`]: the oracle counts the separators that are not greater than the key.

use crate::{AnyOperationSpec, OperationSpec, draw, exact};
use rand::{Rng, RngExt};
use raypath_ops::Binary32;
use raypath_ops::operations::key_compare::{KeyCompare, KeyCompareInput, KeyCompareOutput, SEPARATORS};

/// The specification of [`KeyCompare`].
pub fn spec() -> AnyOperationSpec {
    OperationSpec::of(KeyCompare)
        .purpose("a key against 36 separators: nodes of B-trees")
        .stimulus(stimulus)
        .oracle("counting", check)
        .into()
}

/// A node with a random number of separators, close together, far apart or equal, and a key at or between them.
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

/// Compares a result with the number of separators that are not greater than the key, counted as ordered integers.
///
/// # Errors
/// A wrong count, or a job whose separators are not sorted, which has no correct result.
pub fn check(job: &KeyCompareInput<Binary32>, answer: &KeyCompareOutput<Binary32>) -> Result<(), String> {
    let separators: Vec<Option<i64>> = job.separator.iter().map(|&separator| exact::order(separator)).collect();
    if !separators.is_sorted_by_key(|separator| separator.unwrap_or(i64::MAX)) {
        return Err("the job's separators are not in ascending order".to_string());
    }
    let key = exact::order(job.key);
    let expected = key.map_or(0, |key| separators.iter().flatten().filter(|&&separator| separator <= key).count());
    let found = u32::from(answer.child_index) as usize;
    if found != expected {
        return Err(format!("child_index is {found}, but the key reaches {expected} separators"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::{check_operation, jobs};
    use raypath_ops::{Operation, Word};

    check_operation!(KeyCompare, KeyCompareInput, KeyCompareOutput);

    fn child(key: f32, separators: &[f32], padding: f32) -> u32 {
        let separator = std::array::from_fn(|i| separators.get(i).copied().unwrap_or(padding).into());
        let job = KeyCompareInput { key: key.into(), separator };
        let (answer, ()) = KeyCompare.run(Binary32, job, ());
        check(&job, &answer).expect("a right answer");
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
                assert!(check(&job, &KeyCompareOutput { child_index: Word::truncate(child) }).is_err());
            }
        }
        let mut job = jobs(stimulus, 1)[0];
        (job.separator[0], job.separator[1]) = (2.0.into(), 1.0.into());
        assert!(check(&job, &KeyCompareOutput { child_index: Word::truncate(0) }).is_err());
    }
}
