//! How busy the units of a datapath were: Table VIII with use in it.

use crate::tables::new_table;
use comfy_table::CellAlignment;
use raypath_ops::JobKind;
use raypath_report::{StageUse, UnitUse};
use raypath_rtl::{Datapath, UnitKind};

/// For each step of the pipeline after the input's registers, its units and the part of `cycles` in which they worked,
/// where so many jobs of each kind, by opcode, have passed. A unit works for a job if the job's operation uses it.
pub fn utilisation(datapath: &Datapath, cycles: u64, jobs: [u64; JobKind::ALL.len()]) -> Vec<StageUse> {
    let steps = datapath.steps().enumerate().skip(1);
    steps.map(|(index, _)| stage(datapath, index, cycles, jobs)).collect()
}

fn stage(datapath: &Datapath, index: usize, cycles: u64, jobs: [u64; JobKind::ALL.len()]) -> StageUse {
    let (units, schedule) = (datapath.units(index), datapath.schedule(index));
    let note = |kind: JobKind| schedule.iter().find(|note| note.operation == kind.name());
    let titles = JobKind::ALL.map(|kind| note(kind).map_or_else(String::new, |note| note.what.clone()));
    let kinds = UnitKind::ALL.into_iter().filter(|&unit| units.of(unit) > 0);
    let unit = |unit: UnitKind| {
        let count = units.of(unit);
        let there = cycles.max(1) as f64 * count as f64;
        let by_operation = JobKind::ALL.map(|kind| {
            let used = note(kind).map_or(0, |note| note.units.of(unit));
            jobs[kind as usize] as f64 * used as f64 / there
        });
        UnitUse { name: unit.to_string(), count, total: by_operation.iter().sum(), by_operation: by_operation.to_vec() }
    };
    StageUse { number: index, titles: titles.to_vec(), units: kinds.map(unit).collect() }
}

/// The same as a table for the terminal: only operations that had jobs have a column.
pub fn table(stages: &[StageUse]) -> String {
    let busy = |kind: &JobKind| {
        let of = |unit: &UnitUse| unit.by_operation.get(*kind as usize).is_some_and(|&part| part > 0.0);
        stages.iter().flat_map(|stage| &stage.units).any(of)
    };
    let kinds: Vec<JobKind> = JobKind::ALL.into_iter().filter(busy).collect();
    let mut table = new_table();
    let mut head = vec!["stage".to_string(), "units".to_string(), "busy".to_string()];
    head.extend(kinds.iter().map(ToString::to_string));
    table.set_header(head);
    for stage in stages {
        for unit in &stage.units {
            let mut row =
                vec![stage.number.to_string(), format!("{} x {}", unit.count, unit.name), percent(unit.total)];
            row.extend(kinds.iter().map(|kind| percent(unit.by_operation[*kind as usize])));
            table.add_row(row);
        }
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.to_string()
}

fn percent(part: f64) -> String {
    format!("{:.1} %", 100.0 * part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use raypath_rtl::Config;

    /// By hand, from Table VIII: stage 2 has 24 adders, of which boxes use all, triangles nine, Euclidean beats sixteen.
    #[test]
    fn units_are_as_busy_as_their_jobs_make_them() {
        let datapath = Datapath::new(Config::DEFAULT).unwrap();
        let jobs = [10, 20, 30, 0];
        let stages = utilisation(&datapath, 100, jobs);
        let adders = stages[1].units.iter().find(|unit| unit.name == "adder").unwrap();
        assert_eq!((stages[1].number, adders.count), (2, 24));
        let expected = [10.0 * 9.0, 20.0 * 24.0, 30.0 * 16.0, 0.0].map(|used| used / (100.0 * 24.0));
        assert_eq!(adders.by_operation, expected);
        assert!((adders.total - expected.iter().sum::<f64>()).abs() < 1e-12);
        assert!(stages.iter().flat_map(|stage| &stage.units).all(|unit| unit.total <= 0.6 + 1e-12));
    }
}
