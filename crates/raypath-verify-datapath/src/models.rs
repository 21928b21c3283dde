//! The functional model against the oracle, and the cycle-exact model against the functional one, job by job.
//!
//! Without a chosen configuration, the default one runs many jobs against the [quick oracle](crate::oracle::quick), and
//! every datapath of [`subjects`] runs some against the [exact one](crate::oracle).

mod exact;
mod failure;
mod in_order;
mod quick;

use crate::subjects::{self, Subject};
use raypath_verify::{Error, Request, Verdict};
use std::path::Path;

/// Runs the jobs. Writes a failure to a subfolder of `folder`.
///
/// # Errors
/// A configuration cannot be elaborated, or a file cannot be written.
pub fn verify(request: &mut Request<'_>, folder: &Path) -> Result<Verdict, Error> {
    if request.is_chosen {
        let jobs = request.jobs.unwrap_or(request.level.pick(100_000, 4_000_000, 40_000_000));
        return exact::verify(request, &[Subject::of(request)], jobs, folder);
    }
    let many = quick::verify(request, folder)?;
    if many.is_stopped {
        return Ok(many);
    }
    let jobs = request.level.pick(2_000, 40_000, 400_000);
    let each = exact::verify(request, &subjects::all(), jobs, folder)?;
    Ok(Verdict {
        covered: format!("{}; {}", many.covered, each.covered),
        failures: [many.failures, each.failures].concat(),
        remarks: [many.remarks, each.remarks].concat(),
        is_stopped: each.is_stopped,
    })
}
