//! Measurements as tables and text.

use crate::{Area, Baseline, Exploration, Power, Report, Stage, WorkloadPower};
use comfy_table::{CellAlignment, Table};
use raypath_rtl::report::tables::table;
use raypath_tools::grouped;
use std::collections::{BTreeMap, BTreeSet};

/// A table as text: its head and its rows.
pub(crate) struct Cells {
    pub head: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Cells {
    /// The table; columns of numbers from `from` on are aligned to the right.
    fn printed(self, from: usize) -> String {
        aligned(table(self.head, self.rows), from)
    }
}

/// A table of area by stage and kind, and of flip-flops by stage.
pub fn areas(report: &Report) -> String {
    area_cells(report).printed(2)
}

pub(crate) fn area_cells(report: &Report) -> Cells {
    let kinds = Area::default().other_kinds().map(|(kind, _)| kind);
    let head = [&["stage", "units", "area of units"], kinds.as_slice(), &["all", "share", "flip-flops"]].concat();
    let whole = report.area.total;
    let row = |name: &str, units: String, area: &Area, flip_flops: u64| {
        let mut cells = vec![name.to_string(), units, rounded(area.units_area())];
        cells.extend(area.other_kinds().map(|(_, area)| rounded(area)));
        cells.extend([rounded(area.total), percent(area.total / whole), grouped(flip_flops)]);
        cells
    };
    let of_stage = |stage: &Stage| {
        let units = stage.area.units.iter().map(|(kind, units)| format!("{} {kind}", units.count));
        row(&stage.name, units.collect::<Vec<_>>().join(", "), &stage.area, stage.flip_flops)
    };
    let mut rows: Vec<Vec<String>> = report.stages.iter().map(of_stage).collect();
    let units: u64 = report.area.units.values().map(|units| units.count).sum();
    rows.push(row("all", grouped(units), &report.area, report.flip_flops));
    let mut shares = vec!["share".to_string(), String::new(), percent(report.area.unit_share())];
    shares.extend(report.area.other_kinds().map(|(_, area)| percent(area / whole)));
    rows.push(shares);
    Cells { head: head.into_iter().map(str::to_string).collect(), rows }
}

/// A table of units by kind: number, area of one, area of all.
pub fn units(report: &Report) -> String {
    let rows = report.area.units.iter().map(|(kind, units)| {
        let one = units.area / units.count as f64;
        let share = percent(units.area / report.area.total);
        [kind.clone(), grouped(units.count), rounded(one), rounded(units.area), share]
    });
    aligned(table(["unit", "number", "area of one", "area of all", "share"], rows), 1)
}

/// A table of the slowest path to each stage: its delay, its ends and the elements between.
pub fn paths(report: &Report) -> String {
    path_cells(report).printed(1)
}

pub(crate) fn path_cells(report: &Report) -> Cells {
    let row = |stage: &Stage| {
        let path = stage.slowest.as_ref()?;
        let between = path.steps.get(1..path.steps.len().saturating_sub(1)).unwrap_or_default();
        let through: Vec<String> = between.iter().map(|step| format!("{} {:.2}", step.through, step.ns)).collect();
        let ns = format!("{:.2}", path.ns);
        Some(vec![stage.name.clone(), ns, path.start.clone(), through.join(", "), path.end.clone()])
    };
    let head = ["ends in", "ns", "from", "through (ns at its end)", "to"].map(str::to_string).to_vec();
    Cells { head, rows: report.stages.iter().filter_map(row).collect() }
}

/// The main figures in three lines of text.
pub fn summary(report: &Report) -> String {
    let Report { setting, area, slowest, .. } = report;
    let memories = match report.memory_bits {
        0 => String::new(),
        bits => format!("; memories of {} bits are not in it", grouped(bits)),
    };
    let lines = [
        format!(
            "Area {:.3} mm² = {:.1} kGE ({} = 1 GE), {} of it units; {} flip-flops{memories}.",
            area.total / 1e6,
            report.kilo_gates,
            setting.nand2,
            percent(area.unit_share()),
            grouped(report.flip_flops)
        ),
        format!(
            "Slowest path {:.2} ns, to {}: {:.1} MHz; area × period {:.2} mm² ns.",
            slowest.ns, slowest.stage, report.clock_mhz, report.area_period
        ),
        format!(
            "{} and {}, library {}, gates chosen for {}; no placement, no wires, ideal clock.",
            setting.synthesis,
            setting.timing,
            setting.library,
            setting.periods()
        ),
    ];
    lines.join("\n")
}

/// A table of the report's figures divided by those of a baseline.
pub fn comparison(report: &Report, baseline: &Baseline) -> String {
    let mut rows = Vec::new();
    for stage in &report.stages {
        let Some(theirs) = baseline.stage(&stage.name) else { continue };
        let area = theirs.area.map(|theirs| ratio(stage.area.total, theirs.total));
        let flip_flops = theirs.flip_flops.map(|theirs| ratio(stage.flip_flops as f64, theirs as f64));
        let slowest =
            stage.slowest.as_ref().zip(theirs.slowest.as_ref()).map(|(ours, theirs)| ratio(ours.ns, theirs.ns));
        let cells = [area, flip_flops, slowest].map(Option::unwrap_or_default);
        rows.push([std::slice::from_ref(&stage.name), cells.as_slice()].concat());
    }
    rows.push(vec![
        "all".to_string(),
        ratio(report.area.total, baseline.area.total),
        ratio(report.flip_flops as f64, baseline.flip_flops as f64),
        ratio(report.slowest.ns, baseline.slowest.ns),
    ]);
    aligned(table(["stage", "area", "flip-flops", "slowest path"], rows), 1)
}

/// A table of configurations, a row each.
pub fn explored(exploration: &Exploration) -> String {
    let head = ["", "mm²", "kGE", "flip-flops", "ns", "slowest", "MHz", "mm² ns", "box tests/s", "dimensions/s"];
    let rows = exploration.points.iter().map(|point| {
        let report = &point.report;
        [
            point.name.clone(),
            format!("{:.3}", report.area.total / 1e6),
            format!("{:.1}", report.kilo_gates),
            grouped(report.flip_flops),
            format!("{:.2}", report.slowest.ns),
            report.slowest.stage.clone(),
            format!("{:.1}", report.clock_mhz),
            format!("{:.2}", report.area_period),
            millions(point.boxes_per_second),
            millions(point.dimensions_per_second),
        ]
    });
    aligned(table(head, rows), 1)
}

/// A table of workloads, a row each: power, energy of a cycle and of a job, and their parts.
pub fn workloads(power: &Power) -> String {
    let head = ["workload", "jobs", "mW", "pJ per cycle", "pJ per job", "clock pins", "in cells", "loads", "leakage"];
    let rows = power.workloads.iter().map(|workload| {
        let whole = workload.picojoules_per_cycle;
        let parts = [workload.clock, workload.internal, workload.switching, workload.leakage];
        let shares = parts.map(|part| percent(part / whole));
        let figures = [
            workload.name.clone(),
            grouped(workload.jobs),
            format!("{:.2}", workload.milliwatts),
            format!("{whole:.1}"),
            workload.picojoules_per_job.map(|energy| format!("{energy:.1}")).unwrap_or_default(),
        ];
        figures.into_iter().chain(shares)
    });
    aligned(table(head, rows), 1)
}

/// A table of energy by kind, a column for each workload.
pub fn energy_by_kind(power: &Power) -> String {
    let kinds: Vec<BTreeMap<&str, f64>> = power.workloads.iter().map(WorkloadPower::kinds).collect();
    let names: BTreeSet<&str> = kinds.iter().flat_map(|kinds| kinds.keys().copied()).collect();
    let row = |name: &str| kinds.iter().map(|kinds| kinds.get(name).copied().unwrap_or(0.0)).collect();
    energies("kind", power, names.into_iter().map(|name| (name, row(name))))
}

/// A table of energy by stage, a column for each workload.
pub fn energy_by_stage(power: &Power) -> String {
    let stages = power.workloads.first().map(|workload| workload.stages.as_slice()).unwrap_or_default();
    let row = |number: usize| {
        let of = |workload: &WorkloadPower| workload.stages.get(number).map_or(0.0, |stage| stage.picojoules);
        power.workloads.iter().map(of).collect()
    };
    energies("stage", power, stages.iter().enumerate().map(|(number, stage)| (stage.name.as_str(), row(number))))
}

fn energies<'r>(what: &str, power: &Power, rows: impl Iterator<Item = (&'r str, Vec<f64>)>) -> String {
    let names = power.workloads.iter().map(|workload| workload.name.as_str());
    let rows = rows.map(|(name, figures)| {
        let figures = figures.into_iter().map(|energy| format!("{energy:.2}"));
        [name.to_string()].into_iter().chain(figures)
    });
    aligned(table([what].into_iter().chain(names), rows), 1)
}

