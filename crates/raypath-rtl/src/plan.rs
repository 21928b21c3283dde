//! The plan of a datapath: for every step its units, and for every boundary who lives where.

use crate::binding::{self, Bindings};
use crate::config::{Control, Encoding, Microarchitecture};
use crate::demand::Demands;
use crate::graph::{Kind, NodeId, Op, Traced};
use crate::liveness::{self, Work};
use crate::place::{Layout, Origin, Place};
use crate::steps::{self, Step};
use crate::units::{Unit, Units};
use raypath_float::Format;
use std::collections::{BTreeMap, BTreeSet};

/// Bits of the paper's opcode. Datapaths that have fewer operations keep the port.
const PAPER_OPCODE_WIDTH: u32 = 2;

/// Everything that the netlist follows from.
#[derive(Debug)]
pub struct Plan {
    pub format: Format,
    pub microarchitecture: Microarchitecture,
    /// The operations, their values in steps.
    pub operations: Vec<Traced>,
    /// Step 0, which is the input's registers, to the last.
    pub steps: Vec<StepPlan>,
}

/// A step and the registers after it.
#[derive(Debug)]
pub struct StepPlan {
    /// Its place in Table VII.
    pub step: Step,
    /// The unit of each value that needs one, operation by operation.
    pub bindings: Vec<Bindings>,
    /// What each operation makes.
    pub made: Vec<Vec<NodeId>>,
    /// The registers after it.
    pub layout: Layout,
}

impl Plan {
    pub fn new(operations: &[Traced], format: Format, microarchitecture: Microarchitecture) -> Self {
        let (operations, steps) = steps::expand(operations, microarchitecture.unit_latency.steps());
        let last = steps.len() as u32 - 1;
        let works: Vec<Vec<Work>> = operations.iter().map(|traced| liveness::work(traced, last)).collect();
        let demands: Vec<Demands> = operations.iter().map(Demands::new).collect();
        let mut plans: Vec<StepPlan> = Vec::new();
        for (index, step) in steps.into_iter().enumerate() {
            let here: Vec<&Work> = works.iter().map(|works| &works[index]).collect();
            let carried: Vec<Vec<NodeId>> = here.iter().map(|work| work.carried.clone()).collect();
            let nothing = Layout::default();
            let before = plans.last().map_or(&nothing, |plan| &plan.layout);
            let bindings = binding::bind(&operations, &here, before);
            let origin = |op, id| origin(&operations, before, &bindings, op, id);
            let layout = Layout::new(microarchitecture.sharing, &operations, &carried, &demands, before, origin);
            let made = works.iter().map(|works| works[index].made.clone()).collect();
            plans.push(StepPlan { step, bindings, made, layout });
        }
        Self { format, microarchitecture, operations, steps: plans }
    }

    /// Bits of the opcode: what the largest one needs, but no fewer than the paper has.
    pub fn opcode_width(&self) -> u32 {
        let largest = self.operations.iter().map(|traced| traced.opcode).max().unwrap_or(0);
        (u64::BITS - largest.leading_zeros()).max(PAPER_OPCODE_WIDTH)
    }

    /// The last step.
    pub fn last(&self) -> usize {
        self.steps.len() - 1
    }

    /// Cycles from an accepted job to its outcome: one for each boundary.
    pub fn latency(&self) -> u32 {
        self.steps.len() as u32
    }

    /// Jobs that fit inside while the sink refuses.
    pub fn capacity(&self) -> u64 {
        match self.microarchitecture.control {
            Control::Skid => 2 * u64::from(self.latency()),
            Control::Credit => u64::from(self.latency()) + 1,
        }
    }

    /// What drives a value in a step.
    pub fn origin(&self, step: usize, op: usize, id: NodeId) -> Origin {
        let none = Layout::default();
        let before = step.checked_sub(1).map_or(&none, |before| &self.steps[before].layout);
        origin(&self.operations, before, &self.steps[step].bindings, op, id)
    }

    /// The units of a step, or their parts, kind by kind.
    pub fn units(&self, step: usize) -> BTreeSet<Unit> {
        self.steps[step].bindings.iter().flat_map(BTreeMap::values).map(|binding| binding.unit).collect()
    }

    /// Numbers of an operation that a step encodes and decodes.
    pub fn conversions(&self, step: usize, op: usize) -> Units {
        let mut units = Units::default();
        let Some(before) = step.checked_sub(1) else { return units };
        let (after, layout) = (self.encoding(step), &self.steps[before].layout);
        let number = |id: NodeId| match layout.places[op].get(&id) {
            Some(Place::Number(register)) => Some(*register),
            _ => None,
        };
        let traced = &self.operations[op];
        let carried: Vec<NodeId> = self.steps[step].layout.places[op].keys().copied().collect();
        let carried = carried.into_iter().filter(|&id| traced.node(id).kind == Kind::Number);
        let passing = |id: NodeId| number(id).is_some() && self.encoding(before) == Encoding::Ieee;
        if after == Encoding::Ieee {
            units.decode = carried.clone().filter(|&id| !passing(id)).count();
        }
        if self.encoding(before) == Encoding::Ieee {
            let read = self.steps[step].made[op].iter().filter(|&&id| !matches!(traced.node(id).op, Op::Test(..)));
            let read = read.flat_map(|&id| traced.operands(id));
            let passed = carried.filter(|_| after == Encoding::Recoded);
            units.encode = read.chain(passed).filter_map(number).collect::<BTreeSet<_>>().len();
        }
        units
    }

    /// How numbers stand in the registers after a step.
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

fn origin(operations: &[Traced], before: &Layout, bindings: &[Bindings], op: usize, id: NodeId) -> Origin {
    if let Some(place) = before.places.get(op).and_then(|places| places.get(&id)) {
        return Origin::Place(*place);
    }
    match &operations[op].node(id).op {
        Op::Input(port) => Origin::Port(port.clone()),
        // A comparator has several results; which of them a value is, is the operation's logic.
        Op::Compare(..) => Origin::Logic(op, id),
        _ => bindings[op].get(&id).map_or(Origin::Logic(op, id), |binding| Origin::Unit(binding.unit)),
    }
}
