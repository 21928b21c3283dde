//! The functional model of the unit: a ray goes in, its hit comes out, without time.

use crate::blocks::{BLOCK_BYTES, LeafTriangle, Node};
use crate::state::{Answer, Group, RayState, Request, answer, request, status};
use crate::step::{StepParameters, step};
use raypath_model::SimdKernels;
use raypath_ops::{
    Binary32, Culling, Flags, Operation, Ray, RayBox, RayBoxInput, RayTriangleExtended, RayTriangleExtendedInput,
    Rules, Word,
};
use thiserror::Error;

/// The memory that a unit reads.
pub trait Memory {
    /// The block of 128 bytes at an address, a multiple of 128.
    ///
    /// # Errors
    /// There is no block at the address.
    fn block(&self, address: u32) -> Result<&[u8; BLOCK_BYTES as usize], MemoryError>;
}

/// The error of an address without a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("there is no block at address {0:#x}")]
pub struct MemoryError(pub u32);

impl Memory for [u8] {
    fn block(&self, address: u32) -> Result<&[u8; BLOCK_BYTES as usize], MemoryError> {
        let block = self.get(address as usize..).and_then(<[u8]>::first_chunk);
        block.filter(|_| address.is_multiple_of(BLOCK_BYTES)).ok_or(MemoryError(address))
    }
}

/// A ray as the unit takes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayRequest {
    /// The point at which the ray begins.
    pub origin: [f32; 3],
    /// The direction, of any length that can be inverted.
    pub direction: [f32; 3],
    /// The least distance of a hit, in units of the direction's length.
    pub t_min: f32,
    /// The greatest distance of a hit; infinity reaches everything.
    pub t_max: f32,
    /// The ray ends at the first block of triangles with a hit.
    pub any_hit: bool,
    /// Back faces are not hit.
    pub cull_back: bool,
    /// Front faces are not hit.
    pub cull_front: bool,
    /// The child word of the scene's root.
    pub root: u32,
}

/// The hit of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The index of the triangle.
    pub triangle: u32,
    /// The distance `t_num / t_denom`, in units of the direction's length.
    pub t: f32,
    /// The numerator of the distance.
    pub t_num: f32,
    /// The denominator of the distance; negative for a back face.
    pub t_denom: f32,
    /// The ray meets the back face.
    pub back_face: bool,
}

/// What the unit returns for a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reply {
    /// One of [`status`].
    pub status: u32,
    /// The hit: the closest, of several at the same distance that of the lowest index; with `any_hit` the closest of
    /// the first block with a hit. After an error, that of the triangles so far.
    pub hit: Option<Hit>,
    /// The nodes that were fetched.
    pub nodes: u32,
    /// The triangles that were fetched.
    pub triangles: u32,
}

/// The functional model of the unit.
#[derive(Debug, Clone)]
pub struct Unit {
    parameters: StepParameters,
    boxes: RayBox,
    triangles: RayTriangleExtended,
    stack: Vec<Group<Binary32>>,
}

impl Unit {
    /// A unit with these rules for special cases.
    pub fn new(rules: Rules, parameters: StepParameters) -> Self {
        let options = (Culling::None, true, false, false);
        let (culling, facing, barycentrics, range) = options;
        Self {
            parameters,
            boxes: RayBox { rules },
            triangles: RayTriangleExtended { rules, culling, facing, barycentrics, range },
            stack: vec![Group::none(Binary32); parameters.stack as usize],
        }
    }

    /// Traces a ray.
    pub fn trace(&mut self, memory: &(impl Memory + ?Sized), ray: &RayRequest) -> Reply {
        let constants = match Ray::new(ray.origin, ray.direction, ray.t_max) {
            Ok(constants) if ray.t_min >= 0.0 => constants,
            _ => return Reply { status: status::REFUSED, hit: None, nodes: 0, triangles: 0 },
        };
        let (root, t_min) = (Word::truncate(ray.root), ray.t_min.into());
        let state = RayState::begin(Binary32, root, t_min, constants.extent, ray.any_hit.into());
        let mut walk = Walk { unit: self, ray, constants, state };
        let (mut state, mut asked) = walk.step(answer::START, |_| {});
        while asked.kind.value != request::DONE {
            (state, asked) = match asked.kind.value {
                request::FETCH => match memory.block(asked.address.value) {
                    Ok(block) if asked.count.value == 0 => walk.node(block),
                    Ok(block) => walk.leaf(block, asked.count.value),
                    Err(_) => walk.step(answer::ERROR, |_| {}),
                },
                _ => walk.step(answer::CONTINUE, |_| {}),
            };
        }
        let hit = bool::from(state.has_hit).then(|| Hit {
            triangle: state.triangle.value,
            t: state.extent.into(),
            t_num: state.t_num.into(),
            t_denom: state.t_denom.into(),
            back_face: state.back_face.into(),
        });
        Reply { status: asked.status.value, hit, nodes: state.nodes.value, triangles: state.triangles.value }
    }
}

