//! The plan of a datapath: for every stage its units, and for every boundary who lives where.

use crate::STAGES;
use crate::graph::{NodeId, Op, Traced};
use crate::liveness::{self, Work};
use crate::place::{Layout, Origin};
use crate::units::{self, Unit, UnitKind, Units};
use std::collections::BTreeMap;

/// Everything that the netlist follows from.
#[derive(Debug)]
pub struct Plan {
    pub operations: Vec<Traced>,
    /// Stage 0, which is the input's registers, to the last.
    pub stages: Vec<StagePlan>,
}

/// A stage and the registers after it.
#[derive(Debug, Default)]
pub struct StagePlan {
    /// The unit of each value that needs one, operation by operation.
    pub assigned: Vec<BTreeMap<NodeId, Unit>>,
    /// How many units that makes.
    pub units: Units,
    /// The registers after it.
    pub layout: Layout,
}

impl Plan {
    pub fn new(operations: Vec<Traced>) -> Self {
        let works: Vec<Vec<Work>> = operations.iter().map(liveness::work).collect();
        let mut stages: Vec<StagePlan> = Vec::new();
        for stage in 0..=STAGES as usize {
            let assigned: Vec<_> =
                operations.iter().zip(&works).map(|(op, works)| units::assign(op, &works[stage])).collect();
            let carried: Vec<Vec<NodeId>> = works.iter().map(|works| works[stage].carried.clone()).collect();
            let nothing = Layout::default();
            let before = stages.last().map_or(&nothing, |stage| &stage.layout);
            let layout =
                Layout::new(&operations, &carried, before, |op, id| origin(&operations, before, &assigned, op, id));
            let units = count(&assigned);
            stages.push(StagePlan { assigned, units, layout });
        }
        Self { operations, stages }
    }

    /// What drives a value in the stage of these units, with these registers before it.
    pub fn origin(&self, stage: usize, op: usize, id: NodeId) -> Origin {
        let none = Layout::default();
        let before = stage.checked_sub(1).map_or(&none, |before| &self.stages[before].layout);
        origin(&self.operations, before, &self.stages[stage].assigned, op, id)
    }
}

fn origin(
    operations: &[Traced],
    before: &Layout,
    assigned: &[BTreeMap<NodeId, Unit>],
    op: usize,
    id: NodeId,
) -> Origin {
    if let Some(place) = before.places.get(op).and_then(|places| places.get(&id)) {
        return Origin::Place(*place);
    }
    match &operations[op].node(id).op {
        Op::Input(port) => Origin::Port(port.clone()),
        // A comparator has several results; which of them a value is, is the operation's logic.
        Op::Compare(..) => Origin::Logic(op, id),
        _ => assigned[op].get(&id).map_or(Origin::Logic(op, id), |unit| Origin::Unit(*unit)),
    }
}

fn count(assigned: &[BTreeMap<NodeId, Unit>]) -> Units {
    let mut units = Units::default();
    for (kind, number) in assigned.iter().flat_map(BTreeMap::values) {
        let most = units.of_mut(*kind);
        *most = (*most).max(number + 1);
    }
    units
}

/// All units of a stage, kind by kind.
pub fn all_units(units: Units) -> impl Iterator<Item = Unit> {
    UnitKind::ALL.into_iter().flat_map(move |kind| (0..units.of(kind)).map(move |number| (kind, number)))
}
