//! The references of the benchmark: the same jobs in Rust, on one thread.

use crate::array::items;
use crate::error::{exception, value_error};
use pyo3::prelude::*;
use raypath_embed::{Bounds, Datapath, QuadboxResult, Ray, TriangleResult, Vertices};
use raypath_model::{BLOCK, Batch, Packed, blank, pack, unpack};
use raypath_ops::{
    Beat, BeatInput, Binary32, EuclideanOutput, Family, Flags, Of, RayBoxInput, RayBoxOutput, RayTriangleInput,
    RayTriangleOutput, Rules,
};
use std::convert::Infallible;
use std::hint::black_box;
use std::time::Instant;

/// The jobs that are packed at once: those and their outcomes fit into a second-level cache.
const CHUNK: usize = 256;

/// The shortest times in seconds in which Rust computes the jobs of an operation on one thread.
///
/// Args:
///     operation: "quadbox", "triangle" or "euclidean".
///     first: the rays of n jobs, or a float32 array of shape (n, 16).
///     second: the boxes, the triangles, or a float32 array of shape (n, 16).
///     repetitions: the number of measurements.
///
/// Returns:
///     Three times: of ``raypath_model::pack``, ``Batch`` and ``unpack`` for jobs in the types of ``raypath_ops``, in
///     chunks that fit into the cache; of ``Batch`` alone, for blocks of jobs that are packed in memory before; of
///     ``raypath_embed`` for the given arrays. The first and the third include the allocation of their results.
#[pyfunction]
pub fn rust_seconds(
    py: Python<'_>,
    operation: &str,
    first: &Bound<'_, PyAny>,
    second: &Bound<'_, PyAny>,
    repetitions: usize,
) -> PyResult<(f64, f64, f64)> {
    let datapath = Datapath::open("", &[]).map_err(exception)?;
    let mut batch = Batch::<16, 8>::new(Rules::Paper);
    match operation {
        "quadbox" => {
            let (rays, boxes) = (items::<Ray>(first, "first")?, items::<[Bounds; 4]>(second, "second")?);
            let (rays, boxes) = (&*rays, &*boxes);
            let job = |(ray, boxes): (&Ray, &[Bounds; 4])| RayBoxInput {
                ray: ray.into(),
                aabb: boxes.each_ref().map(Into::into),
            };
            py.detach(|| {
                let jobs: Vec<_> = rays.iter().zip(boxes).map(job).collect();
                let run = |jobs: &_, answers: &mut _| batch.quadbox(jobs, answers);
                let (chunks, blocks) =
                    batches::<RayBoxInput<Binary32>, RayBoxOutput<Binary32>>(&jobs, repetitions, run);
                let arrays = shortest(repetitions, || {
                    let mut results = vec![QuadboxResult::default(); rays.len()];
                    datapath.quadbox(rays, boxes, &mut results).map(|()| drop(black_box(results)))
                });
                arrays.map(|arrays| (chunks, blocks, arrays))
            })
        }
        "triangle" => {
            let (rays, triangles) = (items::<Ray>(first, "first")?, items::<Vertices>(second, "second")?);
            let (rays, triangles) = (&*rays, &*triangles);
            let job =
                |(ray, triangle): (&Ray, &Vertices)| RayTriangleInput { ray: ray.into(), triangle: triangle.into() };
            py.detach(|| {
                let jobs: Vec<_> = rays.iter().zip(triangles).map(job).collect();
                let run = |jobs: &_, answers: &mut _| batch.triangle(jobs, answers);
                let (chunks, blocks) =
                    batches::<RayTriangleInput<Binary32>, RayTriangleOutput<Binary32>>(&jobs, repetitions, run);
                let arrays = shortest(repetitions, || {
                    let mut results = vec![TriangleResult::default(); rays.len()];
                    datapath.triangle(rays, triangles, &mut results).map(|()| drop(black_box(results)))
                });
                arrays.map(|arrays| (chunks, blocks, arrays))
            })
        }
        "euclidean" => {
            let (a, b) = (items::<[f32; 16]>(first, "first")?, items::<[f32; 16]>(second, "second")?);
            let (a, b) = (&*a, &*b);
            let job = |(a, b): (&[f32; 16], &[f32; 16])| {
                let (a, b) = (a.map(Into::into), b.map(Into::into));
                BeatInput { euclidean: Beat { a, b, mask: Flags::from_mask(u64::MAX), reset_accum: true.into() } }
            };
            py.detach(|| {
                let jobs: Vec<_> = a.iter().zip(b).map(job).collect();
                let run = |jobs: &_, answers: &mut _| batch.euclidean(jobs, answers);
                let (chunks, blocks) =
                    batches::<BeatInput<Binary32, 16>, EuclideanOutput<Binary32>>(&jobs, repetitions, run);
                let arrays = shortest(repetitions, || {
                    let mut results = vec![0.0; a.len()];
                    let done = datapath.euclidean(a.as_flattened(), b.as_flattened(), 16, &mut results);
                    done.map(|()| drop(black_box(results)))
                });
                arrays.map(|arrays| (chunks, blocks, arrays))
            })
        }
        other => {
            return Err(value_error(format!("operation: found '{other}', expected quadbox, triangle or euclidean")));
        }
    }
    .map_err(exception)
}

/// The times of batches in chunks from jobs to outcomes, and of blocks in memory.
fn batches<I: Family, O: Family>(
    jobs: &[Of<I, Binary32>],
    repetitions: usize,
    mut run: impl FnMut(&[Of<I, Packed>], &mut [Of<O, Packed>]),
) -> (f64, f64) {
    let chunks = shortest(repetitions, || {
        let mut outcomes = Vec::with_capacity(jobs.len());
        let mut answers = vec![blank::<O>(); CHUNK.div_ceil(BLOCK)];
        for jobs in jobs.chunks(CHUNK) {
            run(&pack::<I>(jobs), &mut answers);
            outcomes.extend(unpack::<O>(&answers, jobs.len()));
        }
        drop(black_box(outcomes));
        Ok::<(), Infallible>(())
    });
    let blocks = pack::<I>(jobs);
    let mut answers = vec![blank::<O>(); blocks.len()];
    let packed = shortest(repetitions, || {
        run(black_box(&blocks), black_box(&mut answers));
        Ok::<(), Infallible>(())
    });
    match (chunks, packed) {
        (Ok(chunks), Ok(packed)) => (chunks, packed),
    }
}

/// The shortest time of several runs, or the first error.
fn shortest<E>(repetitions: usize, mut work: impl FnMut() -> Result<(), E>) -> Result<f64, E> {
    let mut shortest = f64::INFINITY;
    for _ in 0..repetitions.max(1) {
        let begin = Instant::now();
        work()?;
        shortest = shortest.min(begin.elapsed().as_secs_f64());
    }
    Ok(shortest)
}
