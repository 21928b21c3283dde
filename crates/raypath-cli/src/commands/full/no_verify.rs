//! `raypath verify` in a build without the feature `verify`.

use crate::CliError;
pub use crate::commands::missing::Ignored as Arguments;
use std::io::Write;

pub fn run(arguments: &Arguments, _: &mut dyn Write) -> Result<(), CliError> {
    Err(CliError::unusable(format!(
        "this build has no `verify`, expected the program of a checkout\nhelp: run `cargo raypath {}` there",
        arguments.after("verify")
    )))
}
