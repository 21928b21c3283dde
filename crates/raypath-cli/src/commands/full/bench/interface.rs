//! Rates of the C interface beside those of the Rust models on the same jobs. The functions are those that a C program
//! calls; the compiler does not inline them, because they are in another crate.

#![allow(unsafe_code)] // the calls of the C interface

use crate::commands::full::bench::models::{cycle_exact_rate, mixed_jobs};
use crate::commands::full::bench::result::{Results, seconds};
use crate::commands::full::bench::workload::Workload;
use crate::error::CliError;
use raypath_capi as c;
use raypath_model::{Batch, Packed, blank, pack, unpack};
use raypath_ops::{
    Aabb, Beat, BeatInput, Binary32, EuclideanOutput, Family, Job, Num, Of, Ray, RayBoxInput, RayBoxOutput,
    RayTriangleInput, RayTriangleOutput, Rules, Slab, Vec3,
};
use std::ffi::CStr;
use std::hint::black_box;
use std::ptr::{null, null_mut};

/// The jobs of an array: more than a first-level cache holds.
const JOBS: usize = 4096;
/// The share of the Rust models' rate that is the goal, for arrays and for cycles.
const GOALS: (f64, f64) = (0.95, 0.8);

/// Measures arrays of jobs and the pipeline.
pub fn run(results: &mut Results, repetitions: usize) -> Result<(), CliError> {
    let datapath = Open::new()?;
    arrays(&datapath, results, repetitions)?;
    steps(&datapath, results, repetitions)
}

fn arrays(datapath: &Open, results: &mut Results, repetitions: usize) -> Result<(), CliError> {
    let mut workload = Workload::new();
    let mut compare = |what: &str, rust: f64, c: f64| {
        results.rate(format!("Rust, pack, batch and unpack, {what}"), "jobs", rust, None);
        results.rate(format!("C interface, arrays, {what}"), "jobs", c, Some(GOALS.0 * rust));
    };

    let jobs: Vec<RayBoxInput<Binary32>> = (0..JOBS).map(|_| workload.quadbox()).collect();
    let (rays, boxes): (Vec<c::Ray>, Vec<_>) = jobs.iter().map(|job| (ray(&job.ray), job.aabb.map(bounds))).unzip();
    let batch = Batch::<16, 8>::new(Rules::Paper);
    let rust = batched::<RayBoxInput<Binary32>, RayBoxOutput<Binary32>>(&jobs, repetitions, |jobs, answers| {
        batch.quadbox(jobs, answers);
    });
    let mut found = vec![c::QuadboxResult::default(); JOBS];
    let mut status = 0;
    let time = seconds(repetitions, || {
        let boxes = black_box(&boxes).as_ptr().cast();
        // SAFETY: the datapath is open, and the arrays have as many elements as the call says.
        status |= unsafe { c::raypath_quadbox(datapath.0, rays.as_ptr(), boxes, JOBS, found.as_mut_ptr()) };
    });
    compare("quadbox", rust, JOBS as f64 / time);

    let jobs: Vec<RayTriangleInput<Binary32>> = (0..JOBS).map(|_| workload.triangle()).collect();
    let rays: Vec<c::Ray> = jobs.iter().map(|job| ray(&job.ray)).collect();
    let vertices: Vec<c::Vertices> = jobs
        .iter()
        .map(|job| c::Vertices { a: job.triangle.a.into(), b: job.triangle.b.into(), c: job.triangle.c.into() })
        .collect();
    let rust =
        batched::<RayTriangleInput<Binary32>, RayTriangleOutput<Binary32>>(&jobs, repetitions, |jobs, answers| {
            batch.triangle(jobs, answers);
        });
    let mut found = vec![c::TriangleResult::default(); JOBS];
    let time = seconds(repetitions, || {
        let vertices = black_box(&vertices).as_ptr();
        // SAFETY: as above.
        status |= unsafe { c::raypath_triangle(datapath.0, rays.as_ptr(), vertices, JOBS, found.as_mut_ptr()) };
    });
    compare("triangle", rust, JOBS as f64 / time);

    let jobs: Vec<BeatInput<Binary32, 16>> = (0..JOBS).map(|_| BeatInput { euclidean: workload.beat(true) }).collect();
    let numbers = |of: fn(&Beat<Binary32, 16>) -> [Num<Binary32>; 16]| -> Vec<f32> {
        jobs.iter().flat_map(|job| of(&job.euclidean)).map(f32::from).collect()
    };
    let (a, b) = (numbers(|beat| beat.a), numbers(|beat| beat.b));
    let mut batch = Batch::<16, 8>::new(Rules::Paper);
    let rust = batched::<BeatInput<Binary32, 16>, EuclideanOutput<Binary32>>(&jobs, repetitions, |jobs, answers| {
        batch.euclidean(jobs, answers);
    });
    let mut distances = vec![0.0; JOBS];
    let time = seconds(repetitions, || {
        let (a, b) = (black_box(&a).as_ptr(), black_box(&b).as_ptr());
        // SAFETY: as above.
        status |= unsafe { c::raypath_euclidean(datapath.0, a, b, 16, JOBS, distances.as_mut_ptr()) };
    });
    compare("euclidean", rust, JOBS as f64 / time);
    require(status)
}