/// The conditions of power figures, and the share of idle power, as text.
pub fn power_summary(power: &Power) -> String {
    let find = |is_idle: bool| power.workloads.iter().filter(move |workload| (workload.jobs == 0) == is_idle);
    let idle = find(true).next().map_or(0.0, |workload| workload.milliwatts);
    let busy = find(false).map(|workload| workload.milliwatts).fold(0.0, f64::max);
    let lines = [
        format!("Idle power is {} of the highest.", percent(if busy > 0.0 { idle / busy } else { 0.0 })),
        format!(
            "Clock period {:.2} ns. The gates gave the outputs of the netlist and of the models in {} cycles.",
            power.period_ns,
            grouped(power.compared_cycles)
        ),
        "Energies of cells by OpenSTA; no glitches, no wires, no clock tree.".to_string(),
    ];
    lines.join("\n")
}

/// Aligns columns of numbers to the right: each column from `from` on, all of whose cells begin with digits.
pub(crate) fn aligned(mut table: Table, from: usize) -> String {
    for index in from..table.column_count() {
        let numbers = table.column_cells_iter(index).flatten().all(|cell| {
            let content = cell.content();
            content.is_empty() || content.starts_with(|c: char| c.is_ascii_digit())
        });
        if let Some(column) = table.column_mut(index).filter(|_| numbers) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table.to_string()
}

fn rounded(area: f64) -> String {
    if area == 0.0 { String::new() } else { grouped(area.round() as u64) }
}

fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}

fn ratio(ours: f64, theirs: f64) -> String {
    if theirs > 0.0 { format!("{:.3}", ours / theirs) } else { String::new() }
}

fn millions(per_second: f64) -> String {
    if per_second == 0.0 { String::new() } else { format!("{} M", grouped((per_second / 1e6).round() as u64)) }
}
