//! Distances between vectors, by ruling 7 of `docs/reference/semantics.md` and its sections on distances, sums that
//! round once, and accumulators.

use super::inputs::Inputs;
use super::mistake::Mistake;
use super::number::{Arithmetic, Number};
use raypath_ops::Rounding;

/// All accumulators: Euclidean sums, dot products and norms.
#[derive(Debug, Clone)]
pub struct Totals(Vec<[Number; 3]>);

impl Totals {
    /// This many accumulators of each sum, which are zero.
    pub fn new(count: usize) -> Self {
        Self(vec![[Number::ZERO; 3]; count])
    }

    /// Adds a beat, and returns the sum that includes it.
    pub fn euclidean(&mut self, arithmetic: &Arithmetic, rounding: Rounding, inputs: &Inputs) -> Number {
        let squares = |lane| {
            // The difference of a lane that is masked off can raise exceptions too.
            let difference = arithmetic.sub(inputs.query[lane], inputs.candidate[lane]);
            let difference = enabled(arithmetic, inputs, lane, difference);
            arithmetic.mul(difference, difference)
        };
        let squares: Vec<Number> = (0..inputs.query.len()).map(squares).collect();
        let beat = match rounding {
            Rounding::Unit => halved(arithmetic, squares),
            Rounding::Sum => {
                let (low, high) = squares.split_at(squares.len() / 2);
                arithmetic.add(arithmetic.sum(low), arithmetic.sum(high))
            }
        };
        self.add(0, arithmetic, inputs, beat)
    }

    /// Adds a beat, and returns the dot product and the norm that include it.
    pub fn angular(&mut self, arithmetic: &Arithmetic, rounding: Rounding, inputs: &Inputs) -> [Number; 2] {
        [(1, &inputs.query), (2, &inputs.candidate)].map(|(sum, other)| {
            let product = |lane| {
                let [a, b] = [other, &inputs.candidate].map(|of| enabled(arithmetic, inputs, lane, of[lane]));
                arithmetic.mul(a, b)
            };
            let products: Vec<Number> = (0..other.len()).map(product).collect();
            let beat = match rounding {
                Rounding::Unit => halved(arithmetic, products),
                Rounding::Sum => arithmetic.sum(&products),
            };
            self.add(sum, arithmetic, inputs, beat)
        })
    }

    fn add(&mut self, sum: usize, arithmetic: &Arithmetic, inputs: &Inputs, beat: Number) -> Number {
        let which = if arithmetic.makes(Mistake::OneAccumulator) { 0 } else { inputs.accumulator };
        let restarts = inputs.is_last && !arithmetic.makes(Mistake::NeverRestarted);
        let total = arithmetic.add(self.0[which][sum], beat);
        self.0[which][sum] = if restarts { Number::ZERO } else { total };
        total
    }
}

/// The number of a lane, zero if the lane is masked off.
fn enabled(arithmetic: &Arithmetic, inputs: &Inputs, lane: usize, number: Number) -> Number {
    let is_on = inputs.mask >> lane & 1 == 1 || arithmetic.makes(Mistake::MasksIgnored);
    if is_on { number } else { Number::ZERO }
}

/// The sum by halves: lane i adds lane i + n/2 until one lane remains.
fn halved(arithmetic: &Arithmetic, mut lanes: Vec<Number>) -> Number {
    while lanes.len() > 1 {
        let half = lanes.len() / 2;
        let is_other = arithmetic.makes(Mistake::Neighbours);
        let pair = |i: usize| if is_other { [2 * i, 2 * i + 1] } else { [i, i + half] };
        lanes = (0..half).map(|i| pair(i).map(|lane| lanes[lane])).map(|[a, b]| arithmetic.add(a, b)).collect();
    }
    lanes.pop().unwrap_or(Number::ZERO)
}
