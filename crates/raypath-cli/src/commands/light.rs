//! The commands that a build without the feature `full` lists, but does not have.

use super::missing::{Ignored, needs_full};
use crate::error::CliError;
use clap::Subcommand;
use std::io::Write;

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a mesh through the datapath, and show its utilisation (feature `full`)
    Render(Ignored),
    /// Write a mesh as the traversal unit reads it from memory (feature `full`)
    Scene(Ignored),
    /// Search nearest neighbours through the datapath, and show its utilisation (feature `full`)
    Search(Ignored),
    /// Run recorded transactions through a model or the netlist and compare the results (feature `full`)
    Replay(Ignored),
    /// Run recorded transactions through the netlist and write a waveform (FST) (feature `full`)
    Wave(Ignored),
    /// Measure the error of a number format: hits and distances against binary64, on random jobs and a scene (feature
    /// `full`)
    Accuracy(Ignored),
    /// Measure area and timing in a cell library, stage by stage, with Yosys and OpenSTA (feature `full`)
    Ppa(Ignored),
    /// Print a configuration's time, ports, units, area and energy for architecture simulators (feature `full`)
    Card(Ignored),
    /// Place and route the datapath on an FPGA, or run jobs through its shell as a host does (feature `full`)
    Fpga(Ignored),
    /// Measure many configurations and draw area against clock and throughput (feature `full`)
    Explore(Ignored),
    /// Measure the speed of the models, compared with Verilator and other libraries (feature `full`)
    Bench(Ignored),
    /// Check the claims about the datapath against independent oracles: proofs, campaigns, mutations (feature `full`)
    Verify(Ignored),
}

impl Command {
    pub fn run(self, _: &mut dyn Write) -> Result<(), CliError> {
        let (name, ignored) = match self {
            Self::Render(ignored) => ("render", ignored),
            Self::Scene(ignored) => ("scene", ignored),
            Self::Search(ignored) => ("search", ignored),
            Self::Replay(ignored) => ("replay", ignored),
            Self::Wave(ignored) => ("wave", ignored),
            Self::Accuracy(ignored) => ("accuracy", ignored),
            Self::Ppa(ignored) => ("ppa", ignored),
            Self::Card(ignored) => ("card", ignored),
            Self::Fpga(ignored) => ("fpga", ignored),
            Self::Explore(ignored) => ("explore", ignored),
            Self::Bench(ignored) => ("bench", ignored),
            Self::Verify(ignored) => ("verify", ignored),
        };
        Err(CliError::Unusable(needs_full(&ignored.after(name))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Light {
        #[command(subcommand)]
        command: Command,
    }

    #[test]
    fn a_missing_command_names_the_command_that_has_it() {
        for arguments in [&["render", "scene.obj", "--shadows", "--ao", "8"][..], &["verify"], &["search", "--help"]] {
            let line = std::iter::once("raypath").chain(arguments.iter().copied());
            let light = Light::try_parse_from(line).map_err(|error| error.to_string()).expect("a listed command");
            let message = light.command.run(&mut Vec::new()).expect_err("it is missing").to_string();
            let words = arguments.join(" ");
            assert!(message.contains(&format!("cargo raypath {words}`")), "{message}");
            assert!(message.contains("`cargo install --path crates/raypath --features full`"), "{message}");
        }
    }
}
