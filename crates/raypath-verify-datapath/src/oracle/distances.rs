//! Distances between vectors, by ruling 7 of `docs/reference/semantics.md` and its sections on distances, sums that
//! round once, and accumulators.

use super::inputs::Inputs;
use super::mistake::Mistake;
use super::number::{Arithmetic, Number};
use raypath_ops::Rounding;

/// The sums of an angular distance.
#[derive(Debug, Clone)]
pub struct Sums {
    pub dot_product: Number,
    pub norm: Number,
}

/// All accumulators.
#[derive(Debug)]
pub struct Totals {
    euclidean: Vec<Number>,
    angular: Vec<Sums>,
}

impl Totals {
    /// This many accumulators of each operation, which are zero.
    pub fn new(count: usize) -> Self {
        let sums = Sums { dot_product: Number::ZERO, norm: Number::ZERO };
        Self { euclidean: vec![Number::ZERO; count], angular: vec![sums; count] }
    }

    /// Adds a beat, and returns the sum that includes it.
    pub fn euclidean(&mut self, arithmetic: &Arithmetic, rounding: Rounding, inputs: &Inputs) -> Number {
        let squares: Vec<Number> = (0..inputs.query.len())
            .map(|lane| {
                // The difference of a lane that is masked off can raise exceptions too.
                let difference = arithmetic.sub(&inputs.query[lane], &inputs.candidate[lane]);
                let difference = if is_on(arithmetic, inputs, lane) { difference } else { Number::ZERO };
                arithmetic.mul(&difference, &difference)
            })
            .collect();
        let beat = match rounding {
            Rounding::Unit => halved(arithmetic, squares),
            Rounding::Sum => {
                let (low, high) = squares.split_at(squares.len() / 2);
                arithmetic.add(&arithmetic.sum(low), &arithmetic.sum(high))
            }
        };
        let which = chosen(arithmetic, inputs);
        let sum = arithmetic.add(&self.euclidean[which], &beat);
        self.euclidean[which] = if restarts(arithmetic, inputs) { Number::ZERO } else { sum.clone() };
        sum
    }

    /// Adds a beat, and returns the sums that include it.
    pub fn angular(&mut self, arithmetic: &Arithmetic, rounding: Rounding, inputs: &Inputs) -> Sums {
        let products = |other: &[Number]| -> Vec<Number> {
            let lane = |lane: usize| {
                let is_on = is_on(arithmetic, inputs, lane);
                let number = |number: &Number| if is_on { number.clone() } else { Number::ZERO };
                arithmetic.mul(&number(&other[lane]), &number(&inputs.candidate[lane]))
            };
            (0..other.len()).map(lane).collect()
        };
        let beat = |products| match rounding {
            Rounding::Unit => halved(arithmetic, products),
            Rounding::Sum => arithmetic.sum(&products),
        };
        let which = chosen(arithmetic, inputs);
        let Sums { dot_product, norm } = &self.angular[which];
        let sums = Sums {
            dot_product: arithmetic.add(dot_product, &beat(products(&inputs.query))),
            norm: arithmetic.add(norm, &beat(products(&inputs.candidate))),
        };
        let restarted = Sums { dot_product: Number::ZERO, norm: Number::ZERO };
        self.angular[which] = if restarts(arithmetic, inputs) { restarted } else { sums.clone() };
        sums
    }
}

fn is_on(arithmetic: &Arithmetic, inputs: &Inputs, lane: usize) -> bool {
    inputs.mask >> lane & 1 == 1 || arithmetic.makes(Mistake::MasksIgnored)
}

fn chosen(arithmetic: &Arithmetic, inputs: &Inputs) -> usize {
    if arithmetic.makes(Mistake::OneAccumulator) { 0 } else { inputs.accumulator }
}

fn restarts(arithmetic: &Arithmetic, inputs: &Inputs) -> bool {
    inputs.is_last && !arithmetic.makes(Mistake::NeverRestarted)
}

/// The sum by halves: lane i adds lane i + n/2 until one lane remains.
fn halved(arithmetic: &Arithmetic, mut lanes: Vec<Number>) -> Number {
    while lanes.len() > 1 {
        let half = lanes.len() / 2;
        let pair = |i: usize| if arithmetic.makes(Mistake::Neighbours) { [2 * i, 2 * i + 1] } else { [i, i + half] };
        lanes = (0..half).map(|i| pair(i).map(|lane| &lanes[lane])).map(|[a, b]| arithmetic.add(a, b)).collect();
    }
    lanes.pop().unwrap_or(Number::ZERO)
}
