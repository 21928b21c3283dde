//! A claim that can be verified.

use crate::{Error, Request, Verdict};

/// What is claimed, by what it is judged, and how it is run.
#[derive(Debug, Clone, Copy)]
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
