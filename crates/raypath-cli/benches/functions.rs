//! The functions inside, one by one: `cargo bench -p raypath-cli --features full`. What users should expect is printed
//! by `raypath bench`.

#[path = "../src/commands/full/bench/workload.rs"]
mod workload;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use raypath_hdl::Simulator;
use raypath_model::{Batch, CycleModel, Functional, Shape, blank, levels, pack, unpack};
use raypath_ops::{
    Binary32, EuclideanInput, EuclideanOutput, Job, JobKind, Ray, RayBoxInput, RayBoxOutput, RayTriangleInput,
    RayTriangleOutput, Rules,
};
use raypath_rtl::{Config, Datapath};
use workload::Workload;

/// Jobs of a measurement.
const JOBS: usize = 1024;
/// Jobs of a batch, which fits into a first-level cache.
const BATCH: usize = 128;

fn main() {
    divan::main();
}

/// One job after another, of one kind.
#[divan::bench(args = JobKind::ALL)]
fn functional(bencher: Bencher, kind: JobKind) {
    let jobs: Vec<Job> = Workload::new().mixed(4 * JOBS).into_iter().filter(|job| job.kind() == kind).collect();
    let mut model = Functional::<16, 8>::new(Rules::Paper);
    bencher.counter(ItemsCount::new(JOBS)).bench_local(|| {
        for job in &jobs {
            black_box(&model.run(black_box(job)));
        }
    });
}

/// What takes the instruction sets as numbers, the widest being 0.
fn level_numbers() -> std::ops::Range<usize> {
    0..levels().len()
}

#[divan::bench(args = level_numbers())]
fn quadboxes_in_lanes(bencher: Bencher, level: usize) {
    let batch = Batch::<16, 8>::at(levels()[level], Rules::Paper);
    let mut workload = Workload::new();
    let jobs = pack::<RayBoxInput<Binary32>>(&std::array::from_fn::<_, BATCH, _>(|_| workload.quadbox()));
    let mut answers = vec![blank::<RayBoxOutput<Binary32>>(); jobs.len()];
    bencher.counter(ItemsCount::new(BATCH)).bench_local(|| batch.quadbox(black_box(&jobs), &mut answers));
}

#[divan::bench(args = level_numbers())]
fn triangles_in_lanes(bencher: Bencher, level: usize) {
    let batch = Batch::<16, 8>::at(levels()[level], Rules::Paper);
    let mut workload = Workload::new();
    let jobs = pack::<RayTriangleInput<Binary32>>(&std::array::from_fn::<_, BATCH, _>(|_| workload.triangle()));
    let mut answers = vec![blank::<RayTriangleOutput<Binary32>>(); jobs.len()];
    bencher.counter(ItemsCount::new(BATCH)).bench_local(|| batch.triangle(black_box(&jobs), &mut answers));
}

#[divan::bench(args = level_numbers())]
fn euclidean_beats_in_lanes(bencher: Bencher, level: usize) {
    let mut batch = Batch::<16, 8>::at(levels()[level], Rules::Paper);
    let jobs = pack::<EuclideanInput<Binary32, 16>>(&beats());
    let mut answers = vec![blank::<EuclideanOutput<Binary32>>(); jobs.len()];
    bencher.counter(ItemsCount::new(BATCH)).bench_local(|| batch.euclidean(black_box(&jobs), &mut answers));
}

#[divan::bench]
fn packing(bencher: Bencher) {
    let jobs = beats();
    bencher.counter(ItemsCount::new(BATCH)).bench_local(|| pack::<EuclideanInput<Binary32, 16>>(black_box(&jobs)));
}

#[divan::bench]
fn unpacking(bencher: Bencher) {
    let blocks = pack::<EuclideanInput<Binary32, 16>>(&beats());
    bencher.counter(ItemsCount::new(BATCH)).bench_local(|| {
        unpack::<EuclideanInput<Binary32, 16>>(black_box(&blocks), BATCH).for_each(|beat| {
            black_box(beat);
        })
    });
}

/// A cycle that accepts a job, in a pipeline that is full.
#[divan::bench]
fn cycle(bencher: Bencher) {
    let jobs = Workload::new().mixed(JOBS);
    let mut model = CycleModel::new(Functional::<16, 8>::new(Rules::Paper), &Shape::default());
    bencher.counter(ItemsCount::new(JOBS)).bench_local(|| {
        for job in &jobs {
            black_box(model.cycle(Some(black_box(job)), true));
        }
    });
}

/// What the ports want of a ray.
#[divan::bench]
fn ray(bencher: Bencher) {
    let [origin, direction] = [[0.1, 0.2, 0.3], [0.4, -0.5, 0.6]];
    bencher.bench(|| Ray::new(black_box(origin), black_box(direction), f32::INFINITY));
}

/// Compiling the netlist, which every run of it begins with.
#[divan::bench(sample_count = 10)]
fn compiling_the_netlist(bencher: Bencher) {
    let datapath = Datapath::new(Config::DEFAULT).expect("the default configuration");
    bencher.bench_local(|| Simulator::new(datapath.top()));
}

fn beats() -> Vec<EuclideanInput<Binary32, 16>> {
    let mut workload = Workload::new();
    (0..BATCH).map(|i| EuclideanInput { euclidean: workload.beat(i % 64 == 0) }).collect()
}
