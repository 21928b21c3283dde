//! Budgets: how many units an operation may use in each stage.

use crate::error::{Error, Shortage};
use crate::ir::graph::OperationGraph;
use crate::ir::liveness;
use crate::ir::position::{STAGES, Stage};
use crate::ir::units::{UnitKind, Units};

/// The greatest number of adders, multipliers and comparators that an operation may use in each stage. Conversions do
/// not count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget([Units; STAGES as usize + 1]);

impl Budget {
    /// The paper's Table VIII, for 16 lanes; the two quad-sorters of stage 10 count five comparators each.
    pub const TABLE_VIII: Self = Self([
        units(0, 0, 0),
        units(0, 0, 0),
        units(24, 0, 0),
        units(0, 24, 0),
        units(8, 0, 36),
        units(0, 6, 4),
        units(4, 0, 0),
        units(0, 3, 0),
        units(2, 0, 0),
        units(2, 0, 0),
        units(1, 0, 15),
        units(0, 0, 0),
    ]);

    /// No limits.
    pub const UNLIMITED: Self =
        Self([Units { sum: usize::MAX, ..units(usize::MAX, usize::MAX, usize::MAX) }; STAGES as usize + 1]);

    /// No units at all.
    pub(crate) const NOTHING: Self = Self([units(0, 0, 0); STAGES as usize + 1]);

    /// The budget with these limits for each stage, from 1. If units have a latency of one step,
    /// `Budget::by_stage(|stage| datapath.units(stage as usize))` is the budget of the units of another datapath.
    pub fn by_stage(limits: impl Fn(u32) -> Units) -> Self {
        let mut budget = Self::NOTHING;
        for stage in 1..=STAGES {
            budget.0[stage as usize] = limits(stage);
        }
        budget
    }

    /// The limits of a stage; zero if there is no such stage.
    pub fn units(&self, stage: u32) -> Units {
        self.0.get(stage as usize).copied().unwrap_or_default()
    }

    /// The units that an operation uses. Its stages must be assigned.
    pub(crate) fn used_by(graph: &OperationGraph<Stage>) -> Self {
        let mut used = Self::NOTHING;
        for (units, values) in used.0.iter_mut().zip(liveness::analyse(graph, STAGES)) {
            for (kind, _) in values.made.iter().filter_map(|&id| graph.unit_part(id)) {
                *units.of_mut(kind) += 1;
            }
        }
        used
    }

    /// The greater limit of both in each stage.
    pub(crate) fn or(self, other: &Self) -> Self {
        Self::by_stage(|stage| {
            let (mut units, other) = (self.units(stage), other.units(stage));
            for kind in KINDS {
                *units.of_mut(kind) = units.of(kind).max(other.of(kind));
            }
            units
        })
    }

    /// Checks that an operation stays within the budget. Its stages must be assigned.
    pub(crate) fn check(&self, graph: &OperationGraph<Stage>) -> Result<(), Error> {
        let used = Self::used_by(graph);
        let cells = (1..=STAGES).flat_map(|stage| KINDS.map(|kind| (stage, kind)));
        let all = cells.map(|(stage, kind)| {
            let (needed, allowed) = (used.units(stage).of(kind), self.units(stage).of(kind));
            Shortage { stage, kind, needed, allowed }
        });
        let shortages: Vec<Shortage> = all.filter(|cell| cell.needed > cell.allowed).collect();
        if shortages.is_empty() {
            return Ok(());
        }
        Err(Error::TooManyUnits { operation: graph.name, shortages })
    }
}

/// The kinds of units that a budget counts.
pub const KINDS: [UnitKind; 3] = [UnitKind::Add, UnitKind::Multiply, UnitKind::Compare];

const fn units(add: usize, multiply: usize, compare: usize) -> Units {
    Units { encode: 0, add, sum: 0, multiply, compare, decode: 0 }
}
