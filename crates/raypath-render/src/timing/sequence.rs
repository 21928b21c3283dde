//! Agents that trace sequences of rays.

use crate::render::{PixelSampler, SampleRay};
use crate::{Goal, Hit, Scene, Tracing, Traversal};
use raypath_model::Functional;
use raypath_ops::{Binary32, Job, Outcome, Ray, RayError};
use raypath_timing::{Action, Agent};
use std::cell::RefCell;
use std::rc::Rc;

/// A sequence of rays, of which each may depend on the hit of the previous one, and its result.
pub(super) trait RaySequence {
    type Result: Copy + Default;

    /// The next ray, or `None` after the last. `hit` is the hit of the previous ray; the first call ignores it.
    fn next_ray(&mut self, hit: Option<Hit>) -> Result<Option<(Ray<Binary32>, Goal)>, RayError>;

    fn result(&self) -> Self::Result;
}

/// A sequence of one ray, whose result is the closest hit.
pub(super) struct SingleRay {
    ray: Option<Ray<Binary32>>,
    hit: Option<Hit>,
}

/// The results of all sequences, with a pool of traversals: an agent returns its traversal when it is done, so that
/// only as many are allocated as agents are in flight.
pub(super) struct ResultStore<'s, R>(Rc<RefCell<Store<'s, R>>>);

struct Store<'s, R> {
    free_traversals: Vec<Traversal<'s>>,
    results: Vec<R>,
    error: Option<RayError>,
}

struct SequenceAgent<'s, S: RaySequence> {
    /// The index of the result.
    number: usize,
    sequence: S,
    /// `None` when the agent is done.
    traversal: Option<Traversal<'s>>,
    store: ResultStore<'s, S::Result>,
}

impl<R> Clone for ResultStore<'_, R> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<'s, R: Copy + Default> ResultStore<'s, R> {
    pub(super) fn new(sequences: usize) -> Self {
        let results = vec![R::default(); sequences];
        Self(Rc::new(RefCell::new(Store { free_traversals: Vec::new(), results, error: None })))
    }

    pub(super) fn agents<S: RaySequence<Result = R>>(
        self,
        scene: &'s Scene,
        tracing: Tracing,
        numbers: impl Iterator<Item = usize>,
        sequence: impl Fn(usize) -> S,
    ) -> impl Iterator<Item = impl Agent<Functional>> {
        numbers.map(sequence).enumerate().map(move |(number, sequence)| {
            let free = self.0.borrow_mut().free_traversals.pop();
            let traversal = Some(free.unwrap_or_else(|| Traversal::new(scene.bvh(), tracing)));
            SequenceAgent { number, sequence, traversal, store: self.clone() }
        })
    }

    pub(super) fn results(self) -> Result<Vec<R>, RayError> {
        let Store { results, error, .. } = &mut *self.0.borrow_mut();
        error.map_or_else(|| Ok(std::mem::take(results)), Err)
    }
}

impl<S: RaySequence> Agent<Functional> for SequenceAgent<'_, S> {
    #[inline]
    fn next_action(&mut self) -> Action<Job> {
        let Some(traversal) = &mut self.traversal else { return Action::Done };
        loop {
            match Agent::<Functional>::next_action(traversal) {
                Action::Done => match self.sequence.next_ray(traversal.hit()) {
                    Ok(Some((ray, goal))) => traversal.start(ray, goal),
                    end => {
                        self.finish(end.err());
                        return Action::Done;
                    }
                },
                action => return action,
            }
        }
    }

    #[inline]
    fn receive(&mut self, outcome: &Outcome) {
        if let Some(traversal) = &mut self.traversal {
            Agent::<Functional>::receive(traversal, outcome);
        }
    }
}

impl<S: RaySequence> SequenceAgent<'_, S> {
    fn finish(&mut self, error: Option<RayError>) {
        let mut store = self.store.0.borrow_mut();
        store.free_traversals.extend(self.traversal.take());
        store.results[self.number] = self.sequence.result();
        store.error = store.error.or(error);
    }
}

impl SingleRay {
    pub(super) fn new(ray: Ray<Binary32>) -> Self {
        Self { ray: Some(ray), hit: None }
    }
}

impl RaySequence for SingleRay {
    type Result = Option<Hit>;

    #[inline]
    fn next_ray(&mut self, hit: Option<Hit>) -> Result<Option<(Ray<Binary32>, Goal)>, RayError> {
        self.hit = hit;
        Ok(self.ray.take().map(|ray| (ray, Goal::Closest)))
    }

    fn result(&self) -> Option<Hit> {
        self.hit
    }
}

impl RaySequence for PixelSampler<'_> {
    type Result = [u8; 3];

    #[inline]
    fn next_ray(&mut self, hit: Option<Hit>) -> Result<Option<(Ray<Binary32>, Goal)>, RayError> {
        Ok(self.next_ray(hit)?.map(|SampleRay { ray, kind }| (ray, kind.goal())))
    }

    fn result(&self) -> [u8; 3] {
        self.colour()
    }
}
