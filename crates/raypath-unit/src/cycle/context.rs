//! What is kept of a ray, and its jobs.

use crate::answers::{Answers, Block, ReadyRay};
use crate::blocks::BLOCK_BYTES;
use crate::fold::HitLimits;
use crate::instance::TRANSFORM_OPCODE;
use crate::model::RayRequest;
use crate::native::{Stack, empty_stack};
use crate::set_up::Entry;
use crate::state::{RayState, status};
use crate::step::StepParameters;
use raypath_ops::{Binary32, JobKind, Rules, Word};

/// What is kept of a ray.
#[derive(Debug, Clone)]
pub struct Context {
    pub id: u64,
    pub ready: ReadyRay,
    /// In the space of the instance that it entered last.
    pub inside: ReadyRay,
    pub limits: HitLimits<Binary32>,
    pub state: RayState<Binary32>,
    pub stack: Stack,
    pub block: Block,
    /// The address of the block that was requested last.
    pub address: u32,
    /// Its triangles; 0 for a node, 2 for an instance.
    pub count: u32,
    /// It is an instance's.
    pub is_instance: bool,
    /// Its beats so far, and whether one had an error.
    pub beats: usize,
    pub failed: bool,
    /// How the ray ended.
    pub status: u32,
}

/// A job of a context.
#[derive(Debug, Clone, Copy, Default)]
pub struct Job {
    pub context: u8,
    pub kind: Kind,
}

/// The kinds of jobs. An instance has a job for the ray's origin and one for its direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Kind {
    #[default]
    Node,
    Triangle,
    LastTriangle,
    Origin,
    Direction,
}

impl Kind {
    /// The opcode in the datapath.
    #[inline]
    pub fn opcode(self) -> u64 {
        match self {
            Self::Node => JobKind::Quadbox.opcode(),
            Self::Triangle | Self::LastTriangle => JobKind::Triangle.opcode(),
            Self::Origin | Self::Direction => TRANSFORM_OPCODE,
        }
    }
}

impl Context {
    /// The constants of its ray where it is.
    #[inline(always)]
    pub fn space(&self) -> &ReadyRay {
        if self.state.inside.into() { &self.inside } else { &self.ready }
    }

    /// A context without a ray.
    pub fn new() -> Self {
        let zero = [0.0; 3];
        let ray = RayRequest {
            origin: zero,
            direction: zero,
            t_min: 0.0,
            t_max: 0.0,
            any_hit: false,
            cull_back: false,
            cull_front: false,
            root: 0,
        };
        let ready = Answers::new(Rules::Paper, StepParameters::default()).set_up(&Entry::from(&ray));
        Self {
            id: 0,
            ready,
            inside: ready,
            limits: ray.limits(),
            state: RayState::begin(Binary32, Word::truncate(0), 0.0.into(), false.into()),
            stack: empty_stack(),
            block: [0; BLOCK_BYTES as usize],
            address: 0,
            count: 0,
            is_instance: false,
            beats: 0,
            failed: false,
            status: status::MISS,
        }
    }
}
