//! How fast exact search is: `cargo run --release -p raypath-search --example speed`.
use raypath_search::{Exact, Metric, Vectors};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let base = Vectors::new(128, (0..128 * 20000).map(|i| ((i * 7919) % 1009) as f32).collect())?;
    let queries = Vectors::new(128, (0..128 * 200).map(|i| ((i * 104729) % 1013) as f32).collect())?;
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        for metric in Metric::ALL {
            let exact = Exact::<16, 8>::new(&base, metric);
            let answers = pool.install(|| exact.search(&queries, 10, &|_| true))?;
            println!("{threads} {metric}: {:.1} million/s", answers.work.evaluations as f64 / answers.seconds / 1e6);
        }
    }
    Ok(())
}
