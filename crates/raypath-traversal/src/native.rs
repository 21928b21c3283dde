//! A step in native binary32, with the stack of its ray.

use crate::state::{Answer, Group, RayState, Request};
use crate::step::{HalfStep, StepParameters, finish, prepare};
use raypath_ops::{Binary32, Bit, Flags, Word};

/// The stack of a ray: a unit uses the first entries.
pub(crate) type Stack = [Group<Binary32>; MAX_STACK];

/// The most entries that a stack can have.
pub(crate) const MAX_STACK: usize = 32;

/// A stack without children.
pub(crate) fn empty_stack() -> Stack {
    [Group::none(Binary32); MAX_STACK]
}

/// Evaluates an expression for each value of a bit, which is a constant in it. The compiler removes from each copy what
/// the other value needs.
macro_rules! for_each_value {
    ($bit:ident, $result:expr) => {
        if $bit.into() {
            let $bit = Bit::from(true);
            $result
        } else {
            let $bit = Bit::from(false);
            $result
        }
    };
}

/// Computes a step of a ray, and changes its state and its stack.
#[inline(always)]
pub(crate) fn step(
    parameters: StepParameters,
    state: &mut RayState<Binary32>,
    answer: Answer<Binary32>,
    stack: &mut Stack,
) -> Request<Binary32> {
    let node_limit = Word::truncate(parameters.node_limit);
    let (restarting, first_hit) = (state.restarting, answer.hit.0[0]);
    for_each_value!(restarting, {
        // If the ray is not on its way down again, it descends exactly if the first child is hit.
        for_each_value!(first_hit, {
            let Flags([_, second, third, fourth]) = answer.hit;
            let answer = Answer { hit: Flags([first_hit, second, third, fourth]), ..answer };
            let half = prepare(Binary32, parameters, RayState { restarting, ..*state }, answer, node_limit);
            end(parameters, state, half, stack)
        })
    })
}

#[inline(always)]
fn end(
    parameters: StepParameters,
    state: &mut RayState<Binary32>,
    half: HalfStep<Binary32>,
    stack: &mut Stack,
) -> Request<Binary32> {
    // The number of entries is a power of two.
    let slot = |level: Word<Binary32, 7>| (level.value & (parameters.stack - 1)) as usize % MAX_STACK;
    let (next, request) = finish(Binary32, parameters, half, stack[slot(half.deepest)]);
    *state = next;
    if request.writes.into() {
        stack[slot(request.level)] = request.group;
    }
    request
}
