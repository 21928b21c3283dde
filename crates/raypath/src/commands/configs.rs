//! `raypath configs`: the configurations with names.

use crate::commands::Failure;
use raypath::tables::presets;
use std::io::Write;

pub fn run(out: &mut dyn Write) -> Result<(), Failure> {
    writeln!(out, "{}", presets())?;
    Ok(())
}
