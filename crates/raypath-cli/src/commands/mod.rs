//! The commands of `raypath`.

pub mod configuration;
mod generate;
mod new_operation;
pub mod numbers;
mod operations;
mod outputs;
mod ray;
mod unit;

#[cfg(feature = "full")]
mod full;
#[cfg(any(test, not(feature = "full")))]
mod light;
#[cfg(any(test, not(feature = "verify")))]
mod missing;

use crate::error::CliError;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
#[cfg(not(feature = "full"))]
use light as full;
use raypath_rtl::report::tables::{exceptions, presets};
use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;

/// An open hardware ray-tracer datapath: SystemVerilog, and models that agree with it bit for bit.
#[derive(Debug, Parser)]
#[command(
    name = "raypath",
    version,
    about = "An open hardware ray-tracer datapath: SystemVerilog, and models that agree with it bit for bit",
    after_help = "Exit codes: 0 success, 1 a mismatch, 2 wrong input, 130 stopped by Ctrl-C."
)]
pub struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
#[allow(clippy::large_enum_variant)] // one command is parsed in a process
enum Command {
    /// Write the datapath, or with --unit the traversal unit, as SystemVerilog, show its parts, and check the netlist
    /// against the models
    Generate(generate::Arguments),
    /// List the presets, which are named configurations, and the parameters that cannot be combined
    Configs,
    /// List the operations that a datapath can have, and the cost of each
    Operations(operations::Arguments),
    /// Make a crate for an operation of your own
    NewOperation(new_operation::Arguments),
    /// Derive the values of the ports of a ray (inverse, axes, shear) from its origin and direction
    Ray(ray::Arguments),
    #[command(flatten)]
    Full(full::Command),
}

impl CommandLine {
    /// Runs the command and prints its results to `out`.
    ///
    /// # Errors
    /// Wrong input, a mismatch, a tool that fails, `out` that cannot be written, or Ctrl-C.
    pub fn run(self, out: &mut dyn Write) -> Result<(), CliError> {
        match self.command {
            Command::Generate(arguments) => generate::run(&arguments, out),
            Command::Configs => {
                writeln!(out, "{}\n\nAll values of all parameters combine, but these:\n", presets())?;
                Ok(writeln!(out, "{}", exceptions())?)
            }
            Command::Operations(arguments) => operations::run(&arguments, out),
            Command::NewOperation(arguments) => new_operation::run(&arguments, out),
            Command::Ray(arguments) => ray::run(&arguments, out),
            Command::Full(command) => command.run(out),
        }
    }
}

/// The `raypath` program: runs the command that its arguments name.
pub fn main() -> ExitCode {
    run(std::env::args_os()).into()
}

/// Runs the command that `arguments` name and returns the exit code. The first argument is the name of the program.
pub fn run(arguments: impl IntoIterator<Item: Into<OsString> + Clone>) -> u8 {
    // So that the message about a negative number is that of its option.
    let commands = CommandLine::command().mut_subcommands(|command| command.allow_negative_numbers(true));
    let parsed = commands.try_get_matches_from(arguments).and_then(|matches| {
        let command = CommandLine::from_arg_matches(&matches);
        Ok((command.map_err(|error| error.format(&mut CommandLine::command()))?, outputs::problem(&matches)))
    });
    match parsed {
        Ok((command, None)) => exit(|out| command.run(out)),
        Ok((_, Some(problem))) => exit(|_| Err(CliError::unusable(problem))),
        Err(error) => {
            // If the message cannot be written, the exit code alone reports the error.
            let _ = error.print();
            u8::try_from(error.exit_code()).unwrap_or(2)
        }
    }
}

/// Runs `command` with standard output, reports an error on standard error, and returns the exit code.
pub(crate) fn exit(command: impl FnOnce(&mut dyn Write) -> Result<(), CliError>) -> u8 {
    let mut out = std::io::stdout().lock();
    match command(&mut out).and_then(|()| Ok(out.flush()?)) {
        Ok(()) => 0,
        Err(error) => {
            if !error.is_silent() {
                // If standard error cannot be written either, the exit code alone reports the error.
                let _ = writeln!(std::io::stderr(), "raypath: {error}");
            }
            error.exit_code()
        }
    }
}
