//! The cost of a schedule.

use super::budget::{Budget, KINDS};
use super::problem::{Class, Problem, class};
use crate::ir::graph::{Kind, NodeId, Op, OperationGraph};
use crate::ir::liveness;
use crate::ir::position::{STAGES, Stage};
use crate::ir::units::{UnitKind, Units};

/// The cost of a schedule. Lower is better; earlier fields take precedence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cost {
    /// The number of units beyond the budget in all stages, and the number of limits exceeded.
    over_budget: (usize, usize),
    /// The number of stages between the first state and the last: a job waits so long for the previous one.
    state_span: u32,
    /// Without a budget: the number of units beyond those of the other operations.
    new_units: usize,
    /// Bits in the registers shared with the other operations, over all boundaries.
    shared: u64,
    /// Bits in the registers of this operation alone, over all boundaries.
    bits: u64,
    /// The number of dependences between a unit and another unit or logic in the same stage.
    chained: usize,
}

/// The registers that an operation needs at each boundary.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RegisterLoad {
    numbers: [u64; BOUNDARIES],
    /// Bits of small words.
    flags: [u64; BOUNDARIES],
}

/// The boundary after each stage, and that of the input's registers.
const BOUNDARIES: usize = STAGES as usize + 1;

/// The constraints and the context of a schedule.
pub struct Constraints {
    /// The units that the operation may use.
    pub allowed: Budget,
    /// Whether more units are an error.
    pub is_budget: bool,
    /// The registers of the other operations.
    pub others: RegisterLoad,
    /// Bits of a number in a register.
    pub number_width: u32,
}

/// The data for computing the cost of a schedule.
pub struct Costs<'a> {
    constraints: &'a Constraints,
    values: Vec<Value>,
    /// The kind of each unit, and its group.
    units: Vec<(UnitKind, usize)>,
    /// Pairs of dependent groups, at least one of which has a unit.
    dependences: Vec<(usize, usize)>,
    /// The groups of states.
    states: Vec<usize>,
}

/// A value with its live range.
struct Value {
    /// Bits of a word; `None` for a number.
    width: Option<u32>,
    /// The group that computes it; `None` for an input.
    made: Option<usize>,
    readers: Vec<usize>,
    is_output: bool,
    /// Its movable tests: the groups that read each, and whether it is an output.
    tests: Vec<(Vec<usize>, bool)>,
}

impl<'a> Costs<'a> {
    pub fn new(problem: &Problem<'_>, constraints: &'a Constraints) -> Self {
        let graph = problem.graph;
        let group = |id: NodeId| problem.group_of[id.index()];
        let mut readers: Vec<Vec<usize>> = vec![Vec::new(); graph.nodes.len()];
        let (mut units, mut dependences) = (Vec::new(), Vec::new());
        for (number, &id) in problem.groups.iter().enumerate().flat_map(|(g, ids)| ids.iter().map(move |id| (g, id))) {
            graph.operands(id).into_iter().for_each(|operand| readers[operand.index()].push(number));
            units.extend(graph.unit_part(id).map(|(kind, _)| (kind, number)));
            let near = problem.placed_operands(id).into_iter();
            let near = near.filter(|&o| class(graph, o) != Class::Logic || class(graph, id) != Class::Logic);
            dependences.extend(near.filter_map(group).filter(|&other| other != number).map(|other| (other, number)));
        }
        for state in &graph.states {
            readers[state.next.index()].extend(group(state.next));
        }
        let is_output = |id: NodeId| graph.outputs.iter().any(|output| output.node == id);
        let is_test = |id: NodeId| graph.is_movable(id);
        let tests = |of: NodeId| {
            let tests =
                graph.ids().filter(move |&id| matches!(graph.node(id).op, Op::Test(_, operand) if operand == of));
            let tests = tests.filter(|&id| is_test(id));
            tests.map(|id| (readers[id.index()].clone(), is_output(id))).collect::<Vec<_>>()
        };
        let values = graph
            .ids()
            .filter(|&id| !graph.is_everywhere(id) && !is_test(id))
            .map(|id| Value {
                width: match graph.node(id).kind {
                    Kind::Word(width) => Some(width),
                    Kind::Number | Kind::Order | Kind::Cut(..) => None,
                },
                made: group(id),
                readers: readers[id.index()].clone(),
                is_output: is_output(id),
                tests: tests(id),
            })
            .collect();
        Self { constraints, values, units, dependences, states: problem.states.iter().flatten().copied().collect() }
    }