/// The rate of jobs in Rust: from an array of jobs to an array of outcomes.
fn batched<I: Family, O: Family>(
    jobs: &[Of<I, Binary32>],
    repetitions: usize,
    mut run: impl FnMut(&[Of<I, Packed>], &mut [Of<O, Packed>]),
) -> f64 {
    let time = seconds(repetitions, || {
        let blocks = pack::<I>(black_box(jobs));
        let mut answers = vec![blank::<O>(); blocks.len()];
        run(&blocks, &mut answers);
        black_box(unpack::<O>(&answers, jobs.len()).collect::<Vec<_>>());
    });
    jobs.len() as f64 / time
}

fn steps(datapath: &Open, results: &mut Results, repetitions: usize) -> Result<(), CliError> {
    let jobs = mixed_jobs();
    // Coordinates of beats, which the jobs of the C interface point to.
    let beats: Vec<[Vec<f32>; 2]> = jobs.iter().map(coordinates).collect();
    let c_jobs: Vec<c::Job> = jobs.iter().zip(&beats).map(|(job, [a, b])| c_job(job, a, b)).collect();
    let mut pipeline = null_mut();
    // SAFETY: the datapath is open.
    require(unsafe { c::raypath_pipeline_new(datapath.0, &mut pipeline) })?;
    let mut status = 0;
    let time = seconds(repetitions, || {
        for (tag, job) in c_jobs.iter().enumerate() {
            let mut result =
                c::PipelineResult { tag: 0, kind: 0, output: c::JobOutput { triangle: c::TriangleResult::default() } };
            // SAFETY: the pipeline was made above, and the jobs point to the coordinates of their beats.
            unsafe {
                status |= c::raypath_pipeline_offer(pipeline, black_box(job), tag as u64);
                c::raypath_pipeline_step(pipeline, true, &mut result);
            }
            black_box(&result.tag);
        }
    });
    // SAFETY: the pipeline was made above and is not used again.
    unsafe { c::raypath_pipeline_free(pipeline) };
    let rust = cycle_exact_rate(&jobs, repetitions);
    let rate = jobs.len() as f64 / time;
    results.rate("C interface, pipeline, a mixed job each cycle", "cycles", rate, Some(GOALS.1 * rust));
    require(status)
}

/// An open datapath in the default configuration.
struct Open(*mut c::Datapath);

impl Open {
    fn new() -> Result<Self, CliError> {
        let mut datapath = null_mut();
        // SAFETY: the pointer to the datapath is valid.
        require(unsafe { c::raypath_open(null(), &mut datapath) })?;
        Ok(Self(datapath))
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        // SAFETY: it was opened once, and is not used again.
        unsafe { c::raypath_close(self.0) };
    }
}

fn require(status: c::Status) -> Result<(), CliError> {
    // SAFETY: the message is a string, and no call fails while it is read.
    let message = unsafe { CStr::from_ptr(c::raypath_last_error()) };
    if status == c::RAYPATH_OK { Ok(()) } else { Err(CliError::unusable(message.to_string_lossy())) }
}

fn coordinates(job: &Job) -> [Vec<f32>; 2] {
    match job {
        Job::Euclidean(input) => [input.euclidean.a.map(f32::from).into(), input.euclidean.b.map(f32::from).into()],
        Job::Angular(input) => [input.euclidean.a.map(f32::from).into(), input.euclidean.b.map(f32::from).into()],
        Job::Quadbox(_) | Job::Triangle(_) => Default::default(),
    }
}

fn c_job(job: &Job, a: &[f32], b: &[f32]) -> c::Job {
    let beat = |reset: bool| c::JobInput {
        beat: c::BeatInput { a: a.as_ptr(), b: b.as_ptr(), mask: u64::MAX, reset_accum: reset.into() },
    };
    let (kind, input) = match job {
        Job::Quadbox(input) => {
            let quadbox = c::QuadboxInput { ray: ray(&input.ray), boxes: input.aabb.map(bounds) };
            (c::RAYPATH_JOB_QUADBOX, c::JobInput { quadbox })
        }
        Job::Triangle(input) => {
            let [a, b, c] = [input.triangle.a, input.triangle.b, input.triangle.c].map(Into::into);
            let triangle = c::TriangleInput { ray: ray(&input.ray), triangle: c::Vertices { a, b, c } };
            (c::RAYPATH_JOB_TRIANGLE, c::JobInput { triangle })
        }
        Job::Euclidean(input) => (c::RAYPATH_JOB_EUCLIDEAN, beat(input.euclidean.reset_accum.into())),
        Job::Angular(input) => (c::RAYPATH_JOB_ANGULAR, beat(input.euclidean.reset_accum.into())),
    };
    c::Job { kind, input }
}

fn ray(ray: &Ray<Binary32>) -> c::Ray {
    c::Ray {
        origin: ray.origin.into(),
        direction: ray.dir.into(),
        inverse: ray.inv.into(),
        extent: ray.extent.into(),
        shear: ray.shear.into(),
        kx: ray.kx.into(),
        ky: ray.ky.into(),
        kz: ray.kz.into(),
    }
}

fn bounds(Aabb { x, y, z }: Aabb<Binary32>) -> c::Bounds {
    let corner = |of: fn(Slab<Binary32>) -> Num<Binary32>| Vec3 { x: of(x), y: of(y), z: of(z) }.into();
    c::Bounds { min: corner(|slab| slab.min), max: corner(|slab| slab.max) }
}
