use crate::{Metric, Vectors};
use raypath_ops::{Beat, BeatInput, Binary32, Job, VectorError};

/// The jobs that compare each vector of a base with all queries, in a datapath of `E` Euclidean and `A` angular lanes.
/// Without norms of queries.
///
/// # Errors
/// Queries of another dimension than the base.
pub fn distance_jobs<const E: usize, const A: usize>(
    base: &Vectors,
    queries: &Vectors,
    metric: Metric,
) -> Result<Vec<Job<E, A>>, VectorError> {
    let mut jobs = Vec::new();
    for vector in base.iter() {
        for query in queries.iter() {
            match metric {
                Metric::Euclidean => jobs.extend(Beat::of(query, vector)?.map(|beat| Job::Euclidean(input(beat)))),
                Metric::Angular => jobs.extend(Beat::of(query, vector)?.map(|beat| Job::Angular(input(beat)))),
            }
        }
    }
    Ok(jobs)
}

fn input<const N: usize>(euclidean: Beat<Binary32, N>) -> BeatInput<Binary32, N> {
    BeatInput { euclidean }
}
