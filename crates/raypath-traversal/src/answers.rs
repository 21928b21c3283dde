//! What jobs and the memory answer, in native binary32.

use crate::blocks::wide8::{self, Half, Node8, Window};
use crate::blocks::{BLOCK_BYTES, LeafTriangle, Node, NodeKind, child_words};
use crate::candidate::Verdict;
use crate::fold::{After, HitLimits, fold};
use crate::instance::{Instance, Row, Transform, TransformInput};
use crate::model::RayRequest;
use crate::query::{Culls, RayFlags, ray_flags};
use crate::set_up::{self, Entry};
use crate::state::{Answer, RayWords, TriangleHit, answer};
use crate::step::{StepParameters, UnitFeatures};
use raypath_model::SimdKernels;
use raypath_ops::{
    Binary32, Culling, Flags, Num, Operation, Ray, RayBox, RayBoxInput, RayTriangleExtended, RayTriangleExtendedInput,
    Rounding, Rules, Vec3, Word, array_of,
};

/// A block of the memory, of the largest size.
pub(crate) type Block = [u8; BLOCK_BYTES as usize];

/// The operations of the unit's jobs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Answers {
    boxes: RayBox,
    triangles: RayTriangleExtended,
}

/// A ray after its set-up.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ReadyRay {
    /// Its constants; the extent is that of the entry.
    pub ray: Ray<Binary32>,
    /// It is refused.
    pub is_refused: bool,
}

impl Answers {
    /// The jobs of a unit by these rules.
    pub fn new(rules: Rules, parameters: StepParameters) -> Self {
        let UnitFeatures { barycentrics, edges, .. } = parameters.features;
        let rounding = Rounding::Unit;
        let (culling, facing, range) = (Culling::None, true, false);
        let triangles = RayTriangleExtended { rules, rounding, edges, culling, facing, barycentrics, range };
        Self { boxes: RayBox { rules, is_conservative: true }, triangles }
    }

    /// The rules of the boxes.
    pub fn rules(&self) -> Rules {
        self.boxes.rules
    }

    /// The operation of the triangles.
    pub fn triangles(&self) -> RayTriangleExtended {
        self.triangles
    }

    /// The constants of a ray.
    pub fn set_up(&self, entry: &Entry<Binary32>) -> ReadyRay {
        let axes = set_up::axes(Binary32, entry.dir);
        let quotient = |division: set_up::Division<Binary32>| quotient(division.dividend, division.divisor);
        let derived = set_up::derived(Binary32, axes, set_up::divisions(Binary32, entry.dir, axes).map(quotient));
        let is_refused = set_up::is_refused(Binary32, entry) | derived.is_too_short;
        let ray = set_up::ray(entry.origin, entry.dir, derived, axes, entry.t_max);
        ReadyRay { ray, is_refused: is_refused.into() }
    }

    /// The constants of a ray that begins.
    pub fn ready(&self, ray: &RayRequest) -> ReadyRay {
        let ready = self.set_up(&Entry::from(ray));
        let has_no_meaning: bool = ray.flags().are_meaningless().into();
        ReadyRay { is_refused: ready.is_refused | has_no_meaning, ..ready }
    }

    /// The constants of a ray in the space of an instance. The range of the ray was tested before.
    pub fn instance(&self, nodes: NodeKind, outside: &ReadyRay, block: &[u8]) -> ReadyRay {
        // A block that is shorter than the memory promises is none.
        let Some(Instance { to_object, .. }) = Instance::of(block, nodes) else {
            return ReadyRay { is_refused: true, ..*outside };
        };
        let transformed = |point: Vec3<Binary32>, is_moved: bool| {
            let row = |[x, y, z, t]: [f32; 4]| {
                let t = if is_moved { t } else { 0.0 };
                Row { x: x.into(), y: y.into(), z: z.into(), t: t.into() }
            };
            let (outcome, ()) = Transform.run(Binary32, TransformInput { point, matrix: to_object.map(row) }, ());
            outcome.transformed
        };
        let Ray { origin, dir, .. } = outside.ray;
        let (origin, dir) = (transformed(origin, true), transformed(dir, false));
        self.set_up(&Entry { origin, dir, t_min: 0.0.into(), t_max: 0.0.into() })
    }

