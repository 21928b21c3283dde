//! Times exact search and a graph's, and says how fast that went: `search_timing [VECTORS] [IN_FLIGHT]`.

use raypath_search::{Candidates, Clusters, Exact, Graph, GraphParameters, Metric, Subject, sweep_search, time_search};
use raypath_timing::{Hardware, Machine, Sample};
use std::error::Error;
use std::time::Instant;

/// The most beats of a run.
const BEATS: u64 = 10_000_000;

fn main() -> Result<(), Box<dyn Error>> {
    let mut numbers = std::env::args().skip(1).map(|number| number.parse::<usize>());
    let (vectors, in_flight) = (numbers.next().unwrap_or(Ok(10_000))?, numbers.next().unwrap_or(Ok(32))?);
    let data = Clusters { vectors, queries: 1000, ..Clusters::default() }.generate()?;
    let (base, queries, go_on) = (&data.base, &data.queries, &|_| true);
    let hardware = Hardware { machine: Machine { in_flight, ..Machine::default() }, ..Hardware::default() };
    for metric in Metric::ALL {
        let graph = Graph::<16, 8>::build(base, metric, &GraphParameters::default(), go_on)?;
        let logs = graph.logs(queries, 10, 100, BEATS, go_on)?;
        let exact = Exact::<16, 8>::new(base, metric).search(queries, 10, go_on)?.rows;
        let through = graph.search(queries, 10, 100, go_on)?.rows;
        for (name, candidates, rows) in
            [("exact", Candidates::All { count: 10 }, exact), ("graph", Candidates::Logged(&logs), through)]
        {
            let subject = Subject { base, queries, metric, candidates };
            let sample = subject.within::<16, 8>(BEATS);
            let start = Instant::now();
            let (timing, timed) = time_search::<16, 8>(&subject, sample, &hardware, &mut (), go_on)?;
            let seconds = start.elapsed().as_secs_f64();
            println!(
                "{metric} {name}: {} queries, {} cycles, {:.3} beats a cycle; {:.1} million beats a second simulated; \
                 same neighbours: {}",
                timing.agents,
                timing.cycles,
                timing.jobs_per_cycle(),
                timing.all_jobs() as f64 / seconds / 1e6,
                timed == rows[..timed.len()],
            );
            let (start, sample) = (Instant::now(), Sample { most: sample.most.min(100), ..sample });
            let sweep = sweep_search::<16, 8>(&subject, sample, &[1, 8, 64], &[0, 100, 400], &hardware, go_on)?;
            println!("  sweep over {} points in {:.2?}", sweep.points.len(), start.elapsed());
        }
    }
    Ok(())
}
