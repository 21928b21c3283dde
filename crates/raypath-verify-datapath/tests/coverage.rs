//! Coverage: it shows the points that are not covered.

use raypath_model::{Shape, WordModel};
use raypath_ops::{Job, JobKind};
use raypath_rtl::Config;
use raypath_sim::Datapath;
use raypath_verify_datapath::coverage::{Counted, Coverage, CoverageModel, JobPath};
use raypath_verify_datapath::layout::Layout;
use raypath_verify_datapath::stimuli::Stimuli;

fn coverage_model() -> CoverageModel {
    CoverageModel::new(Config::DEFAULT.semantics, &Shape::default(), &model())
}

fn model() -> WordModel {
    Datapath::paper(Config::DEFAULT).model()
}

/// The points that these jobs leave uncovered.
fn uncovered(jobs: impl Iterator<Item = Job>) -> Vec<String> {
    let (points, model) = (coverage_model(), model());
    let mut coverage = Coverage::new(&points);
    let mut words = Vec::new();
    for job in jobs {
        job.words(&mut words);
        let kind = model.kind(job.kind().name()).expect("an operation");
        coverage.count(&points.job_points(kind, &words), JobPath::STRAIGHT);
    }
    coverage.uncovered(&points, Counted::AtEntry).1
}

fn stimuli(count: usize) -> Vec<Job> {
    let model = model();
    let layout = Layout::of(&model);
    let mut stimuli = Stimuli::new(&layout, &model, 4);
    let mut words = Vec::new();
    let job = |_| {
        let kind = stimuli.next(&mut words).paper().expect("an operation of the paper");
        Job::from_words_in(raypath_ops::Binary32, kind, &words)
    };
    (0..count).map(job).collect()
}

/// The stimuli cover all points but those that need a pipeline.
#[test]
fn the_stimuli_leave_nothing_out() {
    let left = uncovered(stimuli(150_000).into_iter());
    let at_exit = ["added to", "right behind", "other jobs since", "the first after a reset"];
    let missing: Vec<&String> = left.iter().filter(|name| !at_exit.iter().any(|exit| name.contains(exit))).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn stimuli_of_one_shape_show() {
    let ones = |kind| Job::from_ports(kind, |port| if port.contains("_k") { 0 } else { 0x3f80_0000 });
    let left = uncovered(std::iter::repeat_n(ones(JobKind::Quadbox), 1000));
    let has = |name: &str| left.iter().any(|point| point == name);
    assert!(has("quadbox: inverse −0") && has("quadbox: 5: order [3, 2, 1, 0]") && has("triangle: vertex A NaN"));
    assert!(!has("quadbox: inverse +1") && !has("quadbox: 5: order [0, 1, 2, 3]"), "{left:?}");
    // A campaign without an operation leaves all of its points uncovered.
    let left = uncovered(stimuli(20_000).into_iter().filter(|job| job.kind() != JobKind::Angular));
    assert!(left.iter().filter(|name| name.starts_with("angular: ")).count() > 30);
    assert!(!left.iter().any(|name| name.starts_with("triangle: vertex")), "{left:?}");
}

/// A job by hand, and the points that it covers.
#[test]
fn points_are_those_of_the_job() {
    let exercised = |job: Job| {
        let all: Vec<String> = uncovered(std::iter::empty());
        let left = uncovered(std::iter::once(job));
        all.into_iter().filter(|name| !left.contains(name)).collect::<Vec<_>>()
    };
    // The ray starts at the origin along x. Its end touches box 0, the other boxes are behind it.
    let number = |x: f32| u64::from(x.to_bits());
    let job = Job::from_ports(JobKind::Quadbox, |port| match port {
        "ray_inv_x" | "ray_extent" => number(1.0),
        "ray_inv_y" => number(f32::INFINITY),
        "ray_inv_z" => number(f32::NEG_INFINITY),
        "aabb_0_x_min" => number(1.0),
        "aabb_0_x_max" => number(2.0),
        _ if port.ends_with("x_min") || port.ends_with("x_max") => number(-2.0),
        _ if port.ends_with("min") => number(-1.0),
        _ if port.ends_with("max") => number(1.0),
        _ => 0,
    });
    let found = exercised(job);
    for rule in [
        "1: runs backwards along an axis",
        "1: inv = −∞, a direction of −0",
        "3: a box begins at the extent",
        "4: tmin = tmax, finite",
        "4: tmin > tmax",
        "5: one hit",
        "5: order [0, 1, 2, 3]",
        "box min −normal",
        "extent +1",
    ] {
        assert!(found.contains(&format!("quadbox: {rule}")), "{rule}: {found:?}");
    }
    for rule in [
        "2: a near distance 0·∞ drops out",
        "4: tmin < tmax",
        "4: a flat box, tmin ≤ tmax",
        "5: no hit",
        "1: inv = NaN",
    ] {
        assert!(!found.contains(&format!("quadbox: {rule}")), "{rule}: {found:?}");
    }
    let masked = Job::from_ports(JobKind::Euclidean, |port| match port {
        "euclidean_mask" => 1,
        "euclidean_a_0" => number(-0.0),
        "euclidean_a_5" => number(f32::NAN),
        _ => 0,
    });
    let found = exercised(masked);
    let expected = [
        "euclidean: query −0",
        "euclidean: candidate +0",
        "euclidean: 7: one lane is enabled",
        "euclidean: 7: a masked lane holds NaN",
        "euclidean: 7: a masked lane holds another number",
        "euclidean: the beat does not carry reset",
    ];
    assert_eq!(found, expected);
}
