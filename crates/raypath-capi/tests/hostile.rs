//! The C interface with hostile arguments. `fuzz` makes the same calls.

mod calls;

use calls::calls;
use rand::rngs::ChaCha8Rng;
use rand::{Rng, RngExt, SeedableRng};
use raypath_capi::{
    RAYPATH_OK, UnitCounts, raypath_unit_close, raypath_unit_model_counts, raypath_unit_model_free,
    raypath_unit_model_new, raypath_unit_model_skip, raypath_unit_open,
};
use std::ptr::null_mut;

#[test]
fn random_calls_end_with_a_status_and_change_nothing_if_they_fail() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut succeeded = 0;
    for _ in 0..1500 {
        let mut bytes = vec![0; rng.random_range(0..400)];
        rng.fill_bytes(&mut bytes);
        succeeded += u32::from(calls(&bytes));
    }
    // Otherwise only the first checks would run.
    assert!(succeeded > 400, "{succeeded}");
}

/// A count of cycles ends at the greatest number, and does not begin again at zero.
#[test]
fn cycles_beyond_the_greatest_number_are_not_lost() {
    let (mut unit, mut model, mut counts) = (null_mut(), null_mut(), UnitCounts::default());
    // SAFETY: a string, and pointers to objects that are used until they are freed.
    unsafe {
        assert_eq!(raypath_unit_open(c"contexts = 8".as_ptr(), &mut unit), RAYPATH_OK);
        assert_eq!(raypath_unit_model_new(unit, &mut model), RAYPATH_OK);
        assert_eq!(raypath_unit_model_skip(model, 5), 5);
        assert_eq!(raypath_unit_model_skip(model, u64::MAX), u64::MAX);
        assert_eq!(raypath_unit_model_counts(model, &mut counts), RAYPATH_OK);
        raypath_unit_model_free(model);
        raypath_unit_close(unit);
    }
    assert_eq!(counts.cycles, u64::MAX);
}
