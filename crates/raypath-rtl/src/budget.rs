//! How many units each stage may have.

use crate::STAGES;
use crate::error::Error;
use crate::graph::Traced;
use crate::liveness;
use crate::units::{UnitKind, Units, part};
use std::fmt;

/// The most adders, multipliers and comparators that an operation may use in each stage. Conversions stand outside it.
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

    /// As many as anyone likes.
    pub const UNLIMITED: Self = Self([units(usize::MAX, usize::MAX, usize::MAX); STAGES as usize + 1]);

    /// No units at all.
    pub(crate) const NOTHING: Self = Self([units(0, 0, 0); STAGES as usize + 1]);

    /// What `limits` says of each stage from 1 on; where units take one step,
    /// `Budget::by_stage(|stage| datapath.units(stage as usize))` is what another datapath has.
    pub fn by_stage(limits: impl Fn(u32) -> Units) -> Self {
        let mut budget = Self::NOTHING;
        for stage in 1..=STAGES {
            budget.0[stage as usize] = limits(stage);
        }
        budget
    }

    /// What it allows in a stage; nothing where there is no such stage.
    pub fn units(&self, stage: u32) -> Units {
        self.0.get(stage as usize).copied().unwrap_or_default()
    }

    /// What an operation uses, its stages being known.
    pub(crate) fn used_by(traced: &Traced) -> Self {
        let mut used = Self::NOTHING;
        for (units, work) in used.0.iter_mut().zip(liveness::work(traced, STAGES)) {
            for (kind, _) in work.made.iter().filter_map(|&id| part(traced, id)) {
                *units.of_mut(kind) += 1;
            }
        }
        used
    }

    /// Stage by stage, whichever is more.
    pub(crate) fn or(self, other: &Self) -> Self {
        Self::by_stage(|stage| {
            let (mut units, other) = (self.units(stage), other.units(stage));
            for kind in KINDS {
                *units.of_mut(kind) = units.of(kind).max(other.of(kind));
            }
            units
        })
    }

    /// That an operation whose stages are known keeps to it.
    pub(crate) fn check(&self, traced: &Traced) -> Result<(), Error> {
        let used = Self::used_by(traced);
        let cells = (1..=STAGES).flat_map(|stage| KINDS.map(|kind| (stage, kind)));
        let all = cells.map(|(stage, kind)| {
            let (needed, allowed) = (used.units(stage).of(kind), self.units(stage).of(kind));
            Shortage { stage, kind, needed, allowed }
        });
        let shortages: Vec<Shortage> = all.filter(|cell| cell.needed > cell.allowed).collect();
        if shortages.is_empty() {
            return Ok(());
        }
        Err(Error::TooManyUnits { operation: traced.name, shortages })
    }
}

/// What a budget counts.
pub const KINDS: [UnitKind; 3] = [UnitKind::Add, UnitKind::Multiply, UnitKind::Compare];

const fn units(add: usize, multiply: usize, compare: usize) -> Units {
    Units { encode: 0, add, multiply, compare, decode: 0 }
}

/// A stage that has fewer units of a kind than an operation needs there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shortage {
    /// The stage.
    pub stage: u32,
    /// The kind.
    pub kind: UnitKind,
    /// How many the operation needs.
    pub needed: usize,
    /// How many the budget allows.
    pub allowed: usize,
}

/// `stage 2 needs 24 adders of 20 allowed`.
impl fmt::Display for Shortage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { stage, kind, needed, allowed } = self;
        let plural = if *needed == 1 { "" } else { "s" };
        write!(f, "stage {stage} needs {needed} {kind}{plural}, {allowed} allowed")
    }
}
