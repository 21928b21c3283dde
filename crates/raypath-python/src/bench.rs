//! The reference of the benchmark: the same jobs in Rust.

use crate::array::items;
use crate::error::value_error;
use pyo3::prelude::*;
use raypath_embed::{Bounds, Ray, Vertices};
use raypath_model::{Batch, Packed, blank, pack, unpack};
use raypath_ops::{
    Beat, BeatInput, Binary32, EuclideanOutput, Family, Flags, Of, RayBoxInput, RayBoxOutput, RayTriangleInput,
    RayTriangleOutput, Rules,
};
use std::hint::black_box;
use std::time::Instant;

/// The jobs that are packed at once: those and their outcomes fit into a second-level cache.
const CHUNK: usize = 256;

/// The shortest time in seconds in which Rust computes the jobs of an operation on one thread.
///
/// The jobs are in the types of ``raypath_ops`` before the measurement. It measures ``raypath_model::pack``, ``Batch``
/// and ``unpack``, in chunks that fit into the cache.
///
/// Args:
///     operation: "quadbox", "triangle" or "euclidean".
///     first: the rays of n jobs, or float32 array of shape (n, 16).
///     second: the boxes, the triangles, or float32 array of shape (n, 16).
///     repetitions: the number of measurements.
#[pyfunction]
pub fn rust_batch_seconds(
    py: Python<'_>,
    operation: &str,
    first: &Bound<'_, PyAny>,
    second: &Bound<'_, PyAny>,
    repetitions: usize,
) -> PyResult<f64> {
    match operation {
        "quadbox" => {
            let pairs = items::<Ray>(first, "first")?.iter().zip(items::<[Bounds; 4]>(second, "second")?);
            let job = |(ray, boxes): (&Ray, &[Bounds; 4])| RayBoxInput {
                ray: ray.into(),
                aabb: boxes.each_ref().map(Into::into),
            };
            let jobs: Vec<_> = pairs.map(job).collect();
            let batch = Batch::<16, 8>::new(Rules::Paper);
            let run = |jobs: &_, answers: &mut _| batch.quadbox(jobs, answers);
            Ok(py.detach(|| shortest::<RayBoxInput<Binary32>, RayBoxOutput<Binary32>>(&jobs, repetitions, run)))
        }
        "triangle" => {
            let pairs = items::<Ray>(first, "first")?.iter().zip(items::<Vertices>(second, "second")?);
            let job =
                |(ray, triangle): (&Ray, &Vertices)| RayTriangleInput { ray: ray.into(), triangle: triangle.into() };
            let jobs: Vec<_> = pairs.map(job).collect();
            let batch = Batch::<16, 8>::new(Rules::Paper);
            let run = |jobs: &_, answers: &mut _| batch.triangle(jobs, answers);
            Ok(py.detach(|| {
                shortest::<RayTriangleInput<Binary32>, RayTriangleOutput<Binary32>>(&jobs, repetitions, run)
            }))
        }
        "euclidean" => {
            let pairs = items::<[f32; 16]>(first, "first")?.iter().zip(items::<[f32; 16]>(second, "second")?);
            let job = |(a, b): (&[f32; 16], &[f32; 16])| {
                let (a, b) = (a.map(Into::into), b.map(Into::into));
                BeatInput { euclidean: Beat { a, b, mask: Flags::from_mask(u64::MAX), reset_accum: true.into() } }
            };
            let jobs: Vec<_> = pairs.map(job).collect();
            let mut batch = Batch::<16, 8>::new(Rules::Paper);
            let run = |jobs: &_, answers: &mut _| batch.euclidean(jobs, answers);
            Ok(py.detach(|| shortest::<BeatInput<Binary32, 16>, EuclideanOutput<Binary32>>(&jobs, repetitions, run)))
        }
        other => Err(value_error(format!("operation: found '{other}', expected quadbox, triangle or euclidean"))),
    }
}

fn shortest<I: Family, O: Family>(
    jobs: &[Of<I, Binary32>],
    repetitions: usize,
    mut run: impl FnMut(&[Of<I, Packed>], &mut [Of<O, Packed>]),
) -> f64 {
    let mut once = || {
        let begin = Instant::now();
        let mut outcomes = Vec::with_capacity(jobs.len());
        let mut answers = vec![blank::<O>(); CHUNK.div_ceil(raypath_model::BLOCK)];
        for jobs in jobs.chunks(CHUNK) {
            let blocks = pack::<I>(jobs);
            run(&blocks, &mut answers);
            outcomes.extend(unpack::<O>(&answers, jobs.len()));
        }
        black_box(&outcomes);
        begin.elapsed().as_secs_f64()
    };
    (0..repetitions.max(1)).map(|_| once()).fold(f64::INFINITY, f64::min)
}
