//! The growth of cost with the number of items: nanoseconds per item, which are constant if the cost grows linearly.

use crate::commands::full::bench::models::each;
use crate::commands::full::bench::result::{Results, seconds};
use crate::commands::full::bench::workload::Workload;
use crate::error::CliError;
use raypath_model::Functional;
use raypath_ops::Rules;
use raypath_render::{Camera, Scene, Tracing, builtin, trace_closest};
use raypath_search::{Clusters, Exact, Metric};
use std::hint::black_box;

/// Measures jobs, rays and vectors, from 1,000 to 100,000 of each.
pub fn run(results: &mut Results, repetitions: usize) -> Result<(), CliError> {
    let repetitions = repetitions.div_ceil(8);
    let jobs = Workload::new().mixed(100_000);
    let mut model = Functional::<16, 8>::new(Rules::Paper);
    results.growth(
        "mixed jobs through the functional model",
        points([1_000, 10_000, 100_000], |count| seconds(repetitions, || each(&mut model, &jobs[..count]))),
    );

    let scene = Scene::new(builtin().map_err(CliError::unusable)?).map_err(CliError::unusable)?;
    let in_rows = Camera::framing(scene.mesh(), 1.0).rays(400, 250).map_err(CliError::unusable)?;
    // The rays are reordered, so that any first part is a sample of the whole picture.
    let rays: Vec<_> = (0..in_rows.len()).map(|i| in_rows[i * 7919 % in_rows.len()]).collect();
    let mut stopped = false;
    results.growth(
        "rays from the eye, built-in scene, all cores",
        points([1_000, 10_000, 100_000], |count| {
            seconds(repetitions, || {
                stopped |= trace_closest(&scene, &rays[..count], Tracing::default(), &|_| true).map(black_box).is_err();
            })
        }),
    );

    let clusters = Clusters { vectors: 100_000, queries: 16, dimensions: 64, ..Clusters::default() };
    let set = clusters.generate().map_err(CliError::unusable)?;
    let mut growth = Vec::new();
    for count in [1_000usize, 10_000, 100_000] {
        let data = set.base.data()[..count * set.base.dimensions()].to_vec();
        let base = raypath_search::Vectors::new(set.base.dimensions(), data).map_err(CliError::unusable)?;
        let exact = Exact::new(&base, Metric::Euclidean);
        let time = seconds(repetitions, || {
            stopped |= exact.search(&set.queries, 10, &|_| true).map(black_box).is_err();
        });
        growth.push((count as u64, 1e9 * time / (count * set.queries.len()) as f64));
    }
    results.growth("vectors in exact search, 64 dimensions, Euclidean, all cores", growth);
    if stopped { Err(CliError::unusable("the work stopped although nothing stops it")) } else { Ok(()) }
}

/// Each count with its nanoseconds per item. `time` returns the seconds of a count.
fn points(counts: [usize; 3], mut time: impl FnMut(usize) -> f64) -> Vec<(u64, f64)> {
    counts.into_iter().map(|count| (count as u64, 1e9 * time(count) / count as f64)).collect()
}
