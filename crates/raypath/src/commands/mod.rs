//! The command line.

mod accuracy;
mod additions;
mod bench;
mod configs;
mod configuration;
mod explore;
mod failure;
mod generate;
mod measuring;
mod numbers;
mod operations;
mod output;
mod ppa;
mod progress;
mod ray;
mod render;
mod replay;
mod search;
mod stream;
mod timed;
mod utilisation;
mod verify;
mod view;
mod wave;

use clap::{Parser, Subcommand};
pub use failure::Failure;
use std::io::Write;

/// An open hardware ray-tracer datapath: SystemVerilog, and models that agree with it bit for bit.
#[derive(Debug, Parser)]
#[command(
    name = "raypath",
    version,
    about,
    after_help = "Exit codes: 0 all is well, 1 a mismatch, 2 wrong input, 130 stopped by Ctrl-C."
)]
pub struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Write the datapath as SystemVerilog, show its schedule and units, and check the netlist against the models
    Generate(generate::Arguments),
    /// List the configurations that have names
    Configs,
    /// List the operations that a datapath can have, and what each costs
    Operations(operations::Arguments),
    /// Render a mesh through the datapath, and see how busy it was
    Render(render::Arguments),
    /// Search nearest neighbours through the datapath, and see how busy it was
    Search(search::Arguments),
    /// Run recorded transactions through a model or the netlist and compare the results
    Replay(replay::Arguments),
    /// Derive what the hardware expects of a ray (inverse, axes, shear) from its origin and direction
    Ray(ray::Arguments),
    /// Run recorded transactions through the netlist and write a waveform (FST)
    Wave(wave::Arguments),
    /// Measure what a format costs: hits and distances against binary64, on random jobs and a scene
    Accuracy(accuracy::Arguments),
    /// Measure area and timing in a cell library, stage by stage, with Yosys and OpenSTA
    Ppa(ppa::Arguments),
    /// Measure many configurations and draw area against clock and throughput
    Explore(explore::Arguments),
    /// Measure how fast the models are, beside Verilator and other libraries
    Bench(bench::Arguments),
    /// Hold the datapath's claims against independent oracles: proofs, campaigns, mutations
    Verify(verify::Arguments),
}

impl CommandLine {
    /// Does what was asked for, and says so on `out`.
    pub fn run(self, out: &mut dyn Write) -> Result<(), Failure> {
        match self.command {
            Command::Generate(arguments) => generate::run(&arguments, out),
            Command::Configs => configs::run(out),
            Command::Operations(arguments) => operations::run(&arguments, out),
            Command::Render(arguments) => render::run(&arguments, out),
            Command::Search(arguments) => search::run(&arguments, out),
            Command::Replay(arguments) => replay::run(&arguments, out),
            Command::Ray(arguments) => ray::run(&arguments, out),
            Command::Wave(arguments) => wave::run(&arguments, out),
            Command::Accuracy(arguments) => accuracy::run(&arguments, out),
            Command::Ppa(arguments) => ppa::run(&arguments, out),
            Command::Explore(arguments) => explore::run(&arguments, out),
            Command::Bench(arguments) => bench::run(&arguments, out),
            Command::Verify(arguments) => verify::run(&arguments, out),
        }
    }
}
