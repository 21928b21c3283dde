//! Arrays in every number of lanes and in other formats, and what is rejected.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_embed::{
    Beat, Bounds, Datapath, Error, Job, Outcome, Pipeline, QuadboxResult, Ray, TriangleResult, Vertices,
};

/// Whole numbers, whose sums are exact in any order.
fn whole_numbers(count: usize, seed: u64) -> Vec<f32> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..count).map(|_| random.random_range(-3..=3) as f32).collect()
}

#[test]
fn distances_of_whole_numbers_are_exact() {
    // In fp16, whole numbers up to 2048 are exact.
    for (format, most) in [("fp32", 100), ("fp16", 50), ("e11s24", 50)] {
        for lanes in [2, 4, 8, 16, 32, 64] {
            let datapath = Datapath::open(&format!("lanes = {lanes}\nformat = \"{format}\""), &[]).expect("valid");
            for dimensions in [1, 2, 3, 16, 33, most] {
                for count in [0, 1, 16, 37] {
                    let [a, b] = [1, 2].map(|seed| whole_numbers(count * dimensions, seed));
                    let mut found = vec![f32::NAN; count];
                    let (mut dots, mut norms) = (found.clone(), found.clone());
                    datapath.euclidean(&a, &b, dimensions, &mut found).expect("equal lengths");
                    datapath.angular(&a, &b, dimensions, &mut dots, &mut norms).expect("equal lengths");
                    let sum = |row: usize, term: fn(i64, i64) -> i64| -> f32 {
                        let row = row * dimensions..(row + 1) * dimensions;
                        a[row.clone()].iter().zip(&b[row]).map(|(&a, &b)| term(a as i64, b as i64)).sum::<i64>() as f32
                    };
                    for row in 0..count {
                        assert_eq!(found[row], sum(row, |a, b| (a - b) * (a - b)), "{format}, {lanes}, {dimensions}");
                        assert_eq!(dots[row], sum(row, |a, b| a * b), "{format}, {lanes}, {dimensions}");
                        assert_eq!(norms[row], sum(row, |_, b| b * b), "{format}, {lanes}, {dimensions}");
                    }
                }
            }
        }
    }
}

/// The outcomes of jobs one after another through a pipeline: of boxes, of triangles, and of two beats each of
/// distances.
fn through_pipeline(datapath: &Datapath, rays: &[Ray], boxes: &[[Bounds; 4]], triangles: &[Vertices]) -> Vec<Outcome> {
    let mut pipeline = Pipeline::new(datapath);
    let mut outcomes = Vec::new();
    let mut through = |job: &Job<'_>| {
        assert!(pipeline.offer(job, 0).expect("a job"));
        pipeline.skip(1000);
        outcomes.push(pipeline.step(true).expect("an outcome").outcome);
    };
    for ((ray, boxes), triangle) in rays.iter().zip(boxes).zip(triangles) {
        through(&Job::Quadbox { ray, boxes });
        through(&Job::Triangle { ray, triangle });
    }
    outcomes
}

/// Arrays, which SIMD lanes compute, have the bits of single jobs through the words at the ports, with every feature.
#[test]
fn arrays_are_as_single_jobs() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    // Half of them small integers in a unit, so that rays pass exactly through edges and vertices.
    let mut vector = || {
        let unit = if random.random() { 0.25_f32 } else { f32::EPSILON };
        [(); 3].map(|()| (random.random_range(-1.0_f32..1.0) / unit).round() * unit)
    };
    let rays: Vec<Ray> = (0..300).filter_map(|_| Ray::new(vector(), vector(), 3.0).ok()).collect();
    let boxes: Vec<[Bounds; 4]> =
        rays.iter().map(|_| [(); 4].map(|()| Bounds { min: vector(), max: [1.0; 3] })).collect();
    let triangles: Vec<Vertices> = rays.iter().map(|_| Vertices { a: vector(), b: vector(), c: vector() }).collect();
    let features = [
        "tag = 3",
        "barycentrics = true",
        "edges = \"once\"",
        "edges = \"once\"\nculling = \"none\"",
        "format = \"fp16\"\nedges = \"once\"",
        "culling = \"none\"",
        "culling = \"front\"\nfacing = true",
        "range = true",
        "conservative = true",
        "accumulators = 4",
        "exception-flags = true",
        "rules = \"chisel\"\ntag = 1",
        "format = \"fp16\"",
        "format = \"fp16\"\nrules = \"chisel\"",
        "format = \"bf16\"\nconservative = true",
        "format = \"e4s4\"\nbarycentrics = true\nrange = true",
        "rounding = \"sum\"",
        "rounding = \"sum\"\nbarycentrics = true\nculling = \"none\"",
    ];
    for feature in features {
        let datapath = Datapath::open(feature, &[]).expect("valid");
        let (mut hits, mut met) = (vec![QuadboxResult::default(); 300], vec![TriangleResult::default(); 300]);
        datapath.quadbox(&rays, &boxes, &mut hits).expect("equal lengths");
        datapath.triangle(&rays, &triangles, &mut met).expect("equal lengths");
        let arrays = hits.iter().zip(&met).flat_map(|(hit, met)| [Outcome::Quadbox(*hit), Outcome::Triangle(*met)]);
        let arrays: Vec<Outcome> = arrays.collect();
        assert_eq!(through_pipeline(&datapath, &rays, &boxes, &triangles), arrays, "{feature}");
        assert!(met.iter().filter(|met| met.triangle_hit == 1).count() > 3, "{feature}");
    }
}

