//! Floating-point units proved equal to an independent specification: IEEE 754's operations as Yosys's command `symfpu`
//! writes them, for any format.
//!
//! The units calculate in the recoded format, so that what is proved is a unit between our encoders and our decoder, with
//! all operands in IEEE 754's layout free. Every claim is refuted for a unit with a deliberate fault, by the same
//! commands, before it counts.

mod cases;
mod claim;
mod judged;
mod kept;

pub use cases::{CASES_FOLDER, adder_proof, multiplier_proof};
pub use claim::{Claim, Fault, Operands, Subject};
pub use judged::{Judged, judge};

use crate::proof::{Prover, pool};
use crate::{Error, Item, Level, Request, Step, Verdict};
use raypath_float::Format;
use std::time::Duration;

/// Every unit, in formats that a proof reaches whole.
pub const UNIT_PROOFS: Item = Item {
    name: "unit-proofs",
    claim: "adders, multipliers, comparison and conversions do for all operands what IEEE 754 says, and in parts what \
            they do whole",
    oracle: "Yosys's symfpu, by SAT (ABC)",
    run: unit_proofs,
};

/// The adder of binary32, in cases.
pub const ADDER_PROOF: Item = Item {
    name: "adder-proof",
    claim: "the binary32 adder gives IEEE 754's sum for all operands",
    oracle: "Yosys's symfpu, by SAT (ABC), for each of the 511 differences of exponents",
    run: adder_proof,
};

/// The multiplier of binary16, in cases.
pub const MULTIPLIER_PROOF: Item = Item {
    name: "multiplier-proof",
    claim: "the binary16 multiplier gives IEEE 754's product for all operands",
    oracle: "Yosys's symfpu, by SAT (ABC), for each of the 1024 fractions of the second operand",
    run: multiplier_proof,
};

/// Proves what the level asks for of every unit. The work is divided by claims.
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
    let watch = |done: usize| (request.watch)(Step { done: done as u64, total: total as u64 });
    let found = pool::for_each(&claims, |claim, stop| judge(&prover, *claim, true, limit, stop), watch)?;
    let judged: Vec<Judged> = found.into_iter().flatten().collect();
    let proved: Vec<String> =
        judged.iter().filter(|judged| judged.result.is_ok()).map(|judged| judged.claim.to_string()).collect();
    let covered = match proved.len() {
        0 => "nothing proved".to_string(),
        count => format!("{count} proofs, and as many faults refuted: {}", proved.join("; ")),
    };
    Ok(Verdict {
        covered,
        failures: judged.iter().filter_map(|judged| judged.result.clone().err()).collect(),
        remarks: std::iter::once(format!("with {}", prover.versions()))
            .chain(
                judged
                    .iter()
                    .filter_map(|judged| Some(format!("a deliberate fault is seen: {}", judged.seen.clone()?))),
            )
            .collect(),
        is_stopped: judged.len() < total,
    })
}

/// What is proved, the longest first; each level proves what those before it do.
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
        (Level::Everyday, Compare, 8, 24),
        (Level::Everyday, Compare, 5, 11),
        (Level::Everyday, Add, 3, 4),
        (Level::Everyday, Sub, 3, 4),
        (Level::Everyday, Mul, 3, 4),
        (Level::Everyday, RoundTrip, 8, 24),
        (Level::Everyday, RoundTrip, 5, 11),
    ];
    let chosen = CLAIMS.iter().filter(move |(least, ..)| level >= *least);
    chosen.filter_map(|&(_, subject, exponent, significand)| {
        Some(Claim::all(subject, Format::new(exponent, significand).ok()?))
    })
}
