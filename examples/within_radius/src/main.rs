//! The command line of the operation: `cargo run --release` generates its hardware, checks it and reports its cost.

use std::process::ExitCode;

fn main() -> ExitCode {
    raypath::workbench::main(within_radius::spec())
}
