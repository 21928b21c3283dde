//! Rays that are computed before their blocks arrive.

use super::contexts::{CONTEXTS, Contexts};
use crate::answers::Answers;
use crate::candidate::Verdict;
use crate::model::{Memory, RayRequest, Reply};
use crate::step::StepParameters;
use crate::walk::{Asked, AskedKind, Walk};
use raypath_ops::Rules;
use std::hint::select_unpredictable;

/// The steps that are computed at once: more than most rays take.
const AHEAD: usize = 16;

/// Rays in a scene that is known, whose steps are computed before the unit takes them. What a ray does depends on the
/// ray and the scene alone, and many steps of the same ray are faster than single steps of many rays.
pub struct AheadContexts<'s, M: ?Sized> {
    parameters: StepParameters,
    answers: Answers,
    scene: &'s M,
    walks: Vec<(u64, Walk)>,
    /// What each ray asks for in the next steps.
    steps: Box<[[Asked; AHEAD]; CONTEXTS]>,
    /// The number of the next of them.
    next: [u32; CONTEXTS],
    /// What each ray asked for in its last step.
    asked: [Asked; CONTEXTS],
    failed: [bool; CONTEXTS],
}

impl<'s, M: Memory + ?Sized> AheadContexts<'s, M> {
    /// So many contexts without rays.
    pub fn new(parameters: StepParameters, scene: &'s M, count: u32) -> Self {
        let answers = Answers::new(Rules::Paper, parameters);
        let walks = vec![(0, Walk::new(&answers)); count as usize];
        let steps = Box::new([[Asked::NOTHING; AHEAD]; CONTEXTS]);
        let (next, asked, failed) = ([0; CONTEXTS], [Asked::NOTHING; CONTEXTS], [false; CONTEXTS]);
        Self { parameters, answers, scene, walks, steps, next, asked, failed }
    }

    /// The block of a context has arrived.
    #[inline]
    pub fn arrive(&mut self, context: u8, failed: bool) {
        self.failed[usize::from(context)] = failed;
    }

    /// Computes the steps of a ray until it ends, but not too many.
    #[cold]
    fn compute(&mut self, context: u8) {
        let walk = &mut self.walks[usize::from(context)].1;
        for asked in &mut self.steps[usize::from(context)] {
            *asked = walk.step(&self.answers, self.parameters, self.scene);
            if let Some(candidate) = walk.candidate(self.parameters) {
                walk.decide(Verdict::without_shaders(&candidate));
            }
            if asked.kind == AskedKind::Nothing {
                break;
            }
        }
        self.next[usize::from(context)] = 0;
    }
}

impl<M: Memory + ?Sized> Contexts for AheadContexts<'_, M> {
    fn enter(&mut self, context: u8, id: u64, ray: &RayRequest) {
        let (number, walk) = &mut self.walks[usize::from(context)];
        *number = id;
        walk.begin(&self.answers, self.parameters, ray);
        self.compute(context);
    }

    #[inline]
    fn step(&mut self, context: u8, steps: bool) -> Asked {
        let place = usize::from(context);
        // One test, because `steps` alone is as random as the traffic.
        let most = if steps { AHEAD } else { usize::MAX };
        if self.next[place] as usize >= most {
            self.compute(context);
        }
        let asked = self.steps[place][self.next[place] as usize % AHEAD];
        self.next[place] += u32::from(steps);
        self.asked[place] = select_unpredictable(steps, asked, self.asked[place]);
        asked
    }

    #[inline]
    fn asked(&self, context: u8) -> Asked {
        self.asked[usize::from(context)]
    }

    #[inline]
    fn address(&self, context: u8) -> u64 {
        self.walks[usize::from(context)].1.address(self.asked(context))
    }

    #[inline]
    fn failed(&self, context: u8) -> bool {
        self.failed[usize::from(context)]
    }

    fn reply(&self, context: u8) -> (u64, Reply) {
        let (id, walk) = &self.walks[usize::from(context)];
        (*id, walk.reply(self.parameters))
    }
}
