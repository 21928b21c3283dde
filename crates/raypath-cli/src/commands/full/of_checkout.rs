//! `raypath verify` and `raypath bench` in a build without the feature `verify`, such as the Python package of a
//! checkout, which is compiled fast.

use crate::CliError;
pub use crate::commands::missing::Ignored as Arguments;
use std::io::Write;

pub fn run(arguments: &Arguments, _: &mut dyn Write) -> Result<(), CliError> {
    // The module has the name of the command.
    let name = module_path!().rsplit("::").next().unwrap_or_default();
    Err(CliError::unusable(format!(
        "this build has no `{name}`, expected the program of a checkout\nhelp: run `cargo raypath {}` there",
        arguments.after(name)
    )))
}
