//! How fast exact search is, on one core and on all: `cargo run --release -p raypath-search --example speed`.

use raypath_search::{Clusters, Metric, SearchError, speed};

fn main() -> Result<(), SearchError> {
    let data = Clusters { vectors: 20_000, queries: 500, ..Clusters::default() }.generate()?;
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    for metric in Metric::ALL {
        for threads in [1, all] {
            let speed = speed::<16, 8>(&data.base, &data.queries, metric, threads)?;
            println!(
                "{metric}, {} dimensions, {threads} threads: {:.1} million distances/s, {:.1} million beats/s",
                data.base.dimensions(),
                speed.distances_per_second / 1e6,
                speed.beats_per_second / 1e6,
            );
        }
    }
    Ok(())
}
