//! The plan of a datapath: the units of every step and the registers of every boundary.

use crate::allocate::affinity::Affinity;
use crate::allocate::alike::{Alike, alike};
use crate::allocate::binding::{self, Bindings, StepValues};
use crate::allocate::delays::{Delay, delays};
use crate::allocate::layout::{Layout, Origin, RegisterSlot};
use crate::allocate::{lanes, registers, terms};
use crate::config::{Control, Encoding, Interval, Microarchitecture, UnitSharing};
use crate::error::Error;
use crate::fold::{self, Rounds};
use crate::ir::graph::{Kind, NodeId, Op, OperationGraph, StateValue};
use crate::ir::liveness::{self, PositionValues};
use crate::ir::position::{Step, StepLabel};
use crate::ir::units::{Unit, UnitKind, Units};
use crate::ir::widths::Widths;
use raypath_float::Format;
use std::collections::{BTreeMap, BTreeSet};

/// Bits of the paper's opcode. Datapaths with fewer operations have the same port.
const PAPER_OPCODE_WIDTH: u32 = 2;

/// The plan of a datapath, from which the netlist is emitted.
#[derive(Debug)]
pub struct Plan {
    /// The format of all numbers.
    pub format: Format,
    /// How the datapath is built.
    pub microarchitecture: Microarchitecture,
    /// The operations, with their values in steps.
    pub operations: Vec<OperationGraph<Step>>,
    /// The significands of the operations' numbers.
    pub widths: Widths,
    /// All steps; the first is the input's registers.
    pub steps: Vec<StepPlan>,
    /// When a folded pipeline computes its values; `None` if it accepts a job per cycle.
    pub rounds: Option<Rounds>,
}

/// A step and the registers after it.
#[derive(Debug)]
pub struct StepPlan {
    /// Its name.
    pub label: StepLabel,
    /// The units of each operation's values.
    pub bindings: Vec<Bindings>,
    /// The values that each operation computes.
    pub made: Vec<Vec<NodeId>>,
    /// In a folded pipeline, the values that are the same net, for each operation.
    pub alike: Vec<Alike>,
    /// The registers after it.
    pub layout: Layout,
    /// The number registers after it that are memories or wires.
    pub delays: BTreeMap<usize, Delay>,
}

