//! `cargo run --release`: the operation as hardware, checked, and what it costs.

use std::process::ExitCode;

fn main() -> ExitCode {
    raypath_lab::main(within_radius::study())
}
