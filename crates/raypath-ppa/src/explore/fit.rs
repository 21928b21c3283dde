//! A linear fit with errors of its predictions.

use serde::Serialize;

/// The terms of a quantity: it is expected to be `known` and a linear function of `terms`. They are in the unit of the
/// quantity by a rough estimate, so that the coefficients are near 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Terms {
    /// The part that is known.
    pub known: f64,
    /// What the rest is a linear function of.
    pub terms: Vec<f64>,
}

/// A least-squares fit of a positive quantity. An observation weighs by the inverse of its square, so that the fit is
/// one of relative errors.
#[derive(Debug)]
pub(super) struct Fit {
    coefficients: Vec<f64>,
    /// The inverse of the normal matrix.
    inverse: Vec<Vec<f64>>,
    /// The largest value of each term, by which it is divided.
    scales: Vec<f64>,
    /// The relative error that a prediction has in the middle of the observations.
    error: f64,
}

/// A prediction with its error: with 95 % confidence, the value differs by at most `error`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Predicted {
    /// The expected value.
    pub value: f64,
    /// Infinite without a fit.
    pub error: f64,
}

/// Student's t for a two-sided confidence of 95 %, by degrees of freedom from 1.
const T: [f64; 10] = [12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26, 2.23];
const T_LARGE: f64 = 2.1;

/// Keeps the normal matrix invertible if terms depend on each other. An observation counts as 1 there.
const RIDGE: f64 = 1e-9;

impl Terms {
    /// The quantity by the rough estimate.
    pub fn rough(&self) -> f64 {
        self.known + self.terms.iter().sum::<f64>()
    }
}

impl Fit {
    /// Fits observations. The relative error is at least `noise`, that of a measurement. None if there are not more
    /// observations than terms.
    pub fn new(observations: &[(&Terms, f64)], noise: f64) -> Option<Self> {
        let count = observations.first()?.0.terms.len();
        let free = observations.len().checked_sub(count).filter(|free| *free > 0)?;
        let largest = |term: usize| {
            let values = observations.iter().map(|(terms, value)| (terms.terms[term] / value).abs());
            let largest = values.fold(0.0, f64::max);
            if largest > 0.0 { largest } else { 1.0 }
        };
        let scales: Vec<f64> = (0..count).map(largest).collect();
        let mut normal = vec![vec![0.0; count]; count];
        let mut sums = vec![0.0; count];
        for (terms, value) in observations {
            let row = scaled(terms, &scales, *value);
            let rest = (value - terms.known) / value;
            for i in 0..count {
                sums[i] += row[i] * rest;
                (0..count).for_each(|j| normal[i][j] += row[i] * row[j]);
            }
        }
        (0..count).for_each(|i| normal[i][i] += RIDGE);
        let inverse = inverse(normal)?;
        let product = |row: &Vec<f64>| row.iter().zip(&sums).map(|(a, b)| a * b).sum();
        let mut fit = Self { coefficients: inverse.iter().map(product).collect(), inverse, scales, error: 0.0 };
        let residual = |(terms, value): &(&Terms, f64)| (fit.value(terms) / value - 1.0).powi(2);
        let variance = observations.iter().map(residual).sum::<f64>() / free as f64;
        fit.error = T.get(free - 1).unwrap_or(&T_LARGE) * variance.sqrt().max(noise / 2.0);
        Some(fit)
    }

    /// Predicts a quantity.
    pub fn predict(&self, terms: &Terms) -> Predicted {
        let value = self.value(terms);
        let row = scaled(terms, &self.scales, value);
        let spread: f64 = self.inverse.iter().zip(&row).map(|(line, a)| a * dot(line, &row)).sum();
        Predicted { value, error: self.error * (1.0 + spread).sqrt() * value.abs() }
    }

    fn value(&self, terms: &Terms) -> f64 {
        terms.known + dot(&self.coefficients, &scaled(terms, &self.scales, 1.0))
    }
}

