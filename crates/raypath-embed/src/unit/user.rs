//! The user of a simulated unit: a list of rays.

use super::layout::{UnitHit, UnitRay};
use raypath_traversal::system::RayUser;
use raypath_traversal::{RayRequest, Reply};

/// Rays that are sent in order, with the places of their hits.
pub struct List<'l> {
    rays: &'l [UnitRay],
    hits: &'l mut [UnitHit],
    sent: usize,
    received: u64,
    progress: &'l dyn Fn(u64) -> bool,
}

/// Hits between two calls of the progress.
const STRIDE: u64 = 64;

impl<'l> List<'l> {
    pub fn new(rays: &'l [UnitRay], hits: &'l mut [UnitHit], progress: &'l dyn Fn(u64) -> bool) -> Self {
        Self { rays, hits, sent: 0, received: 0, progress }
    }
}

impl RayUser for List<'_> {
    fn next_ray(&mut self) -> Option<(u64, RayRequest)> {
        let ray = self.rays.get(self.sent)?;
        self.sent += 1;
        Some((self.sent as u64 - 1, ray.into()))
    }

    fn receive(&mut self, number: u64, reply: &Reply) -> bool {
        if let Some(hit) = self.hits.get_mut(number as usize) {
            *hit = reply.into();
        }
        self.received += 1;
        !self.received.is_multiple_of(STRIDE) || (self.progress)(self.received)
    }
}