    /// A ray enters an instance with these constants, or fails to.
    pub fn enter(nodes: NodeKind, ready: &ReadyRay, block: &[u8]) -> Answer<Binary32> {
        let kind = if ready.is_refused { answer::CANNOT_ENTER } else { answer::ENTER };
        Answer { child: child_words(block, nodes).map(Word::truncate), ..nothing(kind) }
    }

    /// A ray begins, or is refused.
    pub fn begin(ready: &ReadyRay) -> Answer<Binary32> {
        nothing(if ready.is_refused { answer::REFUSED } else { answer::START })
    }

    /// Nothing new.
    pub fn again() -> Answer<Binary32> {
        nothing(answer::CONTINUE)
    }

    /// The user's verdict on a candidate.
    pub fn verdict(candidate: TriangleHit<Binary32>, is_box: bool, verdict: Verdict) -> Answer<Binary32> {
        let Verdict { accepts, ends, t } = verdict;
        let t = if is_box { t.into() } else { candidate.t };
        let closest = TriangleHit { t, ..candidate };
        Answer { closest, verdict_accepts: accepts.into(), verdict_ends: ends.into(), ..nothing(answer::VERDICT) }
    }

    /// The memory reported an error.
    pub fn failure() -> Answer<Binary32> {
        nothing(answer::ERROR)
    }

    /// The outcome of a node's box jobs, for a ray of this length. Of eight children, those of a window are taken.
    #[inline(always)]
    pub fn node(
        &self,
        nodes: NodeKind,
        ready: &ReadyRay,
        extent: Num<Binary32>,
        block: &[u8],
        window: u8,
    ) -> Answer<Binary32> {
        let test = |aabb| {
            let input = RayBoxInput { ray: Ray { extent, ..ready.ray }, aabb };
            self.boxes.run_with(Binary32, SimdKernels, input, ()).0
        };
        // A block that is shorter than the memory promises is none.
        let Node { boxes, children } = match nodes {
            NodeKind::Wide4 => match block.first_chunk() {
                Some(block) => Node::of(block),
                None => return Self::failure(),
            },
            NodeKind::Quantised => match block.first_chunk() {
                Some(block) => Node::of_quantised(block),
                None => return Self::failure(),
            },
            NodeKind::Wide8 => {
                let Some(bytes) = block.first_chunk() else { return Self::failure() };
                let boxes = Node8::of(bytes).boxes;
                let half = |first: usize| {
                    let outcome = test(array_of!(i => boxes[first + i]));
                    Half { hit: outcome.is_intersect, tmin: outcome.tmin, box_index: outcome.box_index }
                };
                let window = Word::truncate(window.into());
                let taken = wide8::window(Binary32, [half(0), half(4)], window);
                let child = child_words(block, nodes).map(Word::truncate);
                let Window { hit, tmin, box_index, box_upper } = taken;
                return Answer { hit, tmin, box_index, box_upper, window, child, ..nothing(answer::BOXES) };
            }
        };
        let outcome = test(boxes);
        Answer {
            hit: outcome.is_intersect,
            tmin: [outcome.tmin[1], outcome.tmin[2], outcome.tmin[3]],
            box_index: outcome.box_index,
            child: array_of!(i => Word::truncate(children[i])),
            ..nothing(answer::BOXES)
        }
    }

    /// The outcomes of the triangle jobs of a leaf's block.
    pub fn leaf(
        &self,
        nodes: NodeKind,
        ready: &ReadyRay,
        limits: HitLimits<Binary32>,
        block: &[u8],
        count: u32,
    ) -> Answer<Binary32> {
        let mut closest = no_hit();
        for place in 0..count {
            closest = fold(closest, (place == 0).into(), self.triangle(nodes, ready, block, place), limits);
        }
        Answer { closest, ..nothing(answer::BLOCK) }
    }