/// The terms divided by their scales and by a value.
fn scaled(terms: &Terms, scales: &[f64], value: f64) -> Vec<f64> {
    terms.terms.iter().zip(scales).map(|(term, scale)| term / scale / value).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The inverse of a matrix, by Gauss and Jordan with pivots.
fn inverse(mut matrix: Vec<Vec<f64>>) -> Option<Vec<Vec<f64>>> {
    let count = matrix.len();
    for (place, row) in matrix.iter_mut().enumerate() {
        row.extend((0..count).map(|column| if column == place { 1.0 } else { 0.0 }));
    }
    for column in 0..count {
        let pivot = (column..count).max_by(|&a, &b| matrix[a][column].abs().total_cmp(&matrix[b][column].abs()))?;
        matrix.swap(column, pivot);
        let divisor = matrix[column][column];
        if divisor.abs() < f64::MIN_POSITIVE || !divisor.is_finite() {
            return None;
        }
        matrix[column].iter_mut().for_each(|value| *value /= divisor);
        let line = matrix[column].clone();
        for (_, row) in matrix.iter_mut().enumerate().filter(|(row, _)| *row != column) {
            let factor = row[column];
            row.iter_mut().zip(&line).for_each(|(value, pivot)| *value -= factor * pivot);
        }
    }
    Some(matrix.into_iter().map(|row| row[count..].to_vec()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn terms(known: f64, terms: &[f64]) -> Terms {
        Terms { known, terms: terms.to_vec() }
    }

    /// Points on a plane are predicted exactly, up to the noise that was stated.
    #[test]
    fn a_plane_is_found() {
        let inputs: Vec<Terms> = (0..8).map(|i| terms(10.0, &[f64::from(i * i), f64::from(i), 1.0])).collect();
        let plane = |terms: &Terms| terms.known + 3.0 * terms.terms[0] + 5.0 * terms.terms[1] + 7.0;
        let observations: Vec<(&Terms, f64)> = inputs.iter().map(|terms| (terms, plane(terms))).collect();
        let fit = Fit::new(&observations, 0.01).expect("enough observations");
        let new = terms(20.0, &[30.0, 4.0, 1.0]);
        let found = fit.predict(&new);
        assert!((found.value - plane(&new)).abs() < 1e-3, "{found:?}");
        assert!(found.error > 0.005 * found.value && found.error < 0.1 * found.value, "{found:?}");
        assert!(Fit::new(&observations[..3], 0.01).is_none());
    }

    /// The mean of numbers: the confidence interval of Student's t, computed by hand. 9, 10, 11 have the relative
    /// residuals of their weighted mean.
    #[test]
    fn the_error_is_that_of_students_t() {
        let one = terms(0.0, &[1.0]);
        let values = [9.0, 10.0, 11.0];
        let observations: Vec<(&Terms, f64)> = values.iter().map(|value| (&one, *value)).collect();
        let found = Fit::new(&observations, 0.0).expect("enough").predict(&one);
        let weight: f64 = values.iter().map(|value| value.powi(-2)).sum();
        let mean = values.iter().map(|value| value.powi(-1)).sum::<f64>() / weight;
        let variance = values.iter().map(|value| (mean / value - 1.0).powi(2)).sum::<f64>() / 2.0;
        let error = 4.30 * variance.sqrt() * (1.0 + 1.0 / (weight * mean * mean)).sqrt() * mean;
        assert!((found.value - mean).abs() < 1e-6 && (found.error - error).abs() < 1e-6, "{found:?} {mean} {error}");
    }

    /// Away from the observations, and in a direction in which they do not differ, the error is large.
    #[test]
    fn what_was_not_observed_is_uncertain() {
        let inputs: Vec<Terms> = (1..9).map(|i| terms(0.0, &[f64::from(i), 1.0, 0.0])).collect();
        let observations: Vec<(&Terms, f64)> = inputs.iter().zip([1.0, 2.1, 2.9, 4.0, 5.2, 5.9, 7.0, 8.1]).collect();
        let fit = Fit::new(&observations, 0.01).expect("enough");
        let [near, far, other] =
            [[5.0, 1.0, 0.0], [80.0, 1.0, 0.0], [5.0, 1.0, 1.0]].map(|at| fit.predict(&terms(0.0, &at)));
        assert!(far.error / far.value > near.error / near.value, "{near:?} {far:?}");
        assert!(other.error > 100.0 * near.error, "{near:?} {other:?}");
    }
}
