//! Reports as tables and text.

use crate::report::{Cells, Report, Routed, Run};
use raypath_rtl::report::tables::{right_aligned, table};
use raypath_tools::grouped;

/// A table of cells, and of the slowest path if there is one, by stage.
pub fn stages(report: &Report) -> String {
    let is_routed = report.routed.is_some();
    let ecp5 = ["LUT4", "carry cells", "multipliers", "flip-flops", "block RAM", "LUT RAM", "slowest, ns"];
    let xilinx = ["LUT", "carry cells", "DSP48", "flip-flops", "block RAM (18 kbit)", "LUT RAM", "SRL"];
    let row = |name: &str, cells: &Cells, slowest: Option<f64>| {
        let Cells { luts, carry_cells, multipliers, flip_flops, block_rams, distributed_rams, shift_registers } =
            *cells;
        let counts = [luts, carry_cells, multipliers, flip_flops, block_rams, distributed_rams].map(grouped);
        let slowest = slowest.map_or(String::new(), |ns| format!("{ns:.2}"));
        let last = if is_routed { slowest } else { grouped(shift_registers) };
        [&[name.to_string()], counts.as_slice(), &[last]].concat()
    };
    let stages = report.stages.iter().map(|stage| row(&stage.name, &stage.cells, stage.slowest_ns));
    let all = row("all", &report.cells, report.routed.as_ref().map(|routed| routed.timing.period_ns));
    let heads = [&["stage"], (if is_routed { ecp5 } else { xilinx }).as_slice()].concat();
    right_aligned(table(heads, stages.chain([all])), 1)
}

/// A table of the cells and wires on the slowest path.
pub fn path(routed: &Routed) -> String {
    let rows = routed.timing.path.iter().map(|step| {
        let [ns, at] = [step.ns, step.at_ns].map(|ns| format!("{ns:.2}"));
        [step.stage.clone(), step.signal.clone(), step.text.clone(), step.what.clone(), ns, at]
    });
    right_aligned(table(["stage", "signal", "module:line", "slowest path", "ns", "at, ns"], rows), 4)
}

/// A table of the clocks of all runs, with the best and the median of each speed grade.
pub fn runs(routed: &Routed) -> String {
    let row = |speed: u8, what: String, mhz: f64| [speed.to_string(), what, format!("{mhz:.1}")];
    let runs = routed.runs.iter().map(|run| row(run.speed, format!("seed {}", run.seed), run.clock_mhz));
    let ends = |(speed, best, median)| [("best", best), ("median", median)].map(|(of, mhz)| row(speed, of.into(), mhz));
    right_aligned(
        table(["speed grade", "run", "MHz"], runs.chain(Run::grades(&routed.runs).into_iter().flat_map(ends))),
        2,
    )
}

/// The main figures in a few lines of text.
pub fn summary(report: &Report) -> String {
    let Report { cells, synthesis, device, routed, .. } = report;
    let Some(routed) = routed else {
        return format!(
            "{synthesis}; {device}. Synthesis only: there is no clock, because nothing is placed and routed."
        );
    };
    let of =
        |kind: &str| routed.timing.used.get(kind).map_or(String::new(), |of| format!(" of {}", grouped(of.available)));
    let percent = |kind: &str| {
        let used = routed.timing.used.get(kind);
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
            "Clock {:.1} MHz: {:.2} ns, of which {:.2} ns in cells, on {} levels, and {:.2} ns on wires.",
            routed.timing.clock_mhz,
            routed.timing.period_ns,
            routed.timing.logic_ns,
            routed.timing.levels,
            routed.timing.routing_ns
        ),
        format!(
            "{synthesis} and {}; {device}, speed grade {}, placed for {} MHz with seed {}.",
            routed.place_and_route, routed.speed, routed.aim_mhz, routed.seed
        ),
    ];
    lines.join("\n")
}

fn share(part: u64, whole: u64) -> f64 {
    100.0 * part as f64 / whole.max(1) as f64
}
