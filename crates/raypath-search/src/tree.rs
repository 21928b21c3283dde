//! Vectors in trees of the unit.

use crate::unit::{UnitPlace, UnitSpec};
use crate::{SearchError, Vectors};
use raypath_traversal::search::{Elements, SearchMetric, order_of_boxes};

/// An error for what a tree does not have.
pub fn in_tree(spec: &UnitSpec<'_>) -> Result<(), SearchError> {
    let UnitSpec { base, metric, elements, place, unit, .. } = *spec;
    let (most, name) = if matches!(place, UnitPlace::Keys) { (1, "keys") } else { (3, "boxes") };
    let expects = |found: String, expected: String| {
        Err(SearchError::Parameter(format!("{found} in a tree of {name}, expected {expected}")))
    };
    if !unit.has_trees() {
        return Err(SearchError::Parameter("a unit without trees, expected one with --search trees=1".to_string()));
    }
    if base.dimensions() > most {
        let expected = if most == 1 { "1" } else { "1 to 3" };
        return expects(format!("{} dimensions", base.dimensions()), expected.to_string());
    }
    if metric != SearchMetric::Euclidean {
        return expects(format!("the metric {metric}"), SearchMetric::Euclidean.to_string());
    }
    if elements != Elements::Binary32 {
        return expects("elements of another kind".to_string(), "binary32".to_string());
    }
    match place {
        UnitPlace::Boxes(radius) if !(radius.is_finite() && radius >= 0.0) => {
            expects(format!("a radius of {radius}"), "a finite number of at least 0".to_string())
        }
        _ => Ok(()),
    }
}

/// The greatest rank of the vectors within a radius.
pub fn bound(place: UnitPlace<'_>) -> Option<f32> {
    if let UnitPlace::Boxes(radius) = place { Some(radius * radius) } else { None }
}

/// The order of vectors in a tree, and their numbers in it; none without a tree.
pub fn sorted(base: &Vectors, place: UnitPlace<'_>) -> Option<(Vec<u32>, Vec<f32>)> {
    let (dimensions, numbers) = (base.dimensions(), base.data());
    let order = match place {
        UnitPlace::All | UnitPlace::Graph(..) => return None,
        UnitPlace::Boxes(_) => order_of_boxes(&points(dimensions, numbers)),
        UnitPlace::Keys => {
            let mut order: Vec<u32> = (0..base.len() as u32).collect();
            order.sort_by(|a, b| numbers[*a as usize].total_cmp(&numbers[*b as usize]));
            order
        }
    };
    let row = |index: &u32| &numbers[*index as usize * dimensions..][..dimensions];
    let sorted = order.iter().flat_map(row).copied().collect();
    Some((order, sorted))
}

/// Vectors of up to three dimensions; the others are 0.
pub fn points(dimensions: usize, numbers: &[f32]) -> Vec<[f32; 3]> {
    let point = |row: &[f32]| std::array::from_fn(|axis| row.get(axis).copied().unwrap_or_default());
    numbers.chunks(dimensions).map(point).collect()
}

/// The words of queries of keys: -1, and as word 3 the greatest key below the range.
pub fn ranges(queries: &Vectors) -> Vec<f32> {
    queries.data().chunks(2).flat_map(|range| [-1.0, 0.0, 0.0, range[0].next_down()]).collect()
}
