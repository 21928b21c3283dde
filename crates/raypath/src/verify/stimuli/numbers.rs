use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use raypath_float::Format;
use raypath_sim::numbers::edges;

/// Numbers of a format, by sort.
#[derive(Debug, Clone)]
pub struct Numbers {
    format: Format,
    edges: Vec<u64>,
    lattice: Vec<u64>,
}

/// Where numbers come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sort {
    /// Few small whole numbers: ties, cancellation to zero, flat boxes.
    Lattice,
    /// -1 to 1: rounding in every operation.
    Unit,
    /// Any exponent, most not so far from 1 that products always overflow or underflow.
    Wide,
    /// Zeros, subnormals, infinities, NaNs, the largest and the smallest; among whole numbers.
    Edges,
    /// Any bits.
    Raw,
}

impl Sort {
    /// One of them.
    pub fn random(rng: &mut ChaCha8Rng) -> Self {
        const ALL: [Sort; 8] =
            [Sort::Lattice, Sort::Unit, Sort::Wide, Sort::Wide, Sort::Edges, Sort::Edges, Sort::Edges, Sort::Raw];
        ALL[rng.random_range(0..ALL.len())]
    }
}

impl Numbers {
    /// Those of a format.
    pub fn of(format: Format) -> Self {
        let minus = 1 << (format.ieee_width() - 1);
        let mut all = edges(format).to_vec();
        // Of each its opposite, NaNs that are not the canonical one (one that signals, one with a payload), and what else
        // would come too seldom.
        all.extend([format.infinity() | 1, format.nan() | 1, format.infinity(), 1, format.nan()]);
        let opposites: Vec<u64> = all.iter().map(|edge| edge ^ minus).collect();
        all.extend(opposites);
        let lattice = [-4.0, -3.0, -2.0, -1.0, -0.5, -0.0, 0.0, 0.5, 1.0, 1.0, 2.0, 3.0, 4.0];
        Self { format, edges: all, lattice: lattice.map(|number| format.from_f32(number)).to_vec() }
    }

    /// The code of the nearest number.
    pub fn nearest(&self, number: f32) -> u64 {
        if self.format == Format::BINARY32 { number.to_bits().into() } else { self.format.from_f32(number) }
    }

    /// A number's code.
    pub fn draw(&self, sort: Sort, rng: &mut ChaCha8Rng) -> u64 {
        let format = self.format;
        match sort {
            Sort::Lattice => self.lattice[rng.random_range(0..self.lattice.len())],
            Sort::Edges if rng.random_bool(0.4) => self.edges[rng.random_range(0..self.edges.len())],
            Sort::Edges => self.lattice[rng.random_range(0..self.lattice.len())],
            Sort::Unit => self.nearest(rng.random_range(-1.0..=1.0_f64) as f32),
            Sort::Raw => rng.random::<u64>() >> (64 - format.ieee_width()),
            Sort::Wide => {
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