/// Sums that round are the same bits whether SIMD lanes compute them or the words at the ports.
#[test]
fn all_ways_round_alike() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let [a, b] = [(); 2].map(|()| (0..50 * 77).map(|_| random.random_range(-1.0..1.0)).collect::<Vec<f32>>());
    for lanes in [2, 4, 8, 16, 32, 64] {
        let formats = ["format = \"fp16\"", "format = \"bf16\""];
        for feature in ["tag = 1", "accumulators = 2", "rounding = \"sum\""].into_iter().chain(formats) {
            let datapath = Datapath::open(&format!("lanes = {lanes}\n{feature}"), &[]).expect("valid");
            let mut sums = [(); 3].map(|()| vec![0.0; 50]);
            let [distances, dots, norms] = &mut sums;
            datapath.euclidean(&a, &b, 77, distances).expect("equal lengths");
            datapath.angular(&a, &b, 77, dots, norms).expect("equal lengths");
            let mut pipeline = Pipeline::new(&datapath);
            let mut last = |a: &[f32], b: &[f32], lanes: usize, is_angular: bool| {
                let mut outcome = None;
                for first in (0..77).step_by(lanes) {
                    let count = lanes.min(77 - first);
                    let padded = |of: &[f32]| [&of[first..first + count], &vec![0.0; lanes - count]].concat();
                    let (a, b) = (padded(a), padded(b));
                    let mask = u64::MAX >> (64 - count);
                    let beat = Beat { a: &a, b: &b, mask, reset_accum: first + lanes >= 77 };
                    let job = if is_angular { Job::Angular(beat) } else { Job::Euclidean(beat) };
                    while !pipeline.offer(&job, 0).expect("a beat") {
                        pipeline.step(true);
                    }
                    pipeline.skip(1000);
                    outcome = pipeline.step(true).map(|left| left.outcome);
                }
                outcome.expect("an outcome")
            };
            for row in 0..50 {
                let (a, b) = (&a[77 * row..77 * (row + 1)], &b[77 * row..77 * (row + 1)]);
                let Outcome::Euclidean(found) = last(a, b, lanes, false) else { panic!("another outcome") };
                assert_eq!(found.accumulator, sums[0][row], "{lanes} lanes, {feature}");
                let Outcome::Angular(found) = last(a, b, lanes / 2, true) else { panic!("another outcome") };
                assert_eq!((found.dot_product, found.norm), (sums[1][row], sums[2][row]), "{lanes} lanes, {feature}");
            }
        }
    }
}

/// Numbers are rounded to the datapath's format and back.
#[test]
fn boxes_in_half_precision() {
    let datapath = Datapath::open("format = \"fp16\"", &[]).expect("valid");
    let ray = Ray::new([0.0, 0.0, -5.0], [0.0, 0.0, 1.0], f32::INFINITY).expect("a ray");
    let boxes = [1.0, 4.0, 2.0, 3.0].map(|z| Bounds { min: [-1.0, -1.0, z], max: [1.0, 1.0, z + 0.5] });
    let mut results = [QuadboxResult::default()];
    datapath.quadbox(&[ray], &[boxes], &mut results).expect("equal lengths");
    assert_eq!((results[0].box_index, results[0].tmin), ([0, 2, 3, 1], [6.0, 7.0, 8.0, 9.0]));
}

#[test]
fn wrong_arguments_are_errors() {
    let datapath = Datapath::open("lanes = \"none\"", &["sphere"]).expect("valid");
    let message = |result: Result<(), Error>| result.expect_err("an error").to_string();
    let ray = Ray::new([0.0; 3], [0.0, 0.0, 1.0], 1.0).expect("a ray");
    let boxes = [[Bounds::default(); 4]; 2];
    assert_eq!(
        message(datapath.quadbox(&[ray], &boxes, &mut [QuadboxResult::default()])),
        "2 boxes and 1 rays, expected as many"
    );
    let expected = "'euclidean' is not an operation of this datapath, expected triangle, quadbox or sphere";
    assert_eq!(message(datapath.euclidean(&[], &[], 1, &mut [])), expected);
    let sphere = datapath.operation("sphere").expect("an added operation");
    let text = message(datapath.run(sphere, &[0; 3], &mut [0; 3]));
    assert!(text.starts_with("3 words of input and 3 of output, expected"), "{text}");
    let whole = Datapath::open("", &[]).expect("the default");
    assert_eq!(
        message(whole.euclidean(&[1.0; 6], &[1.0; 6], 0, &mut [0.0; 2])),
        "vectors of 0 dimensions, expected at least 1"
    );
    assert_eq!(
        message(whole.euclidean(&[1.0; 6], &[1.0; 4], 3, &mut [0.0; 2])),
        "6 and 4 numbers, expected 2 vectors of 3 dimensions each"
    );
}

/// An added operation through its ports: a ray from z = -5 meets the unit sphere at t² - 10 t + 24 = 0.
#[test]
fn added_operations_run_by_name() {
    let datapath = Datapath::open("", &["sphere"]).expect("valid");
    let sphere = datapath.operation("sphere").expect("an added operation");
    let value = |name: &str| match name {
        "ray_origin_z" => -5.0f32,
        "ray_dir_z" | "sphere_radius" => 1.0,
        _ => 0.0,
    };
    let inputs: Vec<u64> = datapath.inputs(sphere).iter().map(|port| u64::from(value(&port.name).to_bits())).collect();
    let mut found = vec![0; datapath.outputs(sphere).len()];
    datapath.run(sphere, &inputs, &mut found).expect("whole jobs");
    let output = |name: &str| {
        let position = datapath.outputs(sphere).iter().position(|port| port.name == name).expect("an output");
        f32::from_bits(found[position] as u32)
    };
    let equation = ["sphere_a", "sphere_b", "sphere_c", "sphere_discriminant"].map(output);
    assert_eq!(equation, [1.0, 5.0, 24.0, 1.0]);
}
