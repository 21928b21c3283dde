mod at_once;

use super::{Counts, Goal, Hit, Tracing};
use raypath_model::Functional;
use raypath_ops::{
    Aabb, Binary32, Job, Outcome, Ray, RayBoxInput, RayBoxOutput, RayTriangleInput, RayTriangleOutput, Triangle, Word,
};
use raypath_scene::bvh::{Bvh4, Reference, Target};
use raypath_timing::{Action, Agent};

/// The traversal of the tree by one ray: an [`Agent`] that issues box and triangle jobs and keeps the hit.
///
/// It issues all jobs of a leaf before it waits for the first outcome, for either [`Goal`]. Hits and counts therefore
/// do not depend on the latency of the datapath.
///
/// Each hit shortens the extent of the ray, so that boxes beyond the closest hit are missed. A box at exactly that
/// distance is opened, because it may contain a triangle with a lower index.
#[derive(Debug, Clone)]
pub struct Traversal<'s> {
    bvh: &'s Bvh4,
    tracing: Tracing,
    goal: Goal,
    ray: Ray<Binary32>,
    state: State,
    stack: Vec<StackEntry>,
    best: Option<Hit>,
    counts: Counts,
}

/// The next action of a traversal, as an [`Action`] that borrows the operands of its job.
#[derive(Debug, Clone, Copy)]
enum Request<'s> {
    /// Fetch a node or a leaf.
    Fetch,
    /// Test these boxes with [`Traversal::ray`].
    Boxes(&'s [Aabb<Binary32>; 4]),
    /// Test this triangle with [`Traversal::ray`].
    Triangle(Triangle<Binary32>),
    /// Wait for an outcome.
    Wait,
    /// Traversal is complete; [`Traversal::hit`] is final.
    Done,
}

/// A child whose box was hit and that is not yet opened.
#[derive(Debug, Clone, Copy)]
struct StackEntry {
    reference: Reference,
    tmin: f32,
}

#[derive(Debug, Clone, Copy)]
enum State {
    /// Ready to pop the next child from the stack.
    Pop,
    /// A node or leaf was fetched.
    Fetched(Reference),
    /// A box job is outstanding.
    Node(u32),
    /// Triangle jobs of a leaf are issued or outstanding.
    Leaf(Leaf),
    Done,
}

/// The progress of a leaf. A job has the number `2 · slot + side`; one-sided tracing uses even numbers only.
#[derive(Debug, Clone, Copy)]
struct Leaf {
    next: u64,
    /// The oldest outstanding job.
    awaited: u64,
    /// The end of the job numbers.
    end: u64,
}

impl<'s> Traversal<'s> {
    /// A traversal without a ray, done until [`start`](Self::start). It allocates its stack here and nothing later.
    pub fn new(bvh: &'s Bvh4, tracing: Tracing) -> Self {
        let (goal, counts) = (Goal::Closest, Counts::default());
        let stack = Vec::with_capacity(bvh.stack_size());
        Self { bvh, tracing, goal, ray: no_ray(), state: State::Done, stack, best: None, counts }
    }

    /// Starts the traversal of a ray and discards any previous one.
    #[inline]
    pub fn start(&mut self, ray: Ray<Binary32>, goal: Goal) {
        (self.ray, self.goal) = (ray, goal);
        self.stack.clear();
        self.stack.push(StackEntry { reference: Reference::ROOT, tmin: 0.0 });
        (self.state, self.best, self.counts) = (State::Pop, None, Counts::default());
    }

    /// The ray, with its extent shortened to the closest hit so far.
    #[inline]
    pub fn ray(&self) -> &Ray<Binary32> {
        &self.ray
    }

    /// The best hit so far.
    #[inline]
    pub fn hit(&self) -> Option<Hit> {
        self.best
    }

