//! The same operation with automatic staging.

use crate::{Near, Points};
use raypath::prelude::*;

/// Tests which of four points lie within a radius of a query point, staged automatically.
pub struct FirstCut;

impl Operation for FirstCut {
    const NAME: &'static str = "first_cut";
    type Input<C: Circuit> = Points<C>;
    type Output<C: Circuit> = Near<C>;
    type State<C: Circuit> = ();

    // ANCHOR: function
    fn run<C: Circuit>(&self, c: C, Points { query, radius, point }: Points<C>, _: ()) -> (Near<C>, ()) {
        c.auto();
        let limit = radius * radius;
        let squared_distance = point.map(|point| {
            let Vec3 { x, y, z } = point - query;
            x * x + y * y + z * z
        });
        let is_near = Flags(squared_distance.map(|square| square.compare(limit).less_or_equal()));
        (Near { is_near, squared_distance }, ())
    }
    // ANCHOR_END: function
}