    /// The outcome of a triangle job with its distance.
    fn triangle(&self, nodes: NodeKind, ready: &ReadyRay, block: &[u8], place: u32) -> TriangleHit<Binary32> {
        let LeafTriangle { triangle, index } = LeafTriangle::of(block, place as usize, nodes);
        let input = RayTriangleExtendedInput { ray: ready.ray, triangle, t_min: 0.0.into() };
        let (outcome, ()) = self.triangles.run_with(Binary32, SimdKernels, input, ());
        TriangleHit {
            is_hit: outcome.triangle_hit,
            has_more: false.into(),
            t: quotient(outcome.t_num, outcome.t_denom),
            t_num: outcome.t_num,
            t_denom: outcome.t_denom,
            u_num: outcome.barycentric.v,
            v_num: outcome.barycentric.w,
            is_clockwise: !outcome.facing,
            primitive: Word::truncate(index),
            geometry: Word::truncate(LeafTriangle::geometry(block, nodes)),
        }
    }
}

impl After<Binary32> {
    /// None.
    pub(crate) fn none() -> Self {
        Self { is_set: false.into(), t: 0.0.into(), primitive: Word::truncate(0) }
    }
}

impl RayRequest {
    /// Its flags.
    pub(crate) fn flags(&self) -> RayFlags<Binary32> {
        RayFlags::of(Word::truncate(self.flags))
    }

    /// The limits that the ray sets to hits, in a unit of [`Queries::None`](crate::Queries::None).
    pub(crate) fn limits(&self, parameters: StepParameters) -> HitLimits<Binary32> {
        let culls: Culls<Binary32> = self.flags().culls_of_opaque(Binary32, parameters.front);
        HitLimits { t_min: self.t_min.into(), culls, after: After::none() }
    }

    /// What a step knows of it.
    pub(crate) fn words(&self) -> RayWords<Binary32> {
        let Self { root, t_min, t_max, flags, cull_mask, .. } = *self;
        RayWords {
            root: Word::truncate(root),
            t_min: t_min.into(),
            t_max: t_max.into(),
            any_hit: (flags & ray_flags::TERMINATE_ON_FIRST_HIT != 0).into(),
            flags: self.flags(),
            cull_mask: Word::truncate(cull_mask.into()),
        }
    }
}

impl From<&RayRequest> for Entry<Binary32> {
    fn from(&RayRequest { origin, direction, t_min, t_max, .. }: &RayRequest) -> Self {
        Self { origin: origin.into(), dir: direction.into(), t_min: t_min.into(), t_max: t_max.into() }
    }
}

/// A quotient as the hardware divides.
pub(crate) fn quotient(a: Num<Binary32>, b: Num<Binary32>) -> Num<Binary32> {
    (f32::from(a) / f32::from(b)).into()
}

pub(crate) fn no_hit() -> TriangleHit<Binary32> {
    let (no, zero) = (false.into(), 0.0.into());
    TriangleHit {
        is_hit: no,
        has_more: no,
        t: zero,
        t_num: zero,
        t_denom: zero,
        u_num: zero,
        v_num: zero,
        is_clockwise: no,
        primitive: Word::truncate(0),
        geometry: Word::truncate(0),
    }
}

#[inline(always)]
fn nothing(kind: u32) -> Answer<Binary32> {
    let (no, zero, none) = (false.into(), 0.0.into(), Word::truncate(0));
    Answer {
        kind: Word::truncate(kind),
        hit: Flags([no; 4]),
        tmin: [zero; 3],
        box_index: [Word::truncate(0); 4],
        box_upper: Flags([no; 4]),
        window: Word::truncate(0),
        child: [none; 4],
        closest: no_hit(),
        verdict_accepts: no,
        verdict_ends: no,
    }
}
