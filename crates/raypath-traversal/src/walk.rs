//! A ray on its way through a scene, without time.

use crate::answers::{Answers, ReadyRay, no_hit, quotient};
use crate::blocks::NodeKind;
use crate::candidate::{Candidate, Verdict};
use crate::fold::{After, HitLimits};
use crate::model::{Hit, HitInstance, Memory, RayRequest, Reply};
use crate::native::{self, Stack, empty_stack};
use crate::set_up::Entry;
use crate::state::{Answer, RayState, Request, TriangleHit, request, status};
use crate::step::{StepParameters, UnitFeatures, is_back_face};
use raypath_model::{State, StateWords, state};
use raypath_ops::{Binary32, Ray, Vec3};

/// A ray on its way through a scene.
#[derive(Debug, Clone)]
pub(crate) struct Walk {
    /// The upper bits of the ray's addresses.
    base: u32,
    outside: ReadyRay,
    /// In the space of the instance that it entered last.
    inside: ReadyRay,
    limits: HitLimits<Binary32>,
    state: RayState<Binary32>,
    stack: Stack,
    asked: Asked,
    status: u32,
    /// The closest hit of the last block, and what the user decided about it, if it was a candidate.
    closest: TriangleHit<Binary32>,
    verdict: Verdict,
}

/// What a ray asks for after a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Asked {
    pub kind: AskedKind,
    /// Of a block: the number of its triangles; 0 for a node, 2 for an instance.
    pub count: u8,
    /// Of a block of eight children: see [`Request::window`].
    pub window: u8,
    /// Of a block: it is an instance's.
    pub is_instance: bool,
    /// The ray descends again from the root.
    pub restarts: bool,
    /// The address of a block, without the base of the ray, so that a step that is computed ahead takes 8 bytes.
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
    /// The verdict on a candidate.
    Verdict,
}

impl Walk {
    /// A ray that has ended.
    pub fn new(answers: &Answers) -> Self {
        let zero = 0.0.into();
        let origin = Vec3 { x: zero, y: zero, z: zero };
        let ready = answers.set_up(&Entry { origin, dir: origin, t_min: zero, t_max: zero });
        Self {
            base: 0,
            outside: ready,
            inside: ready,
            limits: RayRequest::NONE.limits(StepParameters::default()),
            state: RayState::begin(Binary32, RayRequest::NONE.words()),
            stack: empty_stack(),
            asked: Asked::NOTHING,
            status: status::MISS,
            closest: no_hit(),
            verdict: Verdict::IGNORE,
        }
    }

    /// A ray begins.
    pub fn begin(&mut self, answers: &Answers, parameters: StepParameters, ray: &RayRequest) {
        self.base = ray.base;
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
            AskedKind::Verdict => {
                let answer = Answers::verdict(self.closest, self.state.leaf_is_box.into(), self.verdict);
                return self.advance(parameters, answer);
            }
            AskedKind::Again | AskedKind::Nothing => return self.advance(parameters, Answers::again()),
        }
        let ready = self.here();
        // Each kind of answer has a copy of the step, from which the compiler removes what other answers need.
        match memory.block(self.address(block), parameters.node.block_bytes()) {
            Ok(bytes) if block.is_instance => {
                self.inside = answers.instance(parameters.node, ready, bytes);
                self.advance(parameters, Answers::enter(parameters.node, &self.inside, bytes))
            }
            Ok(bytes) if block.count == 0 => {
                self.advance(parameters, answers.node(parameters.node, ready, self.state.extent, bytes, block.window))
            }
            Ok(bytes) => {
                let answer = answers.leaf(parameters.node, ready, self.limits, bytes, block.count.into());
                self.closest = answer.closest;
                self.advance(parameters, answer)
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
            let TriangleHit { t, primitive, .. } = self.closest;
            self.limits.after = After { is_set: request.repeats, t, primitive };
        }
        self.asked = Asked::of(&request);
        self.asked.restarts = (self.state.restarting & !was_restarting).into();
        self.asked
    }

    /// Decides about the candidate that it asks about.
    pub fn decide(&mut self, verdict: Verdict) {
        self.verdict = verdict;
    }

    /// The candidate that it asks about.
    pub fn candidate(&self, parameters: StepParameters) -> Option<Candidate> {
        let (RayState { leaf_is_box, leaf_is_opaque, instance_flags, instance, .. }, hit) = (self.state, self.closest);
        if self.asked.kind != AskedKind::Verdict {
            return None;
        }
        let indices = Hit {
            primitive: hit.primitive.value,
            geometry: hit.geometry.value,
            instance: HitInstance::of(instance, parameters.features),
            ..Hit::default()
        };
        let weight = |numerator| quotient(numerator, hit.t_denom).into();
        let barycentrics = parameters.features.barycentrics;
        let of_triangle = Hit {
            t: hit.t.into(),
            t_num: hit.t_num.into(),
            t_denom: hit.t_denom.into(),
            back_face: is_back_face(parameters.front, instance_flags, hit.is_clockwise).into(),
            barycentric: barycentrics.then(|| [weight(hit.u_num), weight(hit.v_num)]),
            ..indices
        };
        let (is_box, is_opaque) = (leaf_is_box.into(), leaf_is_opaque.into());
        let hit = if is_box { indices } else { of_triangle };
        let Ray { origin, dir, .. } = self.here().ray;
        Some(Candidate { hit, is_box, is_opaque, origin: origin.into(), direction: dir.into() })
    }

    /// The ray in the space in which it is.
    #[inline(always)]
    fn here(&self) -> &ReadyRay {
        if self.state.inside.into() { &self.inside } else { &self.outside }
    }

    /// The address of a block that this ray asked for.
    #[inline]
    pub fn address(&self, asked: Asked) -> u64 {
        RayRequest::address(self.base, asked.address)
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

state! { Asked { kind, count, window, is_instance, restarts, address } }

impl State for AskedKind {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        words.one_of(self, &[Self::Block, Self::Again, Self::Nothing, Self::Begin, Self::Verdict]);
    }
}

impl State for Walk {
    fn pass(&mut self, words: &mut StateWords<'_>) {
        let Self { base, outside, inside, limits, state, stack, asked, status, closest, verdict } = self;
        base.pass(words);
        for ReadyRay { ray, is_refused } in [outside, inside] {
            words.bundle(ray);
            is_refused.pass(words);
        }
        words.bundle(limits);
        words.bundle(state);
        stack.iter_mut().for_each(|group| words.bundle(group));
        asked.pass(words);
        status.pass(words);
        words.bundle(closest);
        verdict.pass(words);
    }
}

impl AskedKind {
    /// The number of kinds.
    pub const COUNT: usize = 5;
}

impl Asked {
    /// Nothing.
    pub const NOTHING: Self =
        Self { kind: AskedKind::Nothing, count: 0, window: 0, is_instance: false, restarts: false, address: 0 };

    /// What a request asks for.
    #[inline(always)]
    pub fn of(asked: &Request<Binary32>) -> Self {
        let kind = match asked.kind.value {
            request::FETCH => AskedKind::Block,
            request::CONTINUE => AskedKind::Again,
            request::CANDIDATE => AskedKind::Verdict,
            _ => AskedKind::Nothing,
        };
        let (count, window, is_instance) =
            (asked.count.value as u8, asked.window.value as u8, asked.is_instance.into());
        Self { kind, count, window, is_instance, restarts: false, address: asked.address.value }
    }
}