impl Plan {
    /// Allocates units and registers to operations that are expanded to the steps with these labels.
    ///
    /// # Errors
    /// A folded pipeline for which no schedule was found.
    pub fn new(
        mut operations: Vec<OperationGraph<Step>>,
        labels: Vec<StepLabel>,
        format: Format,
        microarchitecture: Microarchitecture,
    ) -> Result<Self, Error> {
        let last = labels.len() as u32 - 1;
        let values: Vec<Vec<PositionValues>> = operations.iter().map(|graph| liveness::analyse(graph, last)).collect();
        let affinities: Vec<Affinity> = operations.iter().map(Affinity::new).collect();
        let widths = Widths::of(&operations, format);
        let interval = microarchitecture.interval;
        let rounds = match interval {
            Interval::One => None,
            _ => {
                let most = match microarchitecture.control {
                    Control::Skid => fold::MAX_ELASTIC_POSITIONS,
                    Control::Credit => fold::MAX_POSITIONS,
                };
                Some(fold::plan(interval.cycles(), &operations, &values, format, most).ok_or_else(|| {
                    let problem = format!("no schedule found for {interval}, expected a smaller interval");
                    Error::Feature { feature: "interval", problem }
                })?)
            }
        };
        let mut steps: Vec<StepPlan> = Vec::new();
        for (index, label) in labels.into_iter().enumerate() {
            let here: Vec<&PositionValues> = values.iter().map(|values| &values[index]).collect();
            let empty = Layout::default();
            let before = steps.last().map_or(&empty, |plan| &plan.layout);
            if microarchitecture.units == UnitSharing::Shared {
                terms::align(&mut operations, &here, before);
            }
            let same = |bindings: &[Bindings]| -> Vec<Alike> {
                let each = operations.iter().zip(&here).zip(bindings).enumerate();
                let folded = each.filter(|_| rounds.is_some());
                folded.map(|(op, ((graph, values), own))| alike(graph, op, &values.made, before, own)).collect()
            };
            let step = StepValues {
                operations: &operations,
                widths: &widths,
                values: &here,
                before,
                alike: &same(&vec![Bindings::new(); operations.len()]),
                sharing: microarchitecture.units,
            };
            let bindings = binding::bind(&step, |op, id| {
                rounds.as_ref().map_or(0, |rounds| rounds.units[op][index].get(&id).copied().unwrap_or(0))
            });
            let alike = same(&bindings);
            let origin = |op, id| origin(&operations, before, &bindings, &alike, op, id);
            let sharing = microarchitecture.sharing;
            let layout = match &rounds {
                None => {
                    let carried: Vec<Vec<NodeId>> = here.iter().map(|values| values.carried.clone()).collect();
                    registers::allocate(sharing, &operations, &carried, &affinities, before, origin)
                }
                Some(rounds) => lanes::allocate(sharing, &operations, rounds, index, &affinities, origin),
            };
            let made = here.iter().map(|values| values.made.clone()).collect();
            steps.push(StepPlan { label, bindings, made, alike, layout, delays: BTreeMap::new() });
        }
        let mut plan = Self { format, microarchitecture, operations, widths, steps, rounds };
        for (step, delays) in delays(&plan, microarchitecture.delay_lines).into_iter().enumerate() {
            plan.steps[step].delays = delays;
        }
        Ok(plan)
    }

    /// Bits of the opcode: as many as the greatest needs, and at least as many as in the paper.
    pub fn opcode_width(&self) -> u32 {
        let largest = self.operations.iter().map(|graph| graph.opcode).max().unwrap_or(0);
        (u64::BITS - largest.leading_zeros()).max(PAPER_OPCODE_WIDTH)
    }

    /// The last step.
    pub fn last(&self) -> usize {
        self.steps.len() - 1
    }

    /// Cycles from the acceptance of a job to its outcome: one for each boundary, or in a folded pipeline one for each
    /// position and one for the exit.
    pub fn latency(&self) -> u32 {
        self.rounds.as_ref().map_or(self.steps.len() as u32, |rounds| rounds.positions() + 1)
    }

    /// The number of jobs that the datapath can hold while the sink is not ready.
    pub fn capacity(&self) -> u64 {
        let (latency, interval) = (u64::from(self.latency()), u64::from(self.microarchitecture.interval.cycles()));
        match self.microarchitecture.control {
            Control::Skid if interval > 1 => (latency - 1).div_ceil(interval) + 2,
            Control::Skid => 2 * latency,
            // As many as the source offers until the first credit returns.
            Control::Credit => (latency + 1).div_ceil(interval),
        }
    }

    /// The cycles after a job of an operation in which no other one of it may enter, because it reads state before this
    /// job has written it.
    pub fn spacing(&self, op: usize) -> u32 {
        let graph = &self.operations[op];
        let Some(rounds) = &self.rounds else { return graph.spacing() };
        // Accumulators may be in different rounds.
        let spacing = |(number, state): (usize, &StateValue<Step>)| {
            let reads = |id: &NodeId| graph.operands(*id).iter().any(|&o| graph.node(o).op == Op::State(number));
            let readers = rounds.units[op][state.read.0 as usize].iter().filter(|(id, _)| reads(id));
            let read = readers.map(|(_, position)| *position).min();
            let steps = state.written.0.saturating_sub(state.read.0);
            read.map_or(steps, |read| rounds.states[op][number].saturating_sub(read))
        };
        graph.states.iter().enumerate().map(spacing).max().unwrap_or(0)
    }

