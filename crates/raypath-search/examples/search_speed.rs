//! How fast exact search is, on one core and on all: `cargo run --release -p raypath-search --example search_speed`.

use raypath_search::{Clusters, Metric, SearchError, Speed, speed};

/// The best of so many short runs counts, as other programs only ever make one slower.
const RUNS: usize = 40;

fn main() -> Result<(), SearchError> {
    let data = Clusters { vectors: 20_000, queries: 64, ..Clusters::default() }.generate()?;
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    for metric in Metric::ALL {
        for threads in [1, all] {
            let run = |_| speed::<16, 8>(&data.base, &data.queries, metric, threads);
            let runs = (0..RUNS).map(run).collect::<Result<Vec<Speed>, _>>()?;
            let best = |of: fn(&Speed) -> f64| runs.iter().map(of).fold(0.0, f64::max) / 1e6;
            println!(
                "{metric}, {} dimensions, {threads} threads: {:.1} million distances/s, {:.1} million beats/s",
                data.base.dimensions(),
                best(|speed| speed.distances_per_second),
                best(|speed| speed.beats_per_second),
            );
        }
    }
    Ok(())
}
