//! Arrays in every number of lanes and in other formats, and what is rejected.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_embed::{Bounds, Datapath, Error, QuadboxResult, Ray};

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

/// Sums that round are the same bits whether SIMD lanes compute them or the words at the ports.
#[test]
fn all_ways_round_alike() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let [a, b] = [(); 2].map(|()| (0..50 * 77).map(|_| random.random_range(-1.0..1.0)).collect::<Vec<f32>>());
    for lanes in [2, 4, 8, 16, 32, 64] {
        let sums = |feature: &str| {
            let datapath = Datapath::open(&format!("lanes = {lanes}\n{feature}"), &[]).expect("valid");
            let mut sums = [(); 3].map(|()| vec![0.0; 50]);
            let [distances, dots, norms] = &mut sums;
            datapath.euclidean(&a, &b, 77, distances).expect("equal lengths");
            datapath.angular(&a, &b, 77, dots, norms).expect("equal lengths");
            sums
        };
        assert_eq!(sums(""), sums("tag = 1"), "{lanes} lanes");
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
