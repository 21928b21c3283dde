//! Random numbers of a format.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_float::Format;
use raypath_sim::numbers::edges;

/// Random numbers of a format, by class.
#[derive(Debug, Clone)]
pub struct Numbers {
    format: Format,
    edges: Vec<u64>,
    lattice: Vec<u64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NumberClass {
    /// A few small integers and halves: ties, cancellation to zero, flat boxes.
    Lattice,
    /// Uniform in -1 to 1: every operation rounds.
    Unit,
    /// Any exponent, mostly near enough to 1 that products do not always overflow or underflow.
    Wide,
    /// Zeros, subnormals, infinities, NaNs, the largest and the smallest numbers, among small integers.
    Edges,
    /// Any bits.
    Raw,
}

impl NumberClass {
    pub fn random(rng: &mut ChaCha8Rng) -> Self {
        match rng.random_range(0..8_usize) {
            0 => Self::Lattice,
            1 => Self::Unit,
            2 | 3 => Self::Wide,
            4..7 => Self::Edges,
            _ => Self::Raw,
        }
    }
}

impl Numbers {
    pub fn of(format: Format) -> Self {
        let minus = 1 << (format.ieee_width() - 1);
        let mut all = edges(format).to_vec();
        // Also the opposite of each, a signalling NaN and a NaN with a payload, and more of the rarer ones.
        all.extend([format.infinity() | 1, format.nan() | 1, format.infinity(), 1, format.nan()]);
        let opposites: Vec<u64> = all.iter().map(|edge| edge ^ minus).collect();
        all.extend(opposites);
        let lattice = [-4.0, -3.0, -2.0, -1.0, -0.5, -0.0, 0.0, 0.5, 1.0, 1.0, 2.0, 3.0, 4.0];
        Self { format, edges: all, lattice: lattice.map(|number| format.from_f32(number)).to_vec() }
    }

    pub fn nearest(&self, number: f32) -> u64 {
        if self.format == Format::BINARY32 { number.to_bits().into() } else { self.format.from_f32(number) }
    }

    /// The word of a random number of this class.
    pub fn draw(&self, class: NumberClass, rng: &mut ChaCha8Rng) -> u64 {
        let format = self.format;
        match class {
            NumberClass::Lattice => self.lattice[rng.random_range(0..self.lattice.len())],
            NumberClass::Edges if rng.random_bool(0.4) => self.edges[rng.random_range(0..self.edges.len())],
            NumberClass::Edges => self.lattice[rng.random_range(0..self.lattice.len())],
            NumberClass::Unit => self.nearest(rng.random_range(-1.0..=1.0_f64) as f32),
            NumberClass::Raw => rng.random::<u64>() >> (64 - format.ieee_width()),
            NumberClass::Wide => {
                let bits = rng.random::<u64>() >> (64 - format.ieee_width());
                let exponents = 1u64 << format.exponent();
                let near = exponents / 4..exponents - exponents / 4;
                let exponent =
                    if rng.random_bool(0.02) { rng.random_range(0..exponents) } else { rng.random_range(near) };
                let field = (exponents - 1) << format.fraction_width();
                bits & !field | exponent << format.fraction_width()
            }
        }
    }
}
