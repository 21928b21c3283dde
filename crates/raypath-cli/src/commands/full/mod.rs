//! The commands of a build with the feature `full`.

mod accuracy;
#[cfg_attr(not(feature = "verify"), path = "of_checkout.rs")]
mod bench;
mod box_bits;
mod card;
mod division;
mod explore;
mod fpga;
mod measuring;
mod memory;
mod ppa;
mod progress;
mod render;
mod replay;
mod scene;
mod search;
mod stream;
mod unit_sweep;
mod utilisation;
#[cfg_attr(not(feature = "verify"), path = "of_checkout.rs")]
mod verify;
mod view;
mod visits;
mod wave;

use division::DivisionArguments;
use measuring::BenchArguments;
use memory::MemoryArguments;
use progress::watched;
use stream::StreamArguments;
use view::{ViewArguments, print, print_rows, recording, write_and_name};

use crate::error::CliError;
use clap::Subcommand;
use std::io::Write;

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a mesh through the datapath, and show its utilisation
    Render(Box<render::Arguments>),
    /// Write a mesh as the traversal unit reads it from memory
    Scene(scene::Arguments),
    /// Search nearest neighbours through the datapath, and show its utilisation
    Search(search::Arguments),
    /// Run recorded transactions through a model or the netlist and compare the results
    Replay(replay::Arguments),
    /// Run recorded transactions through the netlist and write a waveform (FST)
    Wave(wave::Arguments),
    /// Measure the error of a number format: hits and distances against binary64, on random jobs and a scene
    Accuracy(accuracy::Arguments),
    /// Measure area and timing in a cell library, stage by stage, with Yosys and OpenSTA
    Ppa(ppa::Arguments),
    /// Print a configuration's time, ports, units, area and energy for architecture simulators
    Card(card::Arguments),
    /// Place and route the datapath on an FPGA, or run jobs through its shell as a host does
    Fpga(fpga::Arguments),
    /// Measure many configurations and draw area against clock and throughput
    Explore(explore::Arguments),
    /// Compare boxes in fewer bits: visits that they add in scenes, and area
    BoxBits(box_bits::Arguments),
    /// Measure the speed of the models, compared with Verilator and other libraries
    Bench(bench::Arguments),
    /// Check the claims about the datapath against independent oracles: proofs, campaigns, mutations
    Verify(verify::Arguments),
}

impl Command {
    pub fn run(self, out: &mut dyn Write) -> Result<(), CliError> {
        match self {
            Self::Render(arguments) => render::run(&arguments, out),
            Self::Scene(arguments) => scene::run(&arguments, out),
            Self::Search(arguments) => search::run(&arguments, out),
            Self::Replay(arguments) => replay::run(&arguments, out),
            Self::Wave(arguments) => wave::run(&arguments, out),
            Self::Accuracy(arguments) => accuracy::run(&arguments, out),
            Self::Ppa(arguments) => ppa::run(&arguments, out),
            Self::Card(arguments) => card::run(&arguments, out),
            Self::Fpga(arguments) => fpga::run(&arguments, out),
            Self::Explore(arguments) => explore::run(&arguments, out),
            Self::BoxBits(arguments) => box_bits::run(&arguments, out),
            Self::Bench(arguments) => bench::run(&arguments, out),
            Self::Verify(arguments) => verify::run(&arguments, out),
        }
    }
}
