//! Rates of the models on one core.

use crate::commands::full::bench::result::{Results, seconds};
use crate::commands::full::bench::workload::Workload;
use rand::rngs::ChaCha8Rng;
use rand::{Rng, SeedableRng};
use raypath_model::{Batch, CycleModel, Functional, Packed, Shape, blank, levels, pack, unpack};
use raypath_ops::{
    AngularOutput, BeatInput, Binary32, EuclideanOutput, Family, Job, JobKind, Of, Ray, RayBoxInput, RayBoxOutput,
    RayTriangleInput, RayTriangleOutput, Rules,
};
use std::hint::black_box;

/// The jobs of a measurement: more than a branch predictor remembers, fewer than a second-level cache holds.
const JOBS: usize = 4096;

/// The jobs of a batch. Jobs and outcomes fit into a first-level cache.
const BATCH: usize = 128;

/// Measures the functional model, one job after another.
pub fn functional(results: &mut Results, repetitions: usize) {
    let jobs = Workload::new().mixed(JOBS);
    let mut model = Functional::<16, 8>::new(Rules::Paper);
    let mut rate = |jobs: &[Job]| jobs.len() as f64 / seconds(repetitions, || each(&mut model, jobs));
    results.rate("functional model, mixed jobs one at a time", "jobs", rate(&jobs), Some(50e6));
    for kind in JobKind::ALL {
        let of_kind: Vec<Job> = jobs.iter().copied().filter(|job| job.kind() == kind).collect();
        results.rate(format!("functional model, {kind} one at a time"), "jobs", rate(&of_kind), None);
    }
}

/// Runs jobs to measure their time. Outcomes are not copied, because a copy takes as long as the outcome itself.
pub fn each(model: &mut Functional, jobs: &[Job]) {
    for job in jobs {
        black_box(&model.run(black_box(job)));
    }
}

/// Measures batches in SIMD lanes, with each instruction set of the machine.
pub fn batches(results: &mut Results, repetitions: usize) {
    let mut workload = Workload::new();
    let boxes: Vec<_> = (0..BATCH).map(|_| workload.quadbox()).collect();
    let triangles: Vec<_> = (0..BATCH).map(|_| workload.triangle()).collect();
    let euclidean: Vec<_> = (0..BATCH).map(|i| BeatInput { euclidean: workload.beat(i % 64 == 0) }).collect();
    let angular: Vec<_> = (0..BATCH).map(|i| BeatInput { euclidean: workload.beat(i % 64 == 0) }).collect();
    let blocks = pack::<BeatInput<Binary32, 16>>(&euclidean);
    let time = seconds(repetitions, || drop(black_box(pack::<BeatInput<Binary32, 16>>(black_box(&euclidean)))));
    results.rate("batches, packing euclidean jobs", "jobs", BATCH as f64 / time, None);
    let time = seconds(repetitions, || {
        unpack::<BeatInput<Binary32, 16>>(black_box(&blocks), BATCH).for_each(|beat| {
            black_box(beat);
        });
    });
    results.rate("batches, unpacking euclidean jobs", "jobs", BATCH as f64 / time, None);
    for level in levels() {
        let mut batch = Batch::<16, 8>::at(level, Rules::Paper);
        let name = format!("{level:?}");
        let name = name.split('(').next().unwrap_or_default().to_lowercase();
        let mut rate = |kind: JobKind, goal: Option<f64>, per_second: f64| {
            let goal = goal.filter(|_| name.starts_with("avx"));
            results.rate(format!("batches, {name}, {kind}"), "jobs", per_second, goal);
        };
        let run = |jobs: &_, answers: &mut _| batch.quadbox(jobs, answers);
        rate(
            JobKind::Quadbox,
            Some(200e6),
            timed::<RayBoxInput<Binary32>, RayBoxOutput<Binary32>>(&boxes, repetitions, run),
        );
        let run = |jobs: &_, answers: &mut _| batch.triangle(jobs, answers);
        let per_second = timed::<RayTriangleInput<Binary32>, RayTriangleOutput<Binary32>>(&triangles, repetitions, run);
        rate(JobKind::Triangle, None, per_second);
        let run = |jobs: &_, answers: &mut _| batch.euclidean(jobs, answers);
        let per_second = timed::<BeatInput<Binary32, 16>, EuclideanOutput<Binary32>>(&euclidean, repetitions, run);
        rate(JobKind::Euclidean, Some(400e6), per_second);
        let run = |jobs: &_, answers: &mut _| batch.angular(jobs, answers);
        let per_second = timed::<BeatInput<Binary32, 8>, AngularOutput<Binary32>>(&angular, repetitions, run);
        rate(JobKind::Angular, None, per_second);
    }
}

/// Measures the preparation of a ray: the values of its ports from origin and direction.
pub fn rays(results: &mut Results, repetitions: usize) {
    let [origin, direction] = [[0.1, 0.2, 0.3], [0.4, -0.5, 0.6]];
    let time = seconds(repetitions, || {
        let _ = black_box(Ray::<Binary32>::new(black_box(origin), black_box(direction), f32::INFINITY));
    });
    results.rate("rays from origin and direction", "rays prepared", 1.0 / time, None);
}

fn timed<I: Family, O: Family>(
    jobs: &[Of<I, Binary32>],
    repetitions: usize,
    mut run: impl FnMut(&[Of<I, Packed>], &mut [Of<O, Packed>]),
) -> f64 {
    let blocks = pack::<I>(jobs);
    let mut answers = vec![blank::<O>(); blocks.len()];
    let time = seconds(repetitions, || {
        run(black_box(&blocks), &mut answers);
        black_box(&mut answers);
    });
    jobs.len() as f64 / time
}

/// Measures the cycle-exact model: a job in every cycle, a sink that stalls at random, and idle cycles between jobs.
pub fn cycle_exact(results: &mut Results, repetitions: usize) {
    let jobs = Workload::new().mixed(JOBS);
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let stalls: Vec<bool> = (0..JOBS).map(|_| rng.next_u32() % 4 == 0).collect();
    let mut model = CycleModel::new(Functional::<16, 8>::new(Rules::Paper), &Shape::default());
    for (what, may_stall, goal) in [
        ("cycle-exact model, a mixed job each cycle", false, None),
        ("cycle-exact model, the sink stalls at random in a quarter of the cycles", true, Some(20e6)),
    ] {
        let mut next = 0;
        let run = || {
            for &stalled in &stalls {
                let transfer = model.cycle(Some(black_box(&jobs[next])), !(may_stall && stalled));
                next = (next + usize::from(transfer.accepted)) % jobs.len();
                black_box(transfer);
            }
        };
        results.rate(what, "cycles", stalls.len() as f64 / seconds(repetitions, run), goal);
    }
    // A job every thousand cycles.
    const IDLE: u64 = 1000;
    let run = || {
        for job in &jobs[..64] {
            model.cycle(Some(black_box(job)), true);
            let passed = model.idle(IDLE);
            black_box(model.cycle(None, true));
            model.idle(IDLE - passed);
        }
    };
    let cycles = 64.0 * (IDLE + 2) as f64;
    results.rate(
        "cycle-exact model, a job in a thousand cycles, idle ones skipped",
        "cycles",
        cycles / seconds(repetitions, run),
        None,
    );
}
