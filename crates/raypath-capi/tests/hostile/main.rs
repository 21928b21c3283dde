//! The C interface with hostile arguments. `fuzz` makes the same calls.

mod calls;

use calls::calls;
use rand::rngs::ChaCha8Rng;
use rand::{Rng, RngExt, SeedableRng};

#[test]
fn random_calls_end_with_a_status_and_change_nothing_if_they_fail() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut succeeded = 0;
    for _ in 0..4000 {
        let mut bytes = vec![0; rng.random_range(0..400)];
        rng.fill_bytes(&mut bytes);
        succeeded += u32::from(calls(&bytes));
    }
    // Otherwise only the first checks would run.
    assert!(succeeded > 1000, "{succeeded}");
}
