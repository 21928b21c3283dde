//! What oracles say, for those who read it.

use crate::checks::{Checks, Judged};
use crate::error::LabError;
use std::io::Write;

/// Holds the answers of each operation against its oracle, and says on `out` what it found.
///
/// # Errors
/// A wrong answer; `out` that cannot be written.
pub fn ask_oracles(checks: &Checks<'_>, out: &mut dyn Write) -> Result<(), LabError> {
    for study in checks.studies {
        let name = study.name();
        let Some(oracle) = study.verified_by() else {
            writeln!(out, "Oracle of {name}: none; only netlist and models are compared.")?;
            continue;
        };
        let one = Checks { studies: std::slice::from_ref(study), ..*checks };
        let Some(judged) = one.against_the_oracles().pop() else {
            writeln!(out, "Oracle of {name} ({oracle}): left out; oracles speak of binary32.")?;
            continue;
        };
        let (wrong, jobs) = (judged.wrong, judged.jobs);
        writeln!(out, "Oracle of {name} ({oracle}): {wrong} of {jobs} random jobs answered wrongly.")?;
        judged.all_right(name, out)?;
    }
    Ok(())
}

impl Judged {
    /// Shows the faults of the operation `name` on `out`.
    ///
    /// # Errors
    /// A wrong answer; `out` that cannot be written.
    pub(crate) fn all_right(&self, name: &str, out: &mut dyn Write) -> Result<(), LabError> {
        self.faults.iter().try_for_each(|fault| writeln!(out, "  {fault}"))?;
        match self.wrong {
            0 => Ok(()),
            wrong => Err(LabError::Mismatch(format!("{wrong} of {} answers of {name} are wrong", self.jobs))),
        }
    }
}
