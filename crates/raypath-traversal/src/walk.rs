//! A ray on its way through a scene, without time.

use crate::answers::{Answers, ReadyRay};
use crate::blocks::NodeKind;
use crate::fold::HitLimits;
use crate::model::{Memory, RayRequest, Reply};
use crate::native::{self, Stack, empty_stack};
use crate::query::Culls;
use crate::set_up::Entry;
use crate::state::{Answer, RayState, Request, request, status};
use crate::step::{StepParameters, UnitFeatures};
use raypath_model::{State, StateWords, state};
use raypath_ops::{Binary32, Vec3};

/// A ray on its way through a scene.
#[derive(Debug, Clone)]
pub(crate) struct Walk {
    outside: ReadyRay,
    /// In the space of the instance that it entered last.
    inside: ReadyRay,
    limits: HitLimits<Binary32>,
    state: RayState<Binary32>,
    stack: Stack,
    asked: Asked,
    status: u32,
}

/// What a ray asks for after a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Asked {
    pub kind: AskedKind,
    /// Of a block: the number of its triangles; 0 for a node, 2 for an instance.
    pub count: u8,
    /// Of a block: it is an instance's.
    pub is_instance: bool,
    /// The ray descends again from the root.
    pub restarts: bool,
    /// The address of a block.
    pub address: u32,
}

/// The kinds of [`Asked`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AskedKind {
    /// A block.
    Block,
    /// Another step.
    Again,
    /// Nothing: the ray has ended.
    Nothing,
    /// To begin.
    Begin,
}

impl Walk {
    /// A ray that has ended.
    pub fn new(answers: &Answers) -> Self {
        let (zero, no) = (0.0.into(), false.into());
        let origin = Vec3 { x: zero, y: zero, z: zero };
        let ready = answers.set_up(&Entry { origin, dir: origin, t_min: zero, t_max: zero });
        Self {
            outside: ready,
            inside: ready,
            limits: HitLimits { t_min: zero, culls: Culls { clockwise: no, counter_clockwise: no } },
            state: RayState::begin(Binary32, RayRequest::NONE.words()),
            stack: empty_stack(),
            asked: Asked::NOTHING,
            status: status::MISS,
        }
    }

    /// A ray begins.
    pub fn begin(&mut self, answers: &Answers, parameters: StepParameters, ray: &RayRequest) {
        self.outside = answers.ready(ray);
        self.limits = ray.limits(parameters);
        self.state = RayState::begin(Binary32, ray.words());
        self.asked = Asked { kind: AskedKind::Begin, ..Asked::NOTHING };
    }

    /// The next step of a ray that has not ended. Returns what it asks for.
    #[inline]
    pub fn step(&mut self, answers: &Answers, parameters: StepParameters, memory: &(impl Memory + ?Sized)) -> Asked {
        const USUAL: (NodeKind, UnitFeatures) = (NodeKind::Wide4, UnitFeatures::OFF);
        // The usual parameters have a copy of the step in which they are constants.
        if (parameters.node, parameters.features) == USUAL {
            self.step_with(answers, StepParameters { node: USUAL.0, features: USUAL.1, ..parameters }, memory)
        } else {
            self.step_with(answers, parameters, memory)
        }
    }

    #[inline(always)]
    fn step_with(&mut self, answers: &Answers, parameters: StepParameters, memory: &(impl Memory + ?Sized)) -> Asked {
        let block = self.asked;
        match block.kind {
            AskedKind::Block => {}
            AskedKind::Begin => return self.advance(parameters, Answers::begin(&self.outside)),
            AskedKind::Again | AskedKind::Nothing => return self.advance(parameters, Answers::again()),
        }
        let ready = if self.state.inside.into() { &self.inside } else { &self.outside };
        // Each kind of answer has a copy of the step, from which the compiler removes what other answers need.
        match memory.block(block.address, parameters.node.block_bytes()) {
            Ok(bytes) if block.is_instance => {
                self.inside = answers.instance(&self.outside, bytes);
                self.advance(parameters, Answers::enter(&self.inside, bytes))
            }
            Ok(bytes) if block.count == 0 => {
                self.advance(parameters, answers.node(parameters.node, ready, self.state.extent, bytes))
            }
            Ok(bytes) => {
                self.advance(parameters, answers.leaf(parameters.node, ready, self.limits, bytes, block.count.into()))
            }
            Err(_) => self.advance(parameters, Answers::failure()),
        }
    }

    #[inline(always)]
    fn advance(&mut self, parameters: StepParameters, answer: Answer<Binary32>) -> Asked {
        let was_restarting = self.state.restarting;
        let request = native::step(parameters, &mut self.state, answer, &mut self.stack);
        self.status = request.status.value;
        if parameters.features.has_flags() {
            self.limits.culls = request.culls;
        }
        self.asked = Asked::of(&request);
        self.asked.restarts = (self.state.restarting & !was_restarting).into();
        self.asked
    }

    /// What it asks for.
    #[inline]
    pub fn asked(&self) -> Asked {
        self.asked
    }

    /// The reply of a ray that has ended.
    pub fn reply(&self, parameters: StepParameters) -> Reply {
        Reply::of(&self.state, self.status, parameters.features)
    }
}

state! { Asked { kind, count, is_instance, restarts, address } }

impl State for AskedKind {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        words.one_of(self, &[Self::Block, Self::Again, Self::Nothing, Self::Begin]);
    }
}

impl State for Walk {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        let Self { outside, inside, limits, state, stack, asked, status } = self;
        for ReadyRay { ray, is_refused } in [outside, inside] {
            words.bundle(ray);
            is_refused.pass(words);
        }
        words.bundle(limits);
        words.bundle(state);
        stack.iter_mut().for_each(|group| words.bundle(group));
        asked.pass(words);
        status.pass(words);
    }
}

impl AskedKind {
    /// The number of kinds.
    pub const COUNT: usize = 4;
}

impl Asked {
    /// Nothing.
    pub const NOTHING: Self =
        Self { kind: AskedKind::Nothing, count: 0, is_instance: false, restarts: false, address: 0 };

    /// What a request asks for.
    #[inline(always)]
    pub fn of(asked: &Request<Binary32>) -> Self {
        let kind = match asked.kind.value {
            request::FETCH => AskedKind::Block,
            request::CONTINUE => AskedKind::Again,
            _ => AskedKind::Nothing,
        };
        let (count, is_instance) = (asked.count.value as u8, asked.is_instance.into());
        Self { kind, count, is_instance, restarts: false, address: asked.address.value }
    }
}
