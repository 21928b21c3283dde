//! Reports as tables and text.

use crate::report::{Cells, Report};
use raypath_rtl::report::tables::{right_aligned, table};
use raypath_tools::grouped;

/// A table of cells and of the slowest path by stage.
pub fn stages(report: &Report) -> String {
    let heads = ["stage", "LUT4", "carry cells", "multipliers", "flip-flops", "block RAM", "LUT RAM", "slowest, ns"];
    let row = |name: &str, cells: &Cells, slowest: Option<f64>| {
        let Cells { luts, carry_cells, multipliers, flip_flops, block_rams, distributed_rams } = *cells;
        let counts = [luts, carry_cells, multipliers, flip_flops, block_rams, distributed_rams].map(grouped);
        let slowest = slowest.map_or(String::new(), |ns| format!("{ns:.2}"));
        [&[name.to_string()], counts.as_slice(), &[slowest]].concat()
    };
    let stages = report.stages.iter().map(|stage| row(&stage.name, &stage.cells, stage.slowest_ns));
    right_aligned(table(heads, stages.chain([row("all", &report.cells, Some(report.period_ns))])), 1)
}

/// A table of the signals on the slowest path.
pub fn path(report: &Report) -> String {
    let rows = report.path.iter().map(|step| [step.signal.clone(), format!("{:.2}", step.ns)]);
    right_aligned(table(["signal on the slowest path", "ns"], rows), 1)
}

/// The main figures in three lines of text.
pub fn summary(report: &Report) -> String {
    let Report { cells, setting, .. } = report;
    let of = |kind: &str| report.used.get(kind).map_or(String::new(), |of| format!(" of {}", grouped(of.available)));
    let percent = |kind: &str| {
        let used = report.used.get(kind);
        used.map_or(String::new(), |of| {
            format!(" ({:.0} % of the device's LUTs, with those of carry cells)", share(of.used, of.available))
        })
    };
    let lines = [
        format!(
            "{} LUT4 and {} carry cells{}, {}{} multipliers, {}{} flip-flops, {}{} block RAMs.",
            grouped(cells.luts),
            grouped(cells.carry_cells),
            percent("TRELLIS_COMB"),
            cells.multipliers,
            of("MULT18X18D"),
            grouped(cells.flip_flops),
            of("TRELLIS_FF"),
            cells.block_rams,
            of("DP16KD"),
        ),
        format!(
            "Clock {:.1} MHz: {:.2} ns, of which {:.2} ns on wires.",
            report.clock_mhz, report.period_ns, report.routing_ns
        ),
        format!(
            "{} and {}; {}, speed grade {}, placed for {} MHz with seed {}.",
            setting.synthesis, setting.place_and_route, setting.device, setting.speed, setting.aim_mhz, setting.seed
        ),
    ];
    lines.join("\n")
}

fn share(part: u64, whole: u64) -> f64 {
    100.0 * part as f64 / whole.max(1) as f64
}
