//! `raypath verify` in a build without the feature `verify`.

use crate::CliError;
use clap::Args;
use std::io::Write;

/// Any arguments. A build with the feature `verify` parses them.
#[derive(Debug, Args)]
#[command(disable_help_flag = true)]
pub struct Arguments {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    arguments: Vec<String>,
}

pub fn run(Arguments { arguments }: &Arguments, _: &mut dyn Write) -> Result<(), CliError> {
    let words: Vec<&str> = std::iter::once("verify").chain(arguments.iter().map(String::as_str)).collect();
    let words = words.join(" ");
    Err(CliError::Unusable(format!(
        "this build has no `verify`, expected the program of a checkout\nhelp: run `cargo raypath {words}` there"
    )))
}
