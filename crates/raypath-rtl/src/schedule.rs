//! Automatic staging: assigns stages to the values of operations that mark none.
//!
//! List scheduling builds two schedules: forwards with every value as early as possible, and backwards with every value
//! as late as possible. Local changes then improve both while they reduce the cost, which is mainly register bits. The
//! cheaper schedule is used. `docs/extending/staging.md` describes the method.

mod budget;
mod cost;
mod improve;
mod list;
mod note;
mod problem;
mod settle;
mod steps;

pub use budget::Budget;
pub use steps::expand;

use crate::config::Sharing;
use crate::error::Error;
use crate::ir::graph::{Op, OperationGraph};
use crate::ir::position::{LAST_STAGE, Stage};
use cost::{Constraints, Costs, RegisterLoad};
use problem::Problem;
use settle::Directions;

/// Checks that an operation can be staged automatically: it marks no stages itself, and its chains of units are short
/// enough.
pub fn check(graph: &OperationGraph<Stage>) -> Result<(), Error> {
    if let Some(&(stage, _)) = graph.notes.first() {
        return Err(Error::StagesMixed { operation: graph.name, stage });
    }
    if graph.nodes.iter().any(|node| matches!(node.op, Op::Sum(_))) {
        let problem =
            format!("sum is not available in {}, which is staged automatically; expected marked stages", graph.name);
        return Err(Error::Feature { feature: "rounding", problem });
    }
    let problem = Problem::new(graph);
    let directions = Directions::new(&problem);
    let earliest = directions.earliest();
    let needed = earliest.iter().copied().max().unwrap_or(1);
    if needed > LAST_STAGE {
        let chain = problem.longest_chain(&earliest);
        return Err(Error::TooLong { operation: graph.name, chain, needed, last: LAST_STAGE });
    }
    Ok(())
}

/// What schedules are optimised for.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// The units that each operation may use. Without a budget, an operation uses the units of the other operations and
    /// as few more as possible.
    pub budget: Option<Budget>,
    /// Bits of a number in a register.
    pub number_width: u32,
    /// Whether operations share registers.
    pub sharing: Sharing,
}

/// How often the operations of a set are scheduled again after others have changed. Two rounds are usually enough; the
/// limit bounds the time.
const ROUNDS: usize = 4;

/// Stages the operations with automatic staging, adds exception flags where they are an output, and checks the budget.
pub fn assign(
    mut operations: Vec<OperationGraph<Stage>>,
    target: &Target,
) -> Result<Vec<OperationGraph<Stage>>, Error> {
    let mut is_staged: Vec<bool> = operations.iter().map(|graph| !graph.is_auto).collect();
    for _ in 0..ROUNDS {
        let mut has_changed = false;
        for number in 0..operations.len() {
            if operations[number].is_auto {
                let others = operations.iter().zip(&is_staged).enumerate();
                let others = others.filter(|&(other, (_, is_staged))| other != number && *is_staged);
                let others: Vec<_> = others.map(|(_, (other, _))| other).collect();
                let stages = schedule(&operations[number], is_staged[number], &others, target);
                has_changed |= apply(&mut operations[number], stages);
                is_staged[number] = true;
            }
        }
        if !has_changed {
            break;
        }
    }
    for graph in &mut operations {
        if graph.is_auto {
            graph.check()?;
            graph.notes = note::notes(graph);
        }
        if graph.counts_exceptions {
            graph.add_exception_flags()?;
        }
        if let Some(budget) = &target.budget {
            budget.check(graph)?;
        }
    }
    Ok(operations)
}

/// The stages of an operation's values, given the other operations. An existing schedule is improved.
fn schedule(
    graph: &OperationGraph<Stage>,
    is_staged: bool,
    others: &[&OperationGraph<Stage>],
    target: &Target,
) -> Vec<Stage> {
    let existing = || others.iter().fold(Budget::NOTHING, |units, other| units.or(&Budget::used_by(other)));
    let load = || others.iter().fold(RegisterLoad::default(), |load, other| load.or(&RegisterLoad::of(other)));
    let constraints = Constraints {
        allowed: target.budget.unwrap_or_else(existing),
        is_budget: target.budget.is_some(),
        others: match target.sharing {
            Sharing::Union => load(),
            Sharing::Segregated => RegisterLoad::default(),
        },
        number_width: target.number_width,
    };
    let problem = Problem::new(graph);
    let directions = Directions::new(&problem);
    let costs = Costs::new(&problem, &constraints);
    let Constraints { allowed, .. } = &constraints;
    let mut starts =
        vec![list::forwards(&problem, &directions, allowed), list::backwards(&problem, &directions, allowed)];
    if is_staged {
        starts.insert(0, problem.stages_of_groups());
    }
    let improved = starts.into_iter().map(|start| improve::improve(&problem, &directions, &costs, start));
    let best = improved.min_by_key(|stages| costs.of(stages)).unwrap_or_default();
    problem.stages_of_nodes(&best)
}

/// Applies a schedule to a graph. Returns whether the schedule differs from the present one.
fn apply(graph: &mut OperationGraph<Stage>, stages: Vec<Stage>) -> bool {
    let has_changed = graph.nodes.iter().map(|node| node.position).ne(stages.iter().copied());
    for (node, stage) in graph.nodes.iter_mut().zip(stages) {
        node.position = stage;
    }
    for state in 0..graph.states.len() {
        let stage = graph.node(graph.states[state].next).position;
        (graph.states[state].written, graph.states[state].read) = (stage, stage);
    }
    has_changed
}
