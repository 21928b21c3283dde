//! An operation with state: the nearest of the distances since the first of a query.

use raypath::prelude::*;

// ANCHOR: operation
bundle! {
    /// A distance of a query.
    pub struct Distance<C> {
        /// The distance.
        pub distance: Num<C>,
        /// It is the first of its query.
        pub is_first: Bit<C>,
    }

    /// The nearest distance of the query so far.
    pub struct Nearest<C> {
        /// The distance.
        pub nearest: Num<C>,
    }

    /// What stays from job to job: a register. A reset sets it to zero.
    pub struct Kept<C> {
        /// The nearest distance.
        pub kept: Num<C>,
    }
}

/// The nearest of the distances since the first of a query.
pub struct NearestSoFar;

impl Operation for NearestSoFar {
    const NAME: &'static str = "nearest_so_far";
    type Input<C: Circuit> = Distance<C>;
    type Output<C: Circuit> = Nearest<C>;
    type State<C: Circuit> = Kept<C>;

    fn run<C: Circuit>(&self, c: C, input: Distance<C>, Kept { kept }: Kept<C>) -> (Nearest<C>, Kept<C>) {
        c.stage(5, "the nearer of the distance and what is kept");
        let is_nearer = input.is_first | input.distance.compare(kept).less();
        let nearest = is_nearer.select(input.distance, kept);
        (Nearest { nearest }, Kept { kept: nearest })
    }
}
// ANCHOR_END: operation
