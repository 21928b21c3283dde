//! The table of presets: each with its cost, and area and slowest stage as multiples of another design's.

use crate::CliError;
use raypath_ppa::{Baseline, DesignPoint, Report};
use raypath_rtl::{Config, DatapathNetlist, PRESETS};
use raypath_tools::grouped;
use std::path::Path;

/// The reports of the other design, by the number of lanes: `DIR/lanes-none/ppa.json`, `DIR/lanes-16/ppa.json` and so
/// on. A folder that does not exist is no error; the rows that need it have no multiples.
///
/// # Errors
/// A report cannot be read.
pub fn baseline(folder: &Path, config: Config) -> Result<Option<Baseline>, CliError> {
    let folder = folder.join(format!("lanes-{}", config.semantics.lanes));
    // Boxes of 8 bits a bound take the place of boxes of numbers: that is another set of operations.
    let is_comparable = !config.semantics.features.quantised_boxes && folder.is_dir();
    Ok(is_comparable.then(|| Baseline::read(&folder)).transpose()?)
}

/// The table in Markdown, a row for each configuration.
///
/// # Errors
/// A configuration cannot be elaborated.
pub fn table(rows: &[((&DesignPoint, Config), &Option<Baseline>)]) -> Result<String, CliError> {
    let mut text = String::from(
        "| preset | contents | flip-flops | latency | area | slowest stage |\n|---|---|---:|---:|---:|---:|\n",
    );
    for ((DesignPoint { name, report, .. }, config), baseline) in rows {
        let contents = PRESETS.iter().find(|preset| preset.name == name).map_or("", |preset| preset.purpose);
        let datapath = DatapathNetlist::new(*config)?;
        // Synthesis can leave some out.
        let flip_flops = datapath.top().register_bits();
        text += &row(name, contents, datapath.latency(), flip_flops, measured(report), baseline.as_ref().map(known));
    }
    Ok(text)
}

/// Area and slowest path.
type Figures = (f64, f64);

fn measured(report: &Report) -> Figures {
    (report.area.total, report.slowest.ns)
}

fn known(baseline: &Baseline) -> Figures {
    (baseline.area.total, baseline.slowest.ns)
}

fn row(
    name: &str,
    contents: &str,
    latency: u32,
    flip_flops: u64,
    (area, ns): Figures,
    baseline: Option<Figures>,
) -> String {
    let bits = grouped(flip_flops);
    let [area, slowest] = baseline
        .filter(|(area, ns)| *area > 0.0 && *ns > 0.0)
        .map_or_else(Default::default, |(their_area, their_ns)| {
            [area / their_area, ns / their_ns].map(|multiple| format!("{multiple:.2}"))
        });
    format!("| `{name}` | {contents} | {bits} | {latency} | {area} | {slowest} |\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_have_multiples_where_there_is_a_baseline() {
        let measured = (1_221_000.0, 14.15);
        let known = row("paper", "four operations", 12, 11_023, measured, Some((2_326_000.0, 17.6)));
        assert_eq!(known, "| `paper` | four operations | 11,023 | 12 | 0.52 | 0.80 |\n");
        let unknown = row("search", "64 lanes", 12, 30_757, measured, None);
        assert_eq!(unknown, "| `search` | 64 lanes | 30,757 | 12 |  |  |\n");
    }

    #[test]
    fn quantised_boxes_have_no_baseline() {
        let original = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/original");
        let compared = |name: &str| {
            let preset = PRESETS.iter().find(|preset| preset.name == name).expect("a preset");
            baseline(&original, preset.config).expect("a report").map(|baseline| baseline.design)
        };
        assert_eq!(compared("paper").as_deref(), Some("the original, 16 lanes"));
        assert!(compared("compact").is_some_and(|design| design != "the original, 16 lanes"));
        assert_eq!([compared("quantised"), compared("search")], [None, None]);
    }
}
