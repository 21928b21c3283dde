use super::{Counts, Goal, Hit, Tracing};
use crate::bvh::{Bvh4, Reference, Target};
use raypath_model::Functional;
use raypath_ops::{
    Aabb, Binary32, Job, Outcome, Ray, RayBoxInput, RayBoxOutput, RayTriangleInput, RayTriangleOutput, Triangle, Word,
};
use raypath_timing::{Agent, Step};

/// The external circuit for one ray: an [`Agent`] that says what it needs next, and takes what the datapath answers.
///
/// A leaf gives all its jobs before it waits, whatever is sought. So it makes no difference to hits and counts whether
/// jobs are answered at once or late.
///
/// The ray is shortened as hits are found, so that boxes beyond the closest are missed. A box at exactly that distance is
/// opened, for there may be a triangle of a lower index in it.
#[derive(Debug, Clone)]
pub struct Traversal<'s> {
    bvh: &'s Bvh4,
    tracing: Tracing,
    goal: Goal,
    ray: Ray<Binary32>,
    state: State,
    stack: Vec<Later>,
    best: Option<Hit>,
    counts: Counts,
}

/// What a ray needs next: a [`Step`] with jobs that are not yet copied together.
#[derive(Debug, Clone, Copy)]
pub(super) enum Need<'s> {
    /// A node or a leaf from memory.
    Fetch,
    /// These boxes tested against [`Traversal::ray`].
    Boxes(&'s [Aabb<Binary32>; 4]),
    /// This triangle tested against [`Traversal::ray`].
    Triangle(Triangle<Binary32>),
    /// The answer to a job that was given before.
    Wait,
    /// Nothing: see [`Traversal::hit`].
    Done,
}

/// A child that was hit and not yet opened.
#[derive(Debug, Clone, Copy)]
struct Later {
    reference: Reference,
    tmin: f32,
}

#[derive(Debug, Clone, Copy)]
enum State {
    /// The next child is to be chosen.
    Choose,
    /// What was fetched is here.
    Fetched(Reference),
    /// The boxes of a node are being tested.
    Node(u32),
    /// The triangles of a leaf are.
    Leaf(Leaf),
    Done,
}

/// A leaf whose jobs are on their way. A job is a place and a side, `2 · place + side`; only even ones where the back
/// cannot be hit.
#[derive(Debug, Clone, Copy)]
struct Leaf {
    /// The job to be given next.
    next: u64,
    /// The job to be answered next.
    awaited: u64,
    /// The job after the last.
    end: u64,
}

impl<'s> Traversal<'s> {
    /// A machine without a ray; it is done until [`start`](Self::start). Allocates its stack, and nothing later.
    pub fn new(bvh: &'s Bvh4, tracing: Tracing) -> Self {
        let (goal, counts) = (Goal::Closest, Counts::default());
        let stack = Vec::with_capacity(bvh.stack_size());
        Self { bvh, tracing, goal, ray: no_ray(), state: State::Done, stack, best: None, counts }
    }

    /// Begins with a ray, whatever was before. Allocates nothing.
    #[inline]
    pub fn start(&mut self, ray: Ray<Binary32>, goal: Goal) {
        (self.ray, self.goal) = (ray, goal);
        self.stack.clear();
        self.stack.push(Later { reference: Reference::ROOT, tmin: 0.0 });
        (self.state, self.best, self.counts) = (State::Choose, None, Counts::default());
    }

    /// The ray, as far as the closest hit that is known.
    #[inline]
    pub fn ray(&self) -> &Ray<Binary32> {
        &self.ray
    }

    /// What it hits, as far as that is known.
    #[inline]
    pub fn hit(&self) -> Option<Hit> {
        self.best
    }

