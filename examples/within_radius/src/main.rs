//! `cargo run --release`: the operation as hardware, checked, and what it costs.

use std::process::ExitCode;

fn main() -> ExitCode {
    raypath::workbench::main(within_radius::spec())
}
