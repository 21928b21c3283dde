//! Agents that trace one ray after another.

use crate::render::{Aim, Brush};
use crate::scene::Scene;
use crate::trace::{Goal, Hit, Tracing, Traversal};
use raypath_model::Functional;
use raypath_ops::{Binary32, Job, Outcome, Ray, RayError};
use raypath_timing::{Agent, Step};
use std::cell::RefCell;
use std::rc::Rc;

/// What rays are traced for, one after another.
pub(super) trait Errand {
    /// What it is about.
    type Found: Copy + Default;

    /// The next ray, none if there is no other. `hit` is what the ray before has hit; before the first it means nothing.
    fn next(&mut self, hit: Option<Hit>) -> Result<Option<(Ray<Binary32>, Goal)>, RayError>;

    /// What has been found, after the last ray.
    fn found(&self) -> Self::Found;
}

/// A ray and its closest hit.
pub(super) struct Single {
    ray: Option<Ray<Binary32>>,
    hit: Option<Hit>,
}

/// Where agents hand in what they have found, and where a finished one leaves its traversal for the next: traversals are
/// allocated for as many as are in flight, not for each.
pub(super) struct Desk<'s, F>(Rc<RefCell<Drawers<'s, F>>>);

struct Drawers<'s, F> {
    spare: Vec<Traversal<'s>>,
    found: Vec<F>,
    failure: Option<RayError>,
}

/// An errand on its way.
struct Runner<'s, E: Errand> {
    /// Counted from 0 in the order in which they begin.
    number: usize,
    errand: E,
    /// None when it is done.
    traversal: Option<Traversal<'s>>,
    desk: Desk<'s, E::Found>,
}

impl<F> Clone for Desk<'_, F> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<'s, F: Copy + Default> Desk<'s, F> {
    /// A desk for so many errands.
    pub(super) fn new(errands: usize) -> Self {
        Self(Rc::new(RefCell::new(Drawers { spare: Vec::new(), found: vec![F::default(); errands], failure: None })))
    }

    /// An agent for each of `numbers`, with the errand of that number.
    pub(super) fn agents<E: Errand<Found = F>>(
        self,
        scene: &'s Scene,
        tracing: Tracing,
        numbers: impl Iterator<Item = usize>,
        errand: impl Fn(usize) -> E,
    ) -> impl Iterator<Item = impl Agent<Functional>> {
        numbers.map(errand).enumerate().map(move |(number, errand)| {
            let spare = self.0.borrow_mut().spare.pop();
            let traversal = Some(spare.unwrap_or_else(|| Traversal::new(scene.bvh(), tracing)));
            Runner { number, errand, traversal, desk: self.clone() }
        })
    }

    /// What has been found, by number.
    pub(super) fn found(self) -> Result<Vec<F>, RayError> {
        let Drawers { found, failure, .. } = &mut *self.0.borrow_mut();
        failure.map_or_else(|| Ok(std::mem::take(found)), Err)
    }
}

impl<E: Errand> Agent<Functional> for Runner<'_, E> {
    #[inline]
    fn step(&mut self) -> Step<Job> {
        let Some(traversal) = &mut self.traversal else { return Step::Done };
        loop {
            match Agent::<Functional>::step(traversal) {
                Step::Done => match self.errand.next(traversal.hit()) {
                    Ok(Some((ray, goal))) => traversal.start(ray, goal),
                    end => {
                        self.hand_in(end.err());
                        return Step::Done;
                    }
                },
                step => return step,
            }
        }
    }

    #[inline]
    fn answer(&mut self, outcome: &Outcome) {
        if let Some(traversal) = &mut self.traversal {
            Agent::<Functional>::answer(traversal, outcome);
        }
    }
}

impl<E: Errand> Runner<'_, E> {
    fn hand_in(&mut self, failure: Option<RayError>) {
        let mut drawers = self.desk.0.borrow_mut();
        drawers.spare.extend(self.traversal.take());
        drawers.found[self.number] = self.errand.found();
        drawers.failure = drawers.failure.or(failure);
    }
}

impl Single {
    pub(super) fn new(ray: Ray<Binary32>) -> Self {
        Self { ray: Some(ray), hit: None }
    }
}

impl Errand for Single {
    type Found = Option<Hit>;

    #[inline]
    fn next(&mut self, hit: Option<Hit>) -> Result<Option<(Ray<Binary32>, Goal)>, RayError> {
        self.hit = hit;
        Ok(self.ray.take().map(|ray| (ray, Goal::Closest)))
    }

    fn found(&self) -> Option<Hit> {
        self.hit
    }
}

impl Errand for Brush<'_> {
    type Found = [u8; 3];

    #[inline]
    fn next(&mut self, hit: Option<Hit>) -> Result<Option<(Ray<Binary32>, Goal)>, RayError> {
        Ok(self.next(hit)?.map(|Aim { ray, kind }| (ray, kind.goal())))
    }

    fn found(&self) -> [u8; 3] {
        self.colour()
    }
}
