//! Automatic staging: the stages of operations that mark none.
//!
//! A schedule comes from a list: what is most urgent first, each where units are free. That is done from the front, as
//! early as possible, and from the back, as late as possible. Both are then changed step by step, as long as a change
//! leaves fewer register bits; the better one is taken. `docs/extending/staging.md` says more.

mod cost;
mod improve;
mod list;
mod note;
mod problem;
mod settle;

use crate::STAGES;
use crate::budget::Budget;
use crate::config::Sharing;
use crate::error::Error;
use crate::graph::{NodeId, Op, Traced};
use cost::{Costs, Given, Load};
use problem::Problem;
use settle::Sides;

/// The last stage that operations may use: the one after it decodes.
const LAST: u32 = STAGES - 1;

/// That an operation can be staged automatically: it marks nothing itself, and its chains are short enough.
pub fn check(traced: &Traced) -> Result<(), Error> {
    if let Some(&(stage, _)) = traced.notes.first() {
        return Err(Error::StagesMixed { operation: traced.name, stage });
    }
    let problem = Problem::new(traced);
    let sides = Sides::new(&problem);
    let earliest = sides.earliest();
    let needed = earliest.iter().copied().max().unwrap_or(1);
    if needed > LAST {
        let chain = problem.longest_chain(&earliest);
        return Err(Error::TooLong { operation: traced.name, chain, needed, last: LAST });
    }
    Ok(())
}

/// What schedules are made for.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// The units that each operation may use. Without a budget, an operation uses those that others of the set have,
    /// and as few more as possible.
    pub budget: Option<Budget>,
    /// Bits of a number in a register.
    pub number_width: u32,
    /// Whether operations share registers.
    pub sharing: Sharing,
}

/// How often operations of a set are scheduled again because others have changed. Twice is enough where they fit well;
/// this bounds the time.
const ROUNDS: usize = 4;

/// Stages the operations that ask for it, adds exceptions where they are an output, and holds all against the budget.
pub fn assign(mut operations: Vec<Traced>, target: &Target) -> Result<Vec<Traced>, Error> {
    let mut is_staged: Vec<bool> = operations.iter().map(|traced| !traced.is_auto).collect();
    for _ in 0..ROUNDS {
        let mut has_changed = false;
        for number in 0..operations.len() {
            if operations[number].is_auto {
                let others = operations.iter().zip(&is_staged).enumerate();
                let others = others.filter(|&(other, (_, is_staged))| other != number && *is_staged);
                let others: Vec<&Traced> = others.map(|(_, (other, _))| other).collect();
                let stages = place(&operations[number], is_staged[number], &others, target);
                has_changed |= write(&mut operations[number], stages);
                is_staged[number] = true;
            }
        }
        if !has_changed {
            break;
        }
    }
    for traced in &mut operations {
        if traced.is_auto {
            traced.check()?;
            traced.notes = note::notes(traced);
        }
        if traced.counts_exceptions {
            traced.add_exception_flags()?;
        }
        if let Some(budget) = &target.budget {
            budget.check(traced)?;
        }
    }
    Ok(operations)
}

/// The stages of an operation's values beside those of others; what it has already is improved if it has any.
fn place(traced: &Traced, is_staged: bool, others: &[&Traced], target: &Target) -> Vec<u32> {
    let there = || others.iter().fold(Budget::NOTHING, |there, other| there.or(&Budget::used_by(other)));
    let given = Given {
        allowed: target.budget.unwrap_or_else(there),
        is_budget: target.budget.is_some(),
        others: match target.sharing {
            Sharing::Union => others.iter().fold(Load::default(), |load, other| load.or(&Load::of(other))),
            Sharing::Segregated => Load::default(),
        },
        number_width: target.number_width,
    };
    let problem = Problem::new(traced);
    let sides = Sides::new(&problem);
    let costs = Costs::new(&problem, &given);
    let Given { allowed, .. } = &given;
    let mut starts = vec![list::forwards(&problem, &sides, allowed), list::backwards(&problem, &sides, allowed)];
    if is_staged {
        starts.insert(0, problem.stages_of_groups());
    }
    let improved = starts.into_iter().map(|start| improve::improve(&problem, &sides, &costs, start));
    let best = improved.min_by_key(|stages| costs.of(stages)).unwrap_or_default();
    problem.stages_of_nodes(&best)
}

/// Writes stages into an operation's record, and whether that changes them.
fn write(traced: &mut Traced, stages: Vec<u32>) -> bool {
    let has_changed = traced.nodes.iter().map(|node| node.stage).ne(stages.iter().copied());
    for (node, stage) in traced.nodes.iter_mut().zip(stages) {
        node.stage = stage;
    }
    for state in 0..traced.states.len() {
        let stage = traced.node(traced.states[state].next).stage;
        (traced.states[state].written, traced.states[state].read) = (stage, stage);
    }
    has_changed
}

/// Whether a value is made of others in a stage; the rest is an input, a constant or state.
fn is_made(traced: &Traced, id: NodeId) -> bool {
    !matches!(traced.node(id).op, Op::Input(_)) && !traced.is_everywhere(id)
}