    /// The cost so far.
    #[inline]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    #[inline]
    fn next_request(&mut self) -> Request<'s> {
        match self.state {
            State::Pop => self.pop(),
            State::Fetched(reference) => match reference.target() {
                Target::Node(node) => {
                    self.state = State::Node(node);
                    self.counts.quadbox += 1;
                    Request::Boxes(&self.bvh.nodes()[node as usize].boxes)
                }
                Target::Leaf { first, count } => {
                    let (first, end) = (2 * u64::from(first), 2 * u64::from(first + count));
                    self.next_of_leaf(Leaf { next: first, awaited: first, end })
                }
            },
            State::Node(_) => Request::Wait,
            State::Leaf(leaf) => self.next_of_leaf(leaf),
            State::Done => Request::Done,
        }
    }

    /// Takes the output of [`Request::Boxes`].
    #[inline]
    fn finish_boxes(&mut self, output: &RayBoxOutput<Binary32>) {
        let State::Node(node) = self.state else { return };
        let children = &self.bvh.nodes()[node as usize].children;
        // The nearest child is pushed last, so that it is opened first.
        for rank in (0..4).rev() {
            if bool::from(output.is_intersect.0[rank]) {
                let child = u32::from(output.box_index[rank]) as usize & 3;
                self.stack.push(StackEntry { reference: children[child], tmin: output.tmin[rank].into() });
            }
        }
        self.state = State::Pop;
    }

    /// Takes the output of [`Request::Triangle`].
    #[inline]
    fn finish_triangle(&mut self, output: &RayTriangleOutput<Binary32>) {
        let State::Leaf(leaf) = &mut self.state else { return };
        let job = leaf.awaited;
        leaf.awaited += self.tracing.job_stride();
        if bool::from(output.triangle_hit) {
            self.record_hit(job, output.t_num.into(), output.t_denom.into());
        }
    }

    /// Pops the next child whose box is no farther than the closest hit.
    #[inline]
    fn pop(&mut self) -> Request<'s> {
        let extent: f32 = self.ray.extent.into();
        while let Some(StackEntry { reference, tmin }) = self.stack.pop() {
            if tmin <= extent {
                self.state = State::Fetched(reference);
                match reference.target() {
                    Target::Node(_) => self.counts.nodes += 1,
                    Target::Leaf { .. } => self.counts.leaves += 1,
                }
                return Request::Fetch;
            }
        }
        self.state = State::Done;
        Request::Done
    }

    #[inline]
    fn next_of_leaf(&mut self, leaf: Leaf) -> Request<'s> {
        let job = leaf.next;
        if job < leaf.end {
            self.state = State::Leaf(Leaf { next: job + self.tracing.job_stride(), ..leaf });
            let &Triangle { a, b, c } = self.bvh.triangle((job / 2) as u32);
            if job.is_multiple_of(2) {
                self.counts.triangle += 1;
                return Request::Triangle(Triangle { a, b, c });
            }
            self.counts.behind += 1;
            return Request::Triangle(Triangle { a, b: c, c: b });
        }
        if leaf.awaited < job {
            return Request::Wait;
        }
        if self.goal == Goal::Any && self.best.is_some() {
            self.state = State::Done;
            return Request::Done;
        }
        self.pop()
    }

    /// Records a triangle hit if it is closer than the best: the division and comparison of the external circuit.
    #[inline]
    fn record_hit(&mut self, job: u64, t_num: f32, t_denom: f32) {
        let (t, triangle) = (t_num / t_denom, self.bvh.index((job / 2) as u32));
        let extent: f32 = self.ray.extent.into();
        let closer = match self.best {
            None => t <= extent,
            Some(best) => t < best.t || t == best.t && triangle < best.triangle,
        };
        if closer {
            self.best = Some(Hit { triangle, from_behind: job % 2 == 1, t_num, t_denom, t, instance: None });
            self.ray.extent = t.into();
        }
    }
}

impl<const E: usize, const A: usize> Agent<Functional<E, A>> for Traversal<'_> {
    #[inline]
    fn next_action(&mut self) -> Action<Job<E, A>> {
        let request = self.next_request();
        let ray = self.ray;
        let job = match request {
            Request::Boxes(aabb) => Job::Quadbox(RayBoxInput { ray, aabb: *aabb }),
            Request::Triangle(triangle) => Job::Triangle(RayTriangleInput { ray, triangle }),
            Request::Fetch => return Action::Fetch,
            Request::Wait => return Action::Wait,
            Request::Done => return Action::Done,
        };
        Action::Issue(job)
    }

    /// Distance outcomes are ignored: the traversal does not issue distance jobs.
    #[inline]
    fn receive(&mut self, outcome: &Outcome) {
        match outcome {
            Outcome::Quadbox(output) => self.finish_boxes(output),
            Outcome::Triangle(output) => self.finish_triangle(output),
            Outcome::Euclidean(_) | Outcome::Angular(_) => {}
        }
    }
}

impl Tracing {
    /// The difference between the numbers of two jobs of a leaf.
    #[inline]
    fn job_stride(self) -> u64 {
        if self.two_sided { 1 } else { 2 }
    }
}

/// A placeholder before the first ray.
fn no_ray() -> Ray<Binary32> {
    let (zero, k) = ([0.0; 3].into(), Word::truncate(0));
    Ray { origin: zero, dir: zero, inv: zero, extent: 0.0.into(), shear: zero, kx: k, ky: k, kz: k }
}