    /// What it has cost.
    #[inline]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// What the ray needs next.
    #[inline]
    pub(super) fn need(&mut self) -> Need<'s> {
        match self.state {
            State::Choose => self.choose(),
            State::Fetched(reference) => match reference.target() {
                Target::Node(node) => {
                    self.state = State::Node(node);
                    self.counts.quadbox += 1;
                    Need::Boxes(&self.bvh.nodes()[node as usize].boxes)
                }
                Target::Leaf { first, count } => {
                    let (first, end) = (2 * u64::from(first), 2 * u64::from(first + count));
                    self.leaf(Leaf { next: first, awaited: first, end })
                }
            },
            State::Node(_) => Need::Wait,
            State::Leaf(leaf) => self.leaf(leaf),
            State::Done => Need::Done,
        }
    }

    /// The answer to [`Need::Boxes`].
    #[inline]
    pub(super) fn boxes(&mut self, answer: &RayBoxOutput<Binary32>) {
        let State::Node(node) = self.state else { return };
        let children = &self.bvh.nodes()[node as usize].children;
        // The nearest comes last, to be opened first.
        for place in (0..4).rev() {
            if bool::from(answer.is_intersect.0[place]) {
                let child = u32::from(answer.box_index[place]) as usize & 3;
                self.stack.push(Later { reference: children[child], tmin: answer.tmin[place].into() });
            }
        }
        self.state = State::Choose;
    }

    /// The answer to [`Need::Triangle`].
    #[inline]
    pub(super) fn triangle(&mut self, answer: &RayTriangleOutput<Binary32>) {
        let State::Leaf(leaf) = &mut self.state else { return };
        let job = leaf.awaited;
        leaf.awaited += self.tracing.job_stride();
        if bool::from(answer.triangle_hit) {
            self.take(job, answer.t_num.into(), answer.t_denom.into());
        }
    }

    /// The next child whose box is no farther than the closest hit.
    #[inline]
    fn choose(&mut self) -> Need<'s> {
        let extent: f32 = self.ray.extent.into();
        while let Some(Later { reference, tmin }) = self.stack.pop() {
            if tmin <= extent {
                self.state = State::Fetched(reference);
                match reference.target() {
                    Target::Node(_) => self.counts.nodes += 1,
                    Target::Leaf { .. } => self.counts.leaves += 1,
                }
                return Need::Fetch;
            }
        }
        self.state = State::Done;
        Need::Done
    }

    /// The next job of a leaf.
    #[inline]
    fn leaf(&mut self, leaf: Leaf) -> Need<'s> {
        let job = leaf.next;
        if job < leaf.end {
            self.state = State::Leaf(Leaf { next: job + self.tracing.job_stride(), ..leaf });
            let &Triangle { a, b, c } = self.bvh.triangle((job / 2) as u32);
            if job.is_multiple_of(2) {
                self.counts.triangle += 1;
                return Need::Triangle(Triangle { a, b, c });
            }
            self.counts.behind += 1;
            return Need::Triangle(Triangle { a, b: c, c: b });
        }
        if leaf.awaited < job {
            return Need::Wait;
        }
        if self.goal == Goal::Any && self.best.is_some() {
            self.state = State::Done;
            return Need::Done;
        }
        self.choose()
    }

    /// A triangle that is hit. The division and the comparison with what is known are the external circuit's.
    #[inline]
    fn take(&mut self, job: u64, t_num: f32, t_denom: f32) {
        let (t, triangle) = (t_num / t_denom, self.bvh.index((job / 2) as u32));
        let extent: f32 = self.ray.extent.into();
        let closer = match self.best {
            None => t <= extent,
            Some(best) => t < best.t || t == best.t && triangle < best.triangle,
        };
        if closer {
            self.best = Some(Hit { triangle, from_behind: job % 2 == 1, t_num, t_denom, t });
            self.ray.extent = t.into();
        }
    }
}

impl<const E: usize, const A: usize> Agent<Functional<E, A>> for Traversal<'_> {
    #[inline]
    fn step(&mut self) -> Step<Job<E, A>> {
        let need = self.need();
        let ray = self.ray;
        let job = match need {
            Need::Boxes(aabb) => Job::Quadbox(RayBoxInput { ray, aabb: *aabb }),
            Need::Triangle(triangle) => Job::Triangle(RayTriangleInput { ray, triangle }),
            Need::Fetch => return Step::Fetch,
            Need::Wait => return Step::Wait,
            Need::Done => return Step::Done,
        };
        Step::Issue { job, holds: false }
    }

    /// Distances between vectors are no answer to any of its jobs, and do nothing.
    #[inline]
    fn answer(&mut self, outcome: &Outcome) {
        match outcome {
            Outcome::Quadbox(answer) => self.boxes(answer),
            Outcome::Triangle(answer) => self.triangle(answer),
            Outcome::Euclidean(_) | Outcome::Angular(_) => {}
        }
    }
}

impl Tracing {
    /// From one job of a leaf to the next.
    #[inline]
    fn job_stride(self) -> u64 {
        if self.two_sided { 1 } else { 2 }
    }
}

/// Something to put where no ray is yet.
fn no_ray() -> Ray<Binary32> {
    let (zero, k) = ([0.0; 3].into(), Word::truncate(0));
    Ray { origin: zero, dir: zero, inv: zero, extent: 0.0.into(), shear: zero, kx: k, ky: k, kz: k }
}
