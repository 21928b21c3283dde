//! A claim that can be verified, and what its verification found.

use crate::error::Error;
use crate::request::Request;

/// A claim about the datapath, its oracle, and the function that checks it.
#[derive(Debug, Clone, Copy)]
pub struct Item {
    /// The item's name on the command line.
    pub name: &'static str,
    /// What is claimed.
    pub claim: &'static str,
    /// What the claim is checked against.
    pub oracle: &'static str,
    /// The files and folders of the repository that the result depends on: what is verified, and what verifies it. A
    /// recorded result is stale once they have changed.
    pub subject: &'static [&'static str],
    /// Checks the claim.
    pub run: fn(&mut Request<'_>) -> Result<Verdict, Error>,
}

/// What a verification covered, and what it found wrong.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Verdict {
    /// What was run or proved, with numbers, in a line: "7,496,192 cases of each of 4 functions".
    pub covered: String,
    /// The first failures, a line each; empty if the claim holds.
    pub failures: Vec<String>,
    /// Further results, a line each: coverage that was not reached, work that was skipped, versions of programs.
    pub remarks: Vec<String>,
    /// Whether the user stopped the run before its end.
    pub is_stopped: bool,
}
