//! Pareto fronts.

/// Whether costs are nowhere above others, and somewhere below.
pub(super) fn dominates(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| a <= b) && a.iter().zip(b).any(|(a, b)| a < b)
}

/// How many of the costs dominate these.
pub(super) fn dominators<'c>(costs: &[f64], all: impl IntoIterator<Item = &'c Vec<f64>>) -> usize {
    all.into_iter().filter(|other| dominates(other, costs)).count()
}
