//! `raypath wave`: recorded transactions through the netlist, with a waveform.

mod unit;

use crate::commands::full::StreamArguments;
use crate::commands::unit::{UnitArguments, not_with_unit};
use crate::{CliError, DatapathArguments, Progress, whole};
use clap::Args;
use raypath_hdl::Simulator;
use raypath_hdl::wave::{WaveError, WaveWriter};
use raypath_rtl::UnitKind;
use raypath_sim::Words;
use raypath_sim::engine::{Engine, NetlistEngine, Shown, drive};
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_help = not_with_unit())]
pub struct Arguments {
    #[command(flatten)]
    stream: StreamArguments,
    /// The waveform to write, for viewers such as GTKWave and Surfer
    #[arg(long, default_value = "trace.fst")]
    out: PathBuf,
    /// Stop after this many jobs
    #[arg(long, value_name = "N", value_parser = whole(1..=u32::MAX))]
    jobs: Option<u32>,
    /// Show the traversal unit around the datapath, with random rays in a random scene in place of transactions
    #[arg(long, conflicts_with_all = ["files", "kind", "handshake", "interleave", "jobs", "specs"])]
    unit: bool,
    /// The number of random rays
    #[arg(long, default_value_t = 20, requires = "unit", value_parser = whole(1..=100_000_u32))]
    rays: u32,
    #[command(flatten)]
    datapath: DatapathArguments,
    #[command(flatten)]
    unit_parameters: UnitArguments,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    if arguments.unit {
        return unit::run(arguments, out);
    }
    arguments.unit_parameters.expect_none("--unit")?;
    let (config, whole) = arguments.datapath.datapath()?;
    let (model, datapath) = (whole.model(), whole.elaborate()?);
    let stream = arguments.stream.read(&model, config)?;
    let units = UnitKind::ALL.map(|kind| format!("u_{}_", kind.stem()));
    let netlist = NetlistEngine::of(model, config, &datapath, |name| is_of_interest(name, &units))?;
    let waves = WaveWriter::create(&arguments.out, netlist.simulator())?;
    let mut waving = Waving { netlist, samples: Samples::new(waves) };

    let total = arguments.jobs.map_or(stream.len(), |jobs| stream.len().min(jobs as usize));
    let mut progress = Progress::new("jobs", total);
    let jobs = stream[..total].iter().map(|transaction| &transaction.job);
    let mut traffic = arguments.stream.traffic()?;
    let run = drive(&mut waving, jobs, &mut traffic, |index, _| progress.at(index + 1));
    progress.finish(run.jobs)?;
    if let Some(failed) = waving.samples.failed {
        return Err(failed.into());
    }
    waving.samples.waves.finish()?;
    writeln!(out, "Wrote {} jobs in {} cycles to {}", run.jobs, run.cycles, arguments.out.display())?;
    Ok(())
}

/// Whether a signal is not inside an instance of a unit: the names of such instances begin with one of `units`.
fn is_of_interest(name: &str, units: &[String]) -> bool {
    !name.split('.').any(|part| units.iter().any(|unit| part.starts_with(unit)))
}

struct Waving {
    netlist: NetlistEngine,
    samples: Samples,
}

/// A waveform with a sample for each cycle, until one fails.
struct Samples {
    waves: WaveWriter,
    cycle: u64,
    failed: Option<WaveError>,
}

impl Engine for Waving {
    fn present(&mut self, job: &Words) {
        self.netlist.present(job);
    }

    fn cycle(&mut self, input_valid: bool, output_ready: bool) -> Shown {
        let shown = self.netlist.cycle(input_valid, output_ready);
        self.samples.take(self.netlist.simulator());
        shown
    }

    fn reset(&mut self) {
        self.netlist.reset();
        self.samples.take(self.netlist.simulator());
    }
}

impl Samples {
    fn new(waves: WaveWriter) -> Self {
        Self { waves, cycle: 0, failed: None }
    }

    fn take(&mut self, simulator: &Simulator) {
        if self.failed.is_none() {
            self.failed = self.waves.sample(simulator, self.cycle).err();
        }
        self.cycle += 1;
    }
}
