//! What `ppa` and `explore` measure with.

use crate::commands::numbers::whole;
use crate::error::CliError;
use clap::{Args, ValueEnum};
use raypath_ppa::{Bench, DEFAULT_LIBRARY, Design, Library, Report};
use raypath_tools::{OpenSta, Yosys, YosysKind};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct BenchArguments {
    /// The cell library: a Liberty file, plain or gzip
    #[arg(long, default_value = DEFAULT_LIBRARY, value_name = "FILE")]
    liberty: PathBuf,
    /// The clock period that gates are chosen for, in nanoseconds; not a limit
    #[arg(long, default_value_t = 12.0, value_parser = period, value_name = "NS")]
    period: f64,
    /// How many programs may run at a time [default: as many as there are cores]
    #[arg(long, value_parser = whole(1..=u16::MAX))]
    jobs: Option<u16>,
    /// Where results are kept, so that nothing is done twice
    #[arg(long, default_value = "build/ppa-cache", value_name = "DIR")]
    cache: PathBuf,
    /// Which Yosys: the program, or Python's module [default: the module if it is installed]
    #[arg(long)]
    yosys: Option<WhichYosys>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum WhichYosys {
    Program,
    Pyosys,
}

impl BenchArguments {
    /// Finds the library and the tools, and measures designs with a progress bar.
    pub fn measure(&self, designs: &[Design]) -> Result<Vec<Report>, CliError> {
        let kind = self.yosys.map(|which| match which {
            WhichYosys::Program => YosysKind::Program,
            WhichYosys::Pyosys => YosysKind::Python,
        });
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        let bench = Bench {
            library: Library::read(&self.liberty)?,
            yosys: Yosys::find(kind)?,
            sta: OpenSta::find()?,
            period: self.period,
            jobs: self.jobs.map_or_else(cores, usize::from),
            cache: self.cache.clone(),
        };
        crate::measure::measure(&bench, designs).map_err(|error| match error {
            CliError::Stopped(stopped) => {
                let kept = "what is done is kept, and the same command goes on from there";
                CliError::Stopped(format!("{stopped}; {kept}"))
            }
            other => other,
        })
    }
}

fn period(text: &str) -> Result<f64, String> {
    let period = text.parse().ok().filter(|period: &f64| (0.001..=1e6).contains(period));
    period.ok_or_else(|| "expected nanoseconds, 0.001 to 1000000".to_string())
}
