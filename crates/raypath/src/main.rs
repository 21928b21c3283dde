//! The `raypath` command.

mod commands;

use clap::Parser;
use commands::Failure;
use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut out = std::io::stdout().lock();
    let result = commands::CommandLine::parse().run(&mut out);
    match result.and_then(|()| out.flush().map_err(Failure::from)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if !failure.is_silent() {
                // Where not even this can be written there is nobody left to tell.
                let _ = writeln!(std::io::stderr(), "raypath: {failure}");
            }
            failure.exit_code()
        }
    }
}
