//! The utilisation of a datapath's units: Table VIII with the share of cycles in which each unit worked.

use raypath_rtl::report::tables::{self, right_aligned};
use raypath_rtl::{DatapathNetlist, UnitKind};
use raypath_timing::report::{StageUse, UnitUse};

/// The names of a datapath's operations, indexed by opcode; empty for an unused opcode.
pub fn operations(datapath: &DatapathNetlist) -> Vec<String> {
    let mut names = Vec::new();
    for (name, opcode) in datapath.operations() {
        let index = opcode as usize;
        names.resize(names.len().max(index + 1), String::new());
        names[index] = name.to_string();
    }
    names
}

/// The utilisation of each step after the input registers, over `cycles` cycles in which `jobs` jobs of each operation,
/// indexed by opcode, passed. A unit works for a job if the job's operation uses it.
pub fn utilisation(datapath: &DatapathNetlist, cycles: u64, jobs: &[u64]) -> Vec<StageUse> {
    let (steps, operations) = (datapath.steps().enumerate().skip(1), operations(datapath));
    steps.map(|(index, _)| stage(datapath, index, cycles, jobs, &operations)).collect()
}

fn stage(datapath: &DatapathNetlist, index: usize, cycles: u64, jobs: &[u64], operations: &[String]) -> StageUse {
    let (units, schedule) = (datapath.units(index), datapath.schedule(index));
    let note = |name: &String| schedule.iter().find(|note| note.operation == name);
    let titles = operations.iter().map(|name| note(name).map_or_else(String::new, |note| note.what.clone())).collect();
    let kinds = UnitKind::ALL.into_iter().filter(|&unit| units.of(unit) > 0);
    let unit = |unit: UnitKind| {
        let count = units.of(unit);
        let available = cycles.max(1) as f64 * count as f64;
        let by_operation = operations.iter().enumerate().map(|(opcode, name)| {
            let used = note(name).map_or(0, |note| note.units.of(unit));
            jobs.get(opcode).copied().unwrap_or(0) as f64 * used as f64 / available
        });
        let by_operation: Vec<f64> = by_operation.collect();
        UnitUse { name: unit.to_string(), count, total: by_operation.iter().sum(), by_operation }
    };
    StageUse { number: index, titles, units: kinds.map(unit).collect() }
}

/// A table of utilisation, with a column for each operation that had jobs. `operations` are the names by opcode.
pub fn table(stages: &[StageUse], operations: &[String]) -> String {
    let share = |unit: &UnitUse, opcode: usize| unit.by_operation.get(opcode).copied().unwrap_or(0.0);
    let is_busy = |opcode: usize| stages.iter().flat_map(|stage| &stage.units).any(|unit| share(unit, opcode) > 0.0);
    let busy: Vec<(usize, &String)> = operations.iter().enumerate().filter(|&(opcode, _)| is_busy(opcode)).collect();
    let mut head = vec!["stage".to_string(), "units".to_string(), "busy".to_string()];
    head.extend(busy.iter().map(|(_, name)| name.to_string()));
    let units = stages.iter().flat_map(|stage| stage.units.iter().map(move |unit| (stage.number, unit)));
    let rows = units.map(|(number, unit)| {
        let mut row = vec![number.to_string(), format!("{} x {}", unit.count, unit.name), percent(unit.total)];
        row.extend(busy.iter().map(|&(opcode, _)| percent(share(unit, opcode))));
        row
    });
    right_aligned(tables::table(head, rows), 2)
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use raypath_rtl::Config;

    /// Computed by hand from Table VIII: stage 2 has 24 adders; boxes use all, triangles nine, Euclidean beats sixteen.
    #[test]
    fn utilisation_follows_from_the_jobs() {
        let datapath = DatapathNetlist::new(Config::DEFAULT).unwrap();
        let jobs = [10, 20, 30, 0];
        let stages = utilisation(&datapath, 100, &jobs);
        let adders = stages[1].units.iter().find(|unit| unit.name == "adder").unwrap();
        assert_eq!((stages[1].number, adders.count), (2, 24));
        let expected = [10.0 * 9.0, 20.0 * 24.0, 30.0 * 16.0, 0.0].map(|used| used / (100.0 * 24.0));
        assert_eq!(adders.by_operation, expected);
        assert!((adders.total - expected.iter().sum::<f64>()).abs() < 1e-12);
        assert!(stages.iter().flat_map(|stage| &stage.units).all(|unit| unit.total <= 0.6 + 1e-12));
    }
}
