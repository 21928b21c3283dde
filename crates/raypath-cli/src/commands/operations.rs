//! `raypath operations`: the operations that a datapath can have, and the cost of each.

use crate::{CliError, Cost};
use clap::Args;
use comfy_table::{CellAlignment, ContentArrangement};
use raypath_oracle::AnyOperationSpec;
use raypath_rtl::Config;
use raypath_rtl::report::tables::table;
use raypath_sim::Datapath;
use std::io::Write;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct Arguments {
    /// Measure areas as well, with Yosys and OpenSTA: a few minutes for each operation that was not measured before
    #[arg(long)]
    area: bool,
    /// The folder of cached measurements
    #[arg(long, default_value = "build/ppa-cache", value_name = "DIR")]
    cache: PathBuf,
}

pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<(), CliError> {
    let config = Config::DEFAULT;
    let mut head = vec!["operation", "for", "latency", "units added", "flip-flops added"];
    if arguments.area {
        head.extend(["area added", "slowest path"]);
    }
    head.push("verified by");
    let mut rows = Vec::new();
    for entry in paper(config).into_iter().chain(extra()) {
        let datapath = entry.datapath(config);
        let mut cost = Cost::of(&datapath, entry.name)?;
        if arguments.area {
            cost = measured(cost, &datapath, entry.name, arguments)?;
        }
        rows.push(row(&entry, &cost));
    }
    let mut table = table(head, rows);
    // One row per line, so that a document can contain the table unchanged.
    table.set_content_arrangement(ContentArrangement::Disabled);
    for column in [2, 4, 5, 6].into_iter().filter(|&column| arguments.area || column < 5) {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    writeln!(out, "{table}\n")?;
    writeln!(
        out,
        "Costs are relative to a datapath of the paper's other operations with 16 lanes in binary32. Operations"
    )?;
    writeln!(
        out,
        "share units; one without units of its own adds multiplexers and registers. `generate --with NAME` adds"
    )?;
    writeln!(out, "an operation to the datapath.")?;
    Ok(())
}

#[cfg(feature = "workbench")]
fn measured(cost: Cost, datapath: &Datapath, name: &str, arguments: &Arguments) -> Result<Cost, CliError> {
    cost.measured(datapath, name, &arguments.cache)
}

#[cfg(not(feature = "workbench"))]
fn measured(_: Cost, _: &Datapath, _: &str, _: &Arguments) -> Result<Cost, CliError> {
    Err(CliError::Unusable(super::missing::needs_full("operations --area")))
}

struct Entry {
    name: &'static str,
    purpose: &'static str,
    verified: &'static str,
    /// Set for operations that are not in the paper.
    spec: Option<AnyOperationSpec>,
}

impl Entry {
    /// The paper's operations and this one.
    fn datapath(&self, config: Config) -> Datapath {
        let paper = Datapath::paper(config);
        match &self.spec {
            Some(spec) => paper.with_any(spec.operation()),
            None => paper,
        }
    }
}

fn paper(config: Config) -> Vec<Entry> {
    let of = |kind: &raypath_ops::JobKind| {
        let (purpose, verified) = match kind {
            raypath_ops::JobKind::Triangle => ("a ray against a triangle", "golden vectors, exact rationals"),
            raypath_ops::JobKind::Quadbox => ("a ray against four boxes", "golden vectors, exact rationals"),
            raypath_ops::JobKind::Euclidean => ("squared distance, 16 dimensions a beat", "golden vectors, exact sums"),
            raypath_ops::JobKind::Angular => {
                ("dot product and norm, 8 dimensions a beat", "golden vectors, exact sums")
            }
        };
        Entry { name: kind.name(), purpose, verified, spec: None }
    };
    config.kinds().iter().map(of).collect()
}

fn extra() -> impl Iterator<Item = Entry> {
    raypath_oracle::added_operations().into_iter().map(|spec| Entry {
        name: spec.name(),
        purpose: spec.purpose(),
        verified: spec.oracle_name().unwrap_or("models alone"),
        spec: Some(spec),
    })
}

fn row(entry: &Entry, cost: &Cost) -> Vec<String> {
    let mut row = vec![entry.name.to_string(), entry.purpose.to_string(), cost.with.latency.to_string()];
    row.extend([cost.added_units_in_words(), format!("{:+}", cost.added_flip_flops())]);
    if let (Some(with), Some(without)) = (cost.with.area, cost.without.area) {
        let (added, ns) = (with.0 - without.0, with.1 - without.1);
        row.extend([format!("{added:+.0} µm² ({:+.1} %)", 100.0 * added / without.0), format!("{ns:+.2} ns")]);
    }
    row.push(entry.verified.to_string());
    row
}