    /// The driver of a value in a step.
    pub fn origin(&self, step: usize, op: usize, id: NodeId) -> Origin {
        let none = Layout::default();
        let before = step.checked_sub(1).map_or(&none, |before| &self.steps[before].layout);
        let plan = &self.steps[step];
        origin(&self.operations, before, &plan.bindings, &plan.alike, op, id)
    }

    /// The units of a step, or their parts, sorted by kind.
    pub fn units(&self, step: usize) -> BTreeSet<Unit> {
        self.steps[step].bindings.iter().flat_map(BTreeMap::values).map(|binding| binding.unit).collect()
    }

    /// The values that a unit of a step computes, with their operations.
    pub fn users(&self, step: usize, unit: Unit) -> Vec<(usize, NodeId)> {
        let bindings = &self.steps[step].bindings;
        let of = |op: usize| {
            bindings[op].iter().filter(move |(_, binding)| binding.unit == unit).map(move |(&id, _)| (op, id))
        };
        (0..bindings.len()).flat_map(of).collect()
    }

    /// Whether an operation reads what rounding takes from a product of this multiplier.
    pub fn has_residue(&self, step: usize, unit: Unit) -> bool {
        let reads = |(op, id): (usize, NodeId)| self.operations[op].reads_residue(id);
        unit.kind == UnitKind::Multiply && self.users(step, unit).into_iter().any(reads)
    }

    /// The numbers of encoders and decoders that an operation uses in a step.
    pub fn conversions(&self, step: usize, op: usize) -> Units {
        let mut units = Units::default();
        let Some(before) = step.checked_sub(1) else { return units };
        let (after, layout) = (self.encoding(step), &self.steps[before].layout);
        let number = |id: NodeId| match layout.slot(op, id) {
            Some(RegisterSlot::Number(register)) => Some(register),
            _ => None,
        };
        let graph = &self.operations[op];
        let carried: Vec<NodeId> = self.steps[step].layout.slots[op].keys().copied().collect();
        let carried = carried.into_iter().filter(|&id| graph.node(id).kind == Kind::Number);
        let passing = |id: NodeId| number(id).is_some() && self.encoding(before) == Encoding::Ieee;
        if after == Encoding::Ieee {
            units.decode = carried.clone().filter(|&id| !passing(id)).count();
        }
        if self.encoding(before) == Encoding::Ieee {
            let read = self.steps[step].made[op].iter().filter(|&&id| !matches!(graph.node(id).op, Op::Test(..)));
            let read = read.flat_map(|&id| graph.operands(id));
            let passed = carried.filter(|_| after == Encoding::Recoded);
            units.encode = read.chain(passed).filter_map(number).collect::<BTreeSet<_>>().len();
        }
        units
    }

    /// The encoding of numbers in the registers after a step.
    pub fn encoding(&self, step: usize) -> Encoding {
        if step == 0 || step == self.last() { self.microarchitecture.io } else { self.microarchitecture.registers }
    }

    /// Bits of a number in the registers after a step.
    pub fn number_width(&self, step: usize) -> u32 {
        match self.encoding(step) {
            Encoding::Ieee => self.format.ieee_width(),
            Encoding::Recoded => self.format.recoded_width(),
        }
    }
}

fn origin(
    operations: &[OperationGraph<Step>],
    before: &Layout,
    bindings: &[Bindings],
    alike: &[Alike],
    op: usize,
    id: NodeId,
) -> Origin {
    if let Some(slot) = before.slot(op, id) {
        return Origin::Register(slot);
    }
    let logic = || Origin::Logic(op, *alike.get(op).and_then(|alike| alike.get(&id)).unwrap_or(&id));
    let node = operations[op].node(id);
    match &node.op {
        Op::Input(port) => Origin::Port(port.clone()),
        // A comparator has several results; the selection among them is the operation's logic.
        _ if node.kind == Kind::Order => logic(),
        _ => bindings[op].get(&id).map_or_else(logic, |binding| Origin::Unit(binding.unit)),
    }
}
