//! Evaluation of dataflows over software arithmetic, many jobs at a time. Of a dataflow with a fault, only the values
//! behind the fault are computed.

use raypath_ops::{Binary32, Circuit, Port, Single};
use raypath_rtl::dataflow::{Kind, NodeId, Op, OperationGraph, PortBit};
use std::collections::BTreeSet;

/// A dataflow, perhaps with a fault.
#[derive(Debug, Clone, PartialEq)]
pub struct Dataflow {
    /// The values.
    pub graph: OperationGraph,
    /// A truth value that is the complement of what its node computes.
    pub inverted: Option<NodeId>,
}

/// A value of each job of a step: the bits of a number, a word, or an order (an index of [`ORDERS`]).
type Column = Vec<u32>;

/// Two numbers of each order: less, equal, greater, unordered.
const ORDERS: [(f32, f32); 4] = [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (f32::NAN, 1.0)];

/// Jobs in the order of their steps. The jobs of a step are independent of each other; a job has the state of the one
/// at its place in the step before. Each is the words of the ports.
#[derive(Debug, Default)]
pub struct Jobs {
    pub ports: Vec<Port>,
    pub steps: Vec<Vec<Vec<u64>>>,
}

/// The values of all nodes that have an effect, in each step.
pub struct Values {
    steps: Vec<Vec<Column>>,
}

impl Dataflow {
    /// The values at the outputs, and the next ones of the states.
    pub fn ends(&self) -> Vec<NodeId> {
        let states = self.graph.states.iter().map(|state| state.next);
        self.graph.outputs.iter().map(|output| output.node).chain(states).collect()
    }

    /// Whether a value is a constant.
    pub fn is_constant(&self, id: NodeId) -> bool {
        matches!(self.graph.node(id).op, Op::Number(_) | Op::Ulps(_) | Op::Bit(_) | Op::Word(_))
    }

    /// Whether a value is a number that the operation computes.
    pub fn is_computed_number(&self, id: NodeId) -> bool {
        self.graph.is_computed(id) && self.graph.node(id).kind == Kind::Number
    }

    /// The nodes whose values can differ from those without the fault and have an effect.
    pub fn behind(&self, right: &Self) -> Vec<bool> {
        let (live, was_live) = (self.graph.live(), right.graph.live());
        let mut is_behind = vec![false; live.len()];
        loop {
            for (place, id) in self.graph.ids().enumerate() {
                let differs = self.graph.node(id).op != right.graph.node(id).op || !was_live[place];
                let reads = || self.graph.operands(id).iter().any(|operand| is_behind[operand.index()]);
                let is_it = live[place] && (differs || self.inverted == Some(id) || reads());
                is_behind[place] |= is_it;
            }
            let (states, before) = (&self.graph.states, &right.graph.states);
            let changed =
                |state: usize| states[state].next != before[state].next || is_behind[states[state].next.index()];
            let is_new = |id: &NodeId| {
                let is_changed = matches!(self.graph.node(*id).op, Op::State(state) if changed(state));
                is_changed && live[id.index()] && !is_behind[id.index()]
            };
            let new: Vec<NodeId> = self.graph.ids().filter(is_new).collect();
            if new.is_empty() {
                return is_behind;
            }
            new.into_iter().for_each(|read| is_behind[read.index()] = true);
        }
    }

    /// The values of a node for the jobs of a step. The state comes from the step before.
    fn column<'v>(
        &self,
        id: NodeId,
        jobs: &Jobs,
        step: usize,
        value: &dyn Fn(NodeId) -> &'v Column,
        before: &dyn Fn(NodeId) -> Option<&'v Column>,
    ) -> Column {
        let (node, inputs) = (self.graph.node(id), &jobs.steps[step]);
        let mut column: Column = match &node.op {
            Op::Input(PortBit { port, bit }) => {
                let place = jobs.ports.iter().position(|known| known.name == *port);
                let low = bit.map_or(0, |(bit, _)| bit);
                let mask = match node.kind {
                    Kind::Word(width) => u32::MAX >> (32 - width),
                    _ => u32::MAX,
                };
                inputs.iter().map(|job| place.map_or(0, |place| (job[place] >> low) as u32 & mask)).collect()
            }
            Op::State(state) => {
                before(self.graph.states[*state].next).cloned().unwrap_or_else(|| vec![0; inputs.len()])
            }
            op => {
                let operands: Vec<&Column> = self.graph.operands(id).into_iter().map(value).collect();
                let mut at = vec![0; operands.len()];
                let of_job = |job: usize| {
                    at.iter_mut().zip(&operands).for_each(|(at, operand)| *at = operand[job]);
                    computed(op, &at)
                };
                (0..inputs.len()).map(of_job).collect()
            }
        };
        if self.inverted == Some(id) {
            column.iter_mut().for_each(|bit| *bit ^= 1);
        }
        column
    }
}

