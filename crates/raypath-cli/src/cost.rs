//! The cost of an operation: units, flip-flops and, if the tools are installed, area and slowest path, relative to a
//! datapath without it.

#[cfg(feature = "workbench")]
use crate::{error::CliError, measure::measure};
#[cfg(feature = "workbench")]
use raypath_ppa::{Bench, DEFAULT_LIBRARY, Design, Error, Library, Report};
use raypath_rtl::report::tables::{list, right_aligned, table};
use raypath_rtl::{self as rtl, Units};
use raypath_sim::Datapath;
#[cfg(feature = "workbench")]
use raypath_tools::{OpenSta, Yosys};
#[cfg(feature = "workbench")]
use std::path::Path;

/// A datapath's figures.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Figures {
    /// Units of all steps.
    pub units: Units,
    /// Flip-flops.
    pub flip_flops: u64,
    /// Cycles from an accepted job to its outcome.
    pub latency: u32,
    /// Area in µm², and the slowest path in ns.
    pub area: Option<(f64, f64)>,
}

/// A datapath without an operation and with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Without.
    pub without: Figures,
    /// With.
    pub with: Figures,
}

impl Cost {
    /// Counts units and flip-flops of `datapath` with the operation of this name and without it.
    ///
    /// # Errors
    /// The operation does not fit into the datapath.
    pub fn of(datapath: &Datapath, name: &str) -> Result<Self, rtl::Error> {
        let without = datapath.clone().without(name);
        Ok(Self { without: figures(&without)?, with: figures(datapath)? })
    }

    /// The same with areas, measured by Yosys and OpenSTA in the default cell library; `cache` is the folder of cached
    /// results.
    ///
    /// # Errors
    /// A tool or the library is missing, a tool fails, or the user stopped it.
    #[cfg(feature = "workbench")]
    pub fn measured(self, datapath: &Datapath, name: &str, cache: &Path) -> Result<Self, CliError> {
        let design = |datapath: &Datapath, name: String| -> Result<Design, CliError> {
            Ok(Design::new(name, datapath.elaborate()?.top()))
        };
        let without = datapath.clone().without(name);
        let mut designs = vec![design(datapath, format!("with {name}"))?];
        let is_alone = self.without == Figures::default();
        if !is_alone {
            designs.push(design(&without, format!("without {name}"))?);
        }
        let reports = measure(&bench(cache)?, &designs)?;
        let area = |report: &Report| (report.area.total, report.slowest.ns);
        let [with, without] = [0, 1].map(|place| reports.get(place).map(area));
        let without = without.or(is_alone.then_some((0.0, 0.0)));
        Ok(Self { without: Figures { area: without, ..self.without }, with: Figures { area: with, ..self.with } })
    }

    /// Units that the operation adds to the datapath.
    pub fn added_units(&self) -> Units {
        self.with.units.join(self.without.units, usize::saturating_sub)
    }

    /// The same as text; `none` if there are none.
    pub fn added_units_in_words(&self) -> String {
        let units = list(self.added_units());
        if units.is_empty() { "none".to_string() } else { units }
    }

    /// Flip-flops that it adds; below 0 if sharing saves some.
    pub fn added_flip_flops(&self) -> i64 {
        self.with.flip_flops as i64 - self.without.flip_flops as i64
    }

    /// Area that it adds, in µm².
    pub fn added_area(&self) -> Option<f64> {
        Some(self.with.area?.0 - self.without.area?.0)
    }

    /// Both datapaths and the difference, in a table.
    pub fn table(&self) -> String {
        let (without, with) = (self.without, self.with);
        let units = ["units".to_string(), list(without.units), list(with.units), self.added_units_in_words()];
        let [a, b] = [without.flip_flops, with.flip_flops].map(|count| count.to_string());
        let mut rows = vec![units, ["flip-flops".to_string(), a, b, format!("{:+}", self.added_flip_flops())]];
        if let (Some(without), Some(with)) = (without.area, with.area) {
            let share = if without.0 > 0.0 {
                format!(" ({:+.1} %)", 100.0 * (with.0 / without.0 - 1.0))
            } else {
                String::new()
            };
            let areas =
                [format!("{:.0}", without.0), format!("{:.0}", with.0), format!("{:+.0}{share}", with.0 - without.0)];
            let [a, b, c] = areas;
            rows.push(["area, µm²".to_string(), a, b, c]);
            let [a, b, c] = [without.1, with.1, with.1 - without.1].map(|ns| format!("{ns:.2}"));
            rows.push(["slowest path, ns".to_string(), a, b, c]);
        }
        right_aligned(table(["", "without it", "with it", "added"], rows), 1)
    }
}

fn figures(datapath: &Datapath) -> Result<Figures, rtl::Error> {
    if datapath.is_empty() {
        return Ok(Figures::default());
    }
    let netlist = datapath.elaborate()?;
    let units = (0..netlist.steps().count()).map(|step| netlist.units(step)).sum();
    Ok(Figures { units, flip_flops: netlist.top().register_bits(), latency: netlist.latency(), area: None })
}

/// The default library and tools.
#[cfg(feature = "workbench")]
fn bench(cache: &Path) -> Result<Bench, Error> {
    Ok(Bench {
        library: Library::read(Path::new(DEFAULT_LIBRARY))?,
        yosys: Yosys::find(None)?,
        sta: OpenSta::find()?,
        period: rtl::package::PERIOD_NS,
        unit_period: None,
        jobs: std::thread::available_parallelism().map_or(1, usize::from),
        cache: cache.to_path_buf(),
    })
}
