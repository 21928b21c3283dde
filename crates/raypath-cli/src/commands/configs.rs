//! `raypath configs`: the configurations with names.

use crate::error::CliError;
use raypath_rtl::report::tables::presets;
use std::io::Write;

pub fn run(out: &mut dyn Write) -> Result<(), CliError> {
    writeln!(out, "{}", presets())?;
    Ok(())
}
