//! What a schedule costs.

use super::problem::{Part, Problem, part};
use crate::STAGES;
use crate::budget::{Budget, KINDS};
use crate::graph::{Kind, NodeId, Op, Traced};
use crate::liveness;
use crate::units::{UnitKind, Units, part as unit};

/// Less is better, the first thing first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cost {
    /// Units beyond a budget, over all stages, and how often it has to be widened.
    over_budget: (usize, usize),
    /// Stages between the first state and the last: a job must wait so long for the one before it.
    apart: u32,
    /// Where there is no budget, units beyond those that others have.
    new_units: usize,
    /// Bits in the registers that it shares with the others of its set, over all boundaries.
    shared: u64,
    /// Bits in registers of its own, over all boundaries.
    bits: u64,
    /// How often what a unit makes or takes has logic or another unit beside it in its stage.
    strung: usize,
}

/// What an operation has in registers at each boundary.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Load {
    numbers: [u64; BOUNDARIES],
    /// Bits of small words.
    flags: [u64; BOUNDARIES],
}

/// One after each stage, and the input's.
const BOUNDARIES: usize = STAGES as usize + 1;

/// What a schedule has to live with.
pub struct Given {
    /// The units that it may use.
    pub allowed: Budget,
    /// Whether more of them are an error.
    pub is_budget: bool,
    /// What others of the set have in the same registers.
    pub others: Load,
    /// Bits of a number in a register.
    pub number_width: u32,
}

/// Everything that the cost of a schedule is computed from.
pub struct Costs<'a> {
    given: &'a Given,
    values: Vec<Value>,
    /// Units and their groups.
    units: Vec<(UnitKind, usize)>,
    /// Groups that are one unit's neighbours.
    strings: Vec<(usize, usize)>,
    /// The groups of states.
    states: Vec<usize>,
}

/// A value, and what liveness asks of it.
struct Value {
    /// Bits of a small word; none for a number.
    width: Option<u32>,
    /// Who makes it; none for an input.
    made: Option<usize>,
    readers: Vec<usize>,
    is_output: bool,
    /// Tests of it that float: who reads them, and whether they are outputs.
    tests: Vec<(Vec<usize>, bool)>,
}

impl<'a> Costs<'a> {
    pub fn new(problem: &Problem<'_>, given: &'a Given) -> Self {
        let traced = problem.traced;
        let group = |id: NodeId| problem.group_of[id.index()];
        let mut readers: Vec<Vec<usize>> = vec![Vec::new(); traced.nodes.len()];
        let (mut units, mut strings) = (Vec::new(), Vec::new());
        for (number, &id) in problem.groups.iter().enumerate().flat_map(|(g, ids)| ids.iter().map(move |id| (g, id))) {
            traced.operands(id).into_iter().for_each(|operand| readers[operand.index()].push(number));
            units.extend(unit(traced, id).map(|(kind, _)| (kind, number)));
            let beside = problem.made_of(id).into_iter();
            let beside = beside.filter(|&o| part(traced, o) != Part::Logic || part(traced, id) != Part::Logic);
            strings.extend(beside.filter_map(group).filter(|&other| other != number).map(|other| (other, number)));
        }
        for state in &traced.states {
            readers[state.next.index()].extend(group(state.next));
        }
        let is_output = |id: NodeId| traced.outputs.iter().any(|output| output.node == id);
        let is_test = |id: NodeId| traced.floats(id);
        let tests = |of: NodeId| {
            let tests =
                traced.ids().filter(move |&id| matches!(traced.node(id).op, Op::Test(_, operand) if operand == of));
            let tests = tests.filter(|&id| is_test(id));
            tests.map(|id| (readers[id.index()].clone(), is_output(id))).collect::<Vec<_>>()
        };
        let values = traced
            .ids()
            .filter(|&id| !traced.is_everywhere(id) && !is_test(id))
            .map(|id| Value {
                width: match traced.node(id).kind {
                    Kind::Word(width) => Some(width),
                    Kind::Number | Kind::Order | Kind::Cut(..) => None,
                },
                made: group(id),
                readers: readers[id.index()].clone(),
                is_output: is_output(id),
                tests: tests(id),
            })
            .collect();
        Self { given, values, units, strings, states: problem.states.iter().flatten().copied().collect() }
    }

    /// The cost of a schedule, by the stage of each group.
    pub fn of(&self, stages: &[u32]) -> Cost {
        let mut used = [Units::default(); STAGES as usize + 1];
        for &(kind, group) in &self.units {
            *used[stages[group] as usize].of_mut(kind) += 1;
        }
        let over = used.iter().enumerate().flat_map(|(stage, used)| {
            let allowed = self.given.allowed.units(stage as u32);
            KINDS.map(|kind| used.of(kind).saturating_sub(allowed.of(kind)))
        });
        let excess = (over.clone().sum(), over.filter(|&over| over > 0).count());
        let states = self.states.iter().map(|&group| stages[group]);
        let (first, last) = (states.clone().min(), states.max());
        let number_width = self.given.number_width.into();
        let mut load = Load::default();
        self.values.iter().for_each(|value| value.put(stages, &mut load));
        Cost {
            over_budget: if self.given.is_budget { excess } else { (0, 0) },
            apart: last.unwrap_or(0).saturating_sub(first.unwrap_or(0)),
            new_units: if self.given.is_budget { 0 } else { excess.0 },
            shared: load.clone().or(&self.given.others).bits(number_width),
            bits: load.bits(number_width),
            strung: self.strings.iter().filter(|&&(a, b)| stages[a] == stages[b]).count(),
        }
    }
}

impl Load {
    /// What an operation has whose stages are known.
    pub fn of(traced: &Traced) -> Self {
        let mut load = Self::default();
        for (boundary, work) in liveness::work(traced, STAGES).iter().enumerate() {
            for &id in &work.carried {
                match traced.node(id).kind {
                    Kind::Word(width) => load.flags[boundary] += u64::from(width),
                    Kind::Number | Kind::Order | Kind::Cut(..) => load.numbers[boundary] += 1,
                }
            }
        }
        load
    }

    /// Boundary by boundary, whichever is more: a register holds one operation's value at a time.
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
    /// Puts it into the registers: itself until its last reader, then each test of it until that one's.
    fn put(&self, stages: &[u32], load: &mut Load) {
        let last = |readers: &[usize], is_output: bool| {
            let read = readers.iter().map(|&group| stages[group]).max();
            if is_output { Some(STAGES + 1) } else { read }
        };
        let own = last(&self.readers, self.is_output);
        let tested = self.tests.iter().filter_map(|(readers, is_output)| last(readers, *is_output));
        let Some(all) = own.max(tested.clone().max()) else { return };
        let made = self.made.map_or(0, |group| stages[group]);
        // A test of an input is made in stage 1 at the earliest.
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
