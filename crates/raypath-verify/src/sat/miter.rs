//! A circuit whose output must never be 1, and the result of a proof.

use std::collections::BTreeMap;

/// A circuit whose output must never be 1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Miter {
    /// The problem's name in messages.
    pub name: String,
    /// SystemVerilog texts, by the file names that `commands` use.
    pub sources: Vec<(String, String)>,
    /// Commands for Yosys, a line each, that leave the module `miter` with one output of one bit.
    pub commands: Vec<String>,
    /// The inputs of `miter`, with their widths. Other inputs are an error: an undriven wire would be an input.
    pub inputs: Vec<(String, u32)>,
}

/// The result of a proof.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ProofResult {
    /// The output is 0 for all inputs.
    Proved {
        /// And-gates of the miter; 0 if the conversion to gates already reduced it to the constant 0.
        gates: u64,
    },
    /// The output is 1 for these inputs, by name.
    Refuted(BTreeMap<String, u64>),
    /// ABC gave up, for this reason.
    Undecided(String),
    /// The run was stopped.
    Stopped,
}

/// The prefix of a source's file name in [`Miter::commands`].
pub const SOURCE: &str = "@/";