    /// The cost of a schedule, given as the stage of each group.
    pub fn of(&self, stages: &[u32]) -> Cost {
        let mut used = [Units::default(); STAGES as usize + 1];
        for &(kind, group) in &self.units {
            *used[stages[group] as usize].of_mut(kind) += 1;
        }
        let over = used.iter().enumerate().flat_map(|(stage, used)| {
            let allowed = self.constraints.allowed.units(stage as u32);
            KINDS.map(|kind| used.of(kind).saturating_sub(allowed.of(kind)))
        });
        let excess = (over.clone().sum(), over.filter(|&over| over > 0).count());
        let states = self.states.iter().map(|&group| stages[group]);
        let (first, last) = (states.clone().min(), states.max());
        let number_width = self.constraints.number_width.into();
        let mut load = RegisterLoad::default();
        self.values.iter().for_each(|value| value.add_to(stages, &mut load));
        Cost {
            over_budget: if self.constraints.is_budget { excess } else { (0, 0) },
            state_span: last.unwrap_or(0).saturating_sub(first.unwrap_or(0)),
            new_units: if self.constraints.is_budget { 0 } else { excess.0 },
            shared: load.clone().or(&self.constraints.others).bits(number_width),
            bits: load.bits(number_width),
            chained: self.dependences.iter().filter(|&&(a, b)| stages[a] == stages[b]).count(),
        }
    }
}

impl RegisterLoad {
    /// The registers that an operation needs. Its stages must be assigned.
    pub fn of(graph: &OperationGraph<Stage>) -> Self {
        let mut load = Self::default();
        for (boundary, values) in liveness::analyse(graph, STAGES).iter().enumerate() {
            for &id in &values.carried {
                match graph.node(id).kind {
                    Kind::Word(width) => load.flags[boundary] += u64::from(width),
                    Kind::Number | Kind::Order | Kind::Cut(..) => load.numbers[boundary] += 1,
                }
            }
        }
        load
    }

    /// The greater need of both at each boundary, because a register holds one operation's value at a time.
    pub fn or(mut self, other: &Self) -> Self {
        for boundary in 0..BOUNDARIES {
            self.numbers[boundary] = self.numbers[boundary].max(other.numbers[boundary]);
            self.flags[boundary] = self.flags[boundary].max(other.flags[boundary]);
        }
        self
    }

    fn bits(&self, number_width: u64) -> u64 {
        self.numbers.iter().sum::<u64>() * number_width + self.flags.iter().sum::<u64>()
    }
}

impl Value {
    /// Adds the value to the registers: the value itself until its last reader, then each of its tests until the test's
    /// last reader.
    fn add_to(&self, stages: &[u32], load: &mut RegisterLoad) {
        let last = |readers: &[usize], is_output: bool| {
            let read = readers.iter().map(|&group| stages[group]).max();
            if is_output { Some(STAGES + 1) } else { read }
        };
        let own = last(&self.readers, self.is_output);
        let tested = self.tests.iter().filter_map(|(readers, is_output)| last(readers, *is_output));
        let Some(all) = own.max(tested.clone().max()) else { return };
        let made = self.made.map_or(0, |group| stages[group]);
        // A test of an input is computed in stage 1 at the earliest.
        let end = own.unwrap_or(0).max(made).max(all.min(1));
        let boundaries = made as usize..end as usize;
        match self.width {
            Some(width) => load.flags[boundaries].iter_mut().for_each(|bits| *bits += u64::from(width)),
            None => load.numbers[boundaries].iter_mut().for_each(|count| *count += 1),
        }
        for last in tested.filter(|&last| last > end) {
            load.flags[end as usize..last as usize].iter_mut().for_each(|bits| *bits += 1);
        }
    }
}
