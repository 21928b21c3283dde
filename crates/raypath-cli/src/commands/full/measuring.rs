//! Options of `ppa` and `explore` for the tools and the library.

use crate::measure::watched;
use crate::{CliError, number, whole};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use raypath_ppa::{Bench, DEFAULT_LIBRARY, Design, Error, Library, Progress, Report};
use raypath_rtl::package::PERIOD_NS;
use raypath_tools::{OpenSta, Yosys, YosysKind};
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub struct BenchArguments {
    /// The cell library: a Liberty file, plain or gzip [default, except for `card`: that of Debian's qflow-tech-osu018]
    #[arg(long, value_name = "FILE")]
    pub liberty: Option<PathBuf>,
    /// The clock period for which gates are optimised, in nanoseconds; not a limit
    #[arg(long, default_value_t = PERIOD_NS, value_parser = number(0.001..=1e6, "nanoseconds, 0.001 to 1000000"), value_name = "NS")]
    period: f64,
    /// The part of the period for which units are optimised, in nanoseconds; the gates around them are optimised for
    /// the rest [default: the whole period for both]
    #[arg(long, value_parser = number(0.001..=1e6, "nanoseconds, 0.001 to 1000000"), value_name = "NS")]
    unit_period: Option<f64>,
    /// The number of programs that run at a time [default: the number of cores]
    #[arg(long, value_parser = whole(1..=u16::MAX))]
    jobs: Option<u16>,
    /// The folder of cached results
    #[arg(long, default_value = "build/ppa-cache", value_name = "DIR")]
    pub cache: PathBuf,
    /// The kind of Yosys: the program or the Python module [default: the module if it is installed]
    #[arg(long, value_parser = yosys())]
    yosys: Option<YosysKind>,
}

/// A parser of the names of Yosys' kinds.
fn yosys() -> impl TypedValueParser<Value = YosysKind> {
    let kind = |name: String| if name == "program" { YosysKind::Program } else { YosysKind::Python };
    PossibleValuesParser::new(["program", "pyosys"]).map(kind)
}

impl BenchArguments {
    /// Whether the user chose the library, a period or a program.
    pub fn is_chosen(&self) -> bool {
        let Self { liberty, period, unit_period, jobs, yosys, .. } = self;
        liberty.is_some() || *period != PERIOD_NS || unit_period.is_some() || jobs.is_some() || yosys.is_some()
    }

    /// Finds the library and the tools, and measures designs with a progress bar.
    pub fn measure(&self, designs: &[Design]) -> Result<Vec<Report>, CliError> {
        let bench = self.bench()?;
        resumable(|watch| bench.measure(designs, watch))
    }

    /// The library and the tools.
    pub fn bench(&self) -> Result<Bench, CliError> {
        if let Some(unit_period) = self.unit_period.filter(|unit_period| *unit_period >= self.period) {
            let message = format!("--unit-period {unit_period}: expected less than --period, which is {}", self.period);
            return Err(CliError::unusable(message));
        }
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        Ok(Bench {
            library: Library::read(self.liberty.as_deref().unwrap_or(Path::new(DEFAULT_LIBRARY)))?,
            yosys: Yosys::find(self.yosys)?,
            sta: OpenSta::find()?,
            period: self.period,
            unit_period: self.unit_period,
            jobs: self.jobs.map_or_else(cores, usize::from),
            cache: self.cache.clone(),
        })
    }
}

/// Shows the progress of a measurement. The message about a stop says that it resumes.
pub fn resumable<T>(
    measurement: impl FnOnce(&mut dyn FnMut(Progress) -> bool) -> Result<T, Error>,
) -> Result<T, CliError> {
    watched(measurement).map_err(|error| match error {
        CliError::Stopped(stopped) => CliError::Stopped(format!("{stopped}; {RESUMES}")),
        other => other,
    })
}

/// The end of the message about a stop.
pub const RESUMES: &str = "what is done is kept, and the same command goes on from there";
