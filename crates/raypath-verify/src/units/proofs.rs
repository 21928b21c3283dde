//! Proofs that floating-point units are equivalent to IEEE 754's operations, which Yosys's command `symfpu` generates
//! for any format.
//!
//! A proof covers a unit between our encoders and our decoder, because units compute in the recoded format; the
//! operands in IEEE 754's format are free. As a negative control, the same commands must refute the claim for a unit
//! with a deliberate fault.

mod cache;
mod cases;
mod claim;
mod result;

pub use cases::{CASES_FOLDER, adder_proof, multiplier_proof};
pub use claim::{Claim, Fault, Operands, Subject};
pub use result::{ClaimResult, check};

use crate::error::Error;
use crate::request::{Level, Request};
use crate::sat::Prover;
use crate::verdict::{Item, Verdict};
use raypath_float::Format;
use raypath_tools::pool;
use std::time::Duration;

/// The sources that each proof's result depends on.
const SUBJECT: &[&str] = &[
    "crates/raypath-float/src",
    "crates/raypath-hdl/src",
    "crates/raypath-verify/src/sat",
    "crates/raypath-verify/src/units",
];

/// Proofs of all units, in formats that are small enough for one proof each.
pub const UNIT_PROOFS: Item = Item {
    name: "unit-proofs",
    claim: "adders, multipliers, comparison and conversions give IEEE 754's result for all operands; split units give \
            the result of the unsplit ones",
    oracle: "Yosys's symfpu, by SAT (ABC)",
    subject: SUBJECT,
    run: unit_proofs,
};

/// The proof of the binary32 adder, in cases.
pub const ADDER_PROOF: Item = Item {
    name: "adder-proof",
    claim: "the binary32 adder gives IEEE 754's sum for all operands",
    oracle: "Yosys's symfpu, by SAT (ABC), for each of the 511 differences of exponents",
    subject: SUBJECT,
    run: adder_proof,
};

/// The proof of the binary16 multiplier, in cases.
pub const MULTIPLIER_PROOF: Item = Item {
    name: "multiplier-proof",
    claim: "the binary16 multiplier gives IEEE 754's product for all operands",
    oracle: "Yosys's symfpu, by SAT (ABC), for each of the 1024 fractions of the second operand",
    subject: SUBJECT,
    run: multiplier_proof,
};

/// Proves the level's claims. Shards divide the claims.
///
/// # Errors
/// A program is missing or fails.
pub fn unit_proofs(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let prover = Prover::find()?;
    let mut claims: Vec<Claim> = claims(request.level).collect();
    let shard = request.shard;
    let mut number = 0..;
    claims.retain(|_| number.next().is_some_and(|number| shard.takes(number)));
    let limit = Duration::from_secs(request.level.pick(300, 1800, 7200));
    let total = claims.len();
    let found =
        pool::map(&claims, pool::ALL_CORES, request.proceed, |claim, stop| check(&prover, *claim, true, limit, stop))?;
    let results: Vec<ClaimResult> = found.into_iter().flatten().collect();
    let proved: Vec<String> =
        results.iter().filter(|done| done.outcome.is_ok()).map(|done| done.claim.to_string()).collect();
    let covered = match proved.len() {
        0 => "nothing proved".to_string(),
        count => format!("{count} proofs, and as many faults refuted: {}", proved.join("; ")),
    };
    Ok(Verdict {
        covered,
        failures: results.iter().filter_map(|done| done.outcome.clone().err()).collect(),
        remarks: std::iter::once(format!("with {}", prover.versions()))
            .chain(results.iter().filter_map(ClaimResult::fault_remark))
            .collect(),
        is_stopped: results.len() < total,
    })
}

/// The claims of a level, the longest proofs first. Each level includes the claims of the shorter ones.
fn claims(level: Level) -> impl Iterator<Item = Claim> {
    use Subject::{Add, AddParts, Compare, Mul, MulParts, RoundTrip, Sub};
    const CLAIMS: &[(Level, Subject, u32, u32)] = &[
        (Level::Full, Add, 5, 11),
        (Level::Full, Sub, 5, 11),
        (Level::Full, Mul, 8, 8),
        (Level::Full, Mul, 5, 8),
        (Level::Full, Add, 8, 11),
        (Level::Full, Sub, 8, 11),
        (Level::Full, Add, 8, 8),
        (Level::Full, Sub, 8, 8),
        (Level::Full, Mul, 5, 6),
        (Level::Full, Mul, 4, 5),
        (Level::Full, Mul, 5, 4),
        (Level::Full, Mul, 4, 4),
        (Level::Full, Add, 4, 4),
        (Level::Full, Compare, 8, 8),
        (Level::Full, Compare, 8, 11),
        (Level::Full, RoundTrip, 8, 8),
        (Level::Full, RoundTrip, 8, 11),
        (Level::Full, MulParts(2), 8, 24),
        (Level::Full, MulParts(3), 8, 24),
        (Level::Full, AddParts(2), 8, 24),
        (Level::Full, AddParts(3), 8, 24),
        (Level::Regression, Compare, 8, 24),
        (Level::Regression, Compare, 5, 11),
        (Level::Regression, Add, 3, 4),
        (Level::Regression, Sub, 3, 4),
        (Level::Regression, Mul, 3, 4),
        (Level::Regression, RoundTrip, 8, 24),
        (Level::Regression, RoundTrip, 5, 11),
    ];
    let chosen = CLAIMS.iter().filter(move |(least, ..)| level >= *least);
    chosen.filter_map(|&(_, subject, exponent, significand)| {
        Some(Claim::all(subject, Format::new(exponent, significand).ok()?))
    })
}