/// The value of an operator for these operands.
fn computed(op: &Op, all: &[u32]) -> u32 {
    let c = Binary32;
    let number = |place: usize| Single(f32::from_bits(all[place]));
    let bits = |number: Single| number.0.to_bits();
    match *op {
        Op::Number(value) | Op::Word(value) => value,
        Op::Ulps(ulps) => bits(c.ulps(ulps)),
        Op::Bit(value) => value.into(),
        Op::Add(..) => bits(c.add(number(0), number(1))),
        Op::Subtract(..) => bits(c.subtract(number(0), number(1))),
        Op::Multiply(..) => bits(c.multiply(number(0), number(1))),
        Op::Sum(_) => bits(c.sum(&(0..all.len()).map(number).collect::<Vec<_>>())),
        Op::Residue(..) => c.residue(number(0), number(1), number(2)),
        Op::Negate(_) => all[0] ^ 1 << 31,
        Op::Narrow(_, to) => bits(c.narrow(number(0), to)),
        Op::NumberOf(_) => (all[0] as f32).to_bits(),
        Op::Compare(..) => {
            let order = number(0).0.partial_cmp(&number(1).0);
            order.map_or(3, |order| (order as i8 + 1) as u32)
        }
        Op::Relation(_, relation) => c.relation(ORDERS[all[0] as usize], relation).into(),
        Op::Test(test, _) => c.test(test, number(0)).into(),
        Op::And(..) => all[0] & all[1],
        Op::Or(..) | Op::WordOr(..) => all[0] | all[1],
        Op::Not(_) => all[0] ^ 1,
        Op::WordEqual(..) => (all[0] == all[1]).into(),
        Op::WordLess(..) => (all[0] < all[1]).into(),
        Op::Select(..) => all[if all[0] == 1 { 1 } else { 2 }],
        // What a fault passes on.
        Op::Continue(_) => all[0],
        // Inputs and states have no operands; the recorder makes no flags.
        Op::Input(_) | Op::State(_) | Op::Flags(_) => 0,
    }
}

impl Values {
    /// The values of a dataflow.
    pub fn of(flow: &Dataflow, jobs: &Jobs) -> Self {
        let live = flow.graph.live();
        let mut steps: Vec<Vec<Column>> = Vec::new();
        for step in 0..jobs.steps.len() {
            let mut values: Vec<Column> = Vec::with_capacity(live.len());
            for id in flow.graph.ids() {
                let column = match live[id.index()] {
                    true => flow.column(id, jobs, step, &|operand| &values[operand.index()], &|next| {
                        Some(&steps.last()?[next.index()])
                    }),
                    false => Column::new(),
                };
                values.push(column);
            }
            steps.push(values);
        }
        Self { steps }
    }

    /// The computed numbers that are NaN in no job.
    pub fn never_nan(&self, flow: &Dataflow) -> BTreeSet<NodeId> {
        let live = flow.graph.live();
        let is_nan = |bits: &u32| f32::from_bits(*bits).is_nan();
        let is_it = |id: &NodeId| {
            let is_live_number = live[id.index()] && flow.is_computed_number(*id);
            is_live_number && !self.steps.iter().flat_map(|step| &step[id.index()]).any(is_nan)
        };
        flow.graph.ids().filter(is_it).collect()
    }

    /// The word at a port out of a job; none if the operation lacks the port.
    pub fn word(&self, flow: &Dataflow, port: &str, [step, job]: [usize; 2]) -> Option<u64> {
        let bits = flow.graph.outputs.iter().filter(|output| output.port.port == port).map(|output| {
            let value = canonical(flow, output.node, self.steps[step][output.node.index()][job]);
            u64::from(value) << output.port.bit.map_or(0, |(bit, _)| bit)
        });
        bits.reduce(|a, b| a | b)
    }

    /// Whether a dataflow with a fault has another outcome for a job.
    pub fn differ(&self, right: &Dataflow, faulty: &Dataflow, jobs: &Jobs) -> bool {
        let is_behind = faulty.behind(right);
        let outputs: Vec<[NodeId; 2]> = right
            .graph
            .outputs
            .iter()
            .zip(&faulty.graph.outputs)
            .map(|(was, is)| [was.node, is.node])
            .filter(|[was, is]| was != is || is_behind[is.index()])
            .collect();
        let mut last: Vec<Column> = Vec::new();
        for (step, known) in self.steps.iter().enumerate() {
            let mut values = vec![Column::new(); is_behind.len()];
            for id in faulty.graph.ids().filter(|id| is_behind[id.index()]) {
                let value = |id: NodeId| if is_behind[id.index()] { &values[id.index()] } else { &known[id.index()] };
                let before = |next: NodeId| match (step.checked_sub(1), is_behind[next.index()]) {
                    (Some(_), true) => Some(&last[next.index()]),
                    (Some(before), false) => Some(&self.steps[before][next.index()]),
                    (None, _) => None,
                };
                values[id.index()] = faulty.column(id, jobs, step, &value, &before);
            }
            let differs = |&[was, is]: &[NodeId; 2]| {
                let found = if is_behind[is.index()] { &values[is.index()] } else { &known[is.index()] };
                let mut of_jobs = known[was.index()].iter().zip(found);
                of_jobs.any(|(&a, &b)| canonical(right, was, a) != canonical(faulty, is, b))
            };
            if outputs.iter().any(differs) {
                return true;
            }
            last = values;
        }
        false
    }
}

/// A NaN at a port is the canonical one.
fn canonical(flow: &Dataflow, id: NodeId, value: u32) -> u32 {
    match flow.graph.node(id).kind {
        Kind::Number if f32::from_bits(value).is_nan() => 0x7fc0_0000,
        _ => value,
    }
}
