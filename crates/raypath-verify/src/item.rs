//! A claim, its oracle, and the function that checks it.

use crate::{Error, Request, Verdict};

/// A claim about the hardware or the models, its oracle, and the function that checks it.
#[derive(Debug, Clone, Copy)]
pub struct Item {
    /// The item's name on the command line.
    pub name: &'static str,
    /// What is claimed.
    pub claim: &'static str,
    /// What the claim is checked against.
    pub oracle: &'static str,
    /// Whether the request's configuration changes what is checked.
    pub has_configuration: bool,
    /// Checks the claim with the request's shard of the work.
    pub run: fn(&mut Request<'_>) -> Result<Verdict, Error>,
}
