//! Rates of rays and distances: rays on one core, compared with obvhs; distances on one core and on all cores.

use crate::commands::full::bench::result::Results;
use crate::error::CliError;
use raypath_render::compare::compare;
use raypath_render::{Camera, Scene, Tracing, builtin};
use raypath_search::{Clusters, Exact, Metric};

/// Measures closest hits in the built-in scene on one core, compared with obvhs' traversal of the same tree.
pub fn rays(results: &mut Results, repetitions: usize) -> Result<(), CliError> {
    let scene = Scene::new(builtin().map_err(CliError::unusable)?).map_err(CliError::unusable)?;
    const SIZE: (u32, u32) = (256, 192);
    let camera = Camera::framing(scene.mesh(), SIZE.0 as f32 / SIZE.1 as f32);
    let rays = camera.rays(SIZE.0, SIZE.1).map_err(CliError::unusable)?;
    for two_sided in [false, true] {
        let tracing = Tracing { two_sided, ..Tracing::default() };
        let compared =
            compare(&scene, &rays, tracing, repetitions.div_ceil(4) as u32, &|_| true).map_err(CliError::unusable)?;
        let per_second = compared.nanoseconds().map(|nanoseconds| 1e9 / nanoseconds);
        let (what, unit) = if two_sided { ("two-sided", "rays both sides") } else { ("one-sided", "rays") };
        // obvhs tests both sides at no cost. The goal is a third of its rate.
        results.rate(
            format!("rays from the eye, built-in scene, {what}, one core"),
            unit,
            per_second[0],
            Some(per_second[1] / 3.0),
        );
        results.beside(unit, "obvhs", per_second[1]);
    }
    Ok(())
}

/// Measures exact search, on one core and on all cores.
pub fn distances(results: &mut Results, repetitions: usize) -> Result<(), CliError> {
    let queries = 32 * repetitions.div_ceil(5);
    let clusters = Clusters { vectors: 20_000, queries, dimensions: 128, ..Clusters::default() };
    let set = clusters.generate().map_err(CliError::unusable)?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    for metric in Metric::ALL {
        let exact = Exact::new(&set.base, metric);
        for threads in [1, cores] {
            let mut best = 0.0f64;
            for _ in 0..repetitions.div_ceil(8) {
                best = best.max(exact.distances_per_second(&set.queries, threads).map_err(CliError::unusable)?);
            }
            let what = format!("exact search, 128 dimensions, {metric}, {threads} threads");
            results.rate(what, "distances", best, None);
        }
    }
    Ok(())
}
