//! All that can be verified, item by item: what is claimed, by what it is judged, and how it is run.
//!
//! `docs/verification.md` has the same items with their results.

use raypath_verify::unit_proofs;
pub use raypath_verify::{Error, Level, Request, Shard, ShardError, Step, Verdict};

/// A claim that can be verified.
pub struct Item {
    /// What it is called on the command line.
    pub name: &'static str,
    /// What is claimed.
    pub claim: &'static str,
    /// By what it is judged: something that shares no code with what is verified.
    pub oracle: &'static str,
    /// Verifies it.
    pub run: fn(&mut Request<'_>) -> Result<Verdict, Error>,
}

/// All items, in the order of `docs/verification.md`.
pub const ITEMS: &[Item] = &[
    Item {
        name: "unit-proofs",
        claim: "adders, multipliers, comparison and conversions do for all operands what IEEE 754 says, and in parts what \
                they do whole",
        oracle: "Yosys's symfpu, by SAT (ABC)",
        run: unit_proofs::unit_proofs,
    },
    Item {
        name: "adder-proof",
        claim: "the binary32 adder gives IEEE 754's sum for all operands",
        oracle: "Yosys's symfpu, by SAT (ABC), for each of the 511 differences of exponents",
        run: unit_proofs::adder_proof,
    },
    Item {
        name: "multiplier-proof",
        claim: "the binary16 multiplier gives IEEE 754's product for all operands",
        oracle: "Yosys's symfpu, by SAT (ABC), for each of the 1024 fractions of the second operand",
        run: unit_proofs::multiplier_proof,
    },
];
