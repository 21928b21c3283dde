//! Comparison of operations with their oracles, and its report.

use crate::error::CliError;
use raypath_oracle::{Checks, OracleReport};
use std::io::Write;

/// Compares the results of each operation with its oracle, and reports on `out`.
pub fn ask_oracles(checks: &Checks<'_>, out: &mut dyn Write) -> Result<(), CliError> {
    for spec in checks.specs {
        let name = spec.name();
        let Some(oracle) = spec.oracle_name() else {
            writeln!(out, "Oracle of {name}: none; only netlist and models are compared.")?;
            continue;
        };
        let one = Checks { specs: std::slice::from_ref(spec), ..*checks };
        let Some(report) = one.against_the_oracles().pop() else {
            writeln!(out, "Oracle of {name} ({oracle}): skipped; oracles exist for binary32 only.")?;
            continue;
        };
        let (wrong, jobs) = (report.wrong, report.jobs);
        writeln!(out, "Oracle of {name} ({oracle}): {wrong} of {jobs} random jobs have wrong results.")?;
        require_right(&report, name, out)?;
    }
    Ok(())
}

/// Writes the wrong results of the operation `name` to `out`; an error if there are any.
pub(crate) fn require_right(report: &OracleReport, name: &str, out: &mut dyn Write) -> Result<(), CliError> {
    report.faults.iter().try_for_each(|fault| writeln!(out, "  {fault}"))?;
    match report.wrong {
        0 => Ok(()),
        wrong => Err(CliError::Mismatch(format!("{wrong} of {} results of {name} are wrong", report.jobs))),
    }
}