/// A ray on its way.
struct Walk<'u> {
    unit: &'u mut Unit,
    ray: &'u RayRequest,
    constants: Ray<Binary32>,
    state: RayState<Binary32>,
}

impl Walk<'_> {
    /// A step with an answer of this kind, which `fill` completes.
    fn step(&mut self, kind: u32, fill: impl FnOnce(&mut Answer<Binary32>)) -> (RayState<Binary32>, Request<Binary32>) {
        let slot = |level: u32| (level % self.unit.parameters.stack) as usize;
        let mut answer = nothing(kind, self.unit.stack[slot(self.state.pending.deepest().value)]);
        fill(&mut answer);
        let (state, request) = step(Binary32, self.unit.parameters, self.state, answer);
        if request.writes.into() {
            self.unit.stack[slot(request.level.value)] = request.group;
        }
        self.state = state;
        (state, request)
    }

    fn node(&mut self, block: &[u8; BLOCK_BYTES as usize]) -> (RayState<Binary32>, Request<Binary32>) {
        let Node { boxes, children } = Node::of(block);
        let ray = Ray { extent: self.state.extent, ..self.constants };
        let (outcome, ()) = self.unit.boxes.run_with(Binary32, SimdKernels, RayBoxInput { ray, aabb: boxes }, ());
        self.step(answer::BOXES, |answer| {
            answer.hit = outcome.is_intersect;
            answer.tmin = [outcome.tmin[1], outcome.tmin[2], outcome.tmin[3]];
            answer.child = outcome.box_index.map(|index| Word::truncate(children[index.value as usize & 3]));
        })
    }

    fn leaf(&mut self, block: &[u8; BLOCK_BYTES as usize], count: u32) -> (RayState<Binary32>, Request<Binary32>) {
        for place in 0..count - 1 {
            self.triangle(block, place, false);
        }
        self.triangle(block, count - 1, true)
    }

    fn triangle(
        &mut self,
        block: &[u8; BLOCK_BYTES as usize],
        place: u32,
        is_last: bool,
    ) -> (RayState<Binary32>, Request<Binary32>) {
        let LeafTriangle { triangle, index } = LeafTriangle::of(block, place as usize);
        let input = RayTriangleExtendedInput { ray: self.constants, triangle, t_min: self.state.t_min };
        let (outcome, ()) = self.unit.triangles.run(Binary32, input, ());
        let back = !bool::from(outcome.facing);
        let is_culled = if back { self.ray.cull_back } else { self.ray.cull_front };
        let quotient = f32::from(outcome.t_num) / f32::from(outcome.t_denom);
        self.step(answer::TRIANGLE, |answer| {
            answer.triangle_hit = (bool::from(outcome.triangle_hit) && !is_culled).into();
            answer.t = quotient.into();
            (answer.t_num, answer.t_denom) = (outcome.t_num, outcome.t_denom);
            answer.back_face = back.into();
            answer.triangle = Word::truncate(index);
            answer.is_last = is_last.into();
        })
    }
}

fn nothing(kind: u32, top: Group<Binary32>) -> Answer<Binary32> {
    let (no, zero, none) = (false.into(), 0.0.into(), Word::truncate(0));
    Answer {
        kind: Word::truncate(kind),
        hit: Flags([no; 4]),
        tmin: [zero; 3],
        child: [none; 4],
        triangle_hit: no,
        t: zero,
        t_num: zero,
        t_denom: zero,
        back_face: no,
        triangle: none,
        is_last: no,
        top,
    }
}
