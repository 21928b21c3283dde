//! The exact oracle: outcomes known by hand, and each deliberate mistake shows.

use raypath_model::{Model, blank, dispatch, levels, pack, run_blocks, unpack};
use raypath_ops::operations::key_compare::{KeyCompare, KeyCompareInput, KeyCompareOutput};
use raypath_ops::operations::octbox::{Octbox, OctboxInput, OctboxOutput};
use raypath_ops::operations::point_in_box::{PointInBox, PointInBoxInput, PointInBoxOutput};
use raypath_ops::operations::quantised_box::{QuantisedBox, QuantisedBoxInput};
use raypath_ops::operations::sphere::{Sphere, SphereInput, SphereOutput};
use raypath_ops::{Binary32, RayBoxOutput, Rules, from_words, to_words};
use raypath_oracle::exact::{Mistake, Oracle};
use raypath_oracle::{added_operation, jobs};
use raypath_rtl::{Config, Lanes};
use raypath_sim::Datapath;

const INF: f32 = f32::INFINITY;

fn with(name: &str) -> Datapath {
    Datapath::paper(Config::DEFAULT).with_any(added_operation(name).expect("an operation").operation())
}

/// Words of the outcome of a job, by their ports. Ports of the job that are not named are 0; "box_3" names all bounds
/// of a box, a name without an axis all three coordinates. The functional model has the same outcome.
fn outcome<const N: usize>(datapath: &Datapath, name: &str, job: &[(&str, &[f32])], ports: [&str; N]) -> [u64; N] {
    let mut model = datapath.model();
    let kind = model.kind(name).expect("an operation");
    let job = model.job(kind, |port| match port {
        "ray_ky" => 1,
        "ray_kz" => 2,
        "euclidean_mask" | "node_used" => u64::MAX,
        port => job.iter().find_map(|(name, numbers)| word(port, name, numbers)).unwrap_or(0),
    });
    let found = Oracle::new(datapath.config().semantics, &model).run(&job).expect("an outcome");
    assert_eq!(model.run(&job), found, "{job:?}");
    ports.map(|port| found.port(port))
}

/// The word of a port that belongs to the name.
fn word(port: &str, name: &str, numbers: &[f32]) -> Option<u64> {
    let rest = port.strip_prefix(name)?;
    let axis = |rest: &str| ["_x", "_y", "_z"].iter().position(|axis| rest.starts_with(axis));
    let number = match (numbers.len(), rest) {
        (1, "") => numbers[0],
        (3, _) => numbers[axis(rest)?],
        (6, _) => numbers[axis(rest)? + if rest.ends_with("max") { 3 } else { 0 }],
        _ => numbers.get(rest.strip_prefix('_')?.parse::<usize>().ok()?).copied()?,
    };
    Some(number.to_bits().into())
}

fn bits(number: f32) -> u64 {
    number.to_bits().into()
}

/// The triangle with corners at depth 2 around the ray along z: U, V and W are 1, 2 and 1.
#[test]
fn a_triangle_by_hand() {
    let config = Config::DEFAULT.lanes(Lanes::None).barycentrics(true).facing(true);
    let job: [(&str, &[f32]); 4] = [
        ("triangle_a", &[-1.0, -1.0, 2.0]),
        ("triangle_b", &[0.0, 1.0, 2.0]),
        ("triangle_c", &[1.0, -1.0, 2.0]),
        ("ray_shear_z", &[1.0]),
    ];
    let ports = ["barycentric_u", "barycentric_v", "barycentric_w", "t_denom", "t_num", "triangle_hit", "facing"];
    let found = outcome(&Datapath::paper(config), "triangle", &job, ports);
    assert_eq!(found, [bits(1.0), bits(2.0), bits(1.0), bits(4.0), bits(8.0), 1, 1]);
}

/// A ray along x meets box 1 at 1, touches the flat box 0 at 3, and misses boxes 2 and 3, which are empty.
#[test]
fn boxes_by_hand() {
    let job: [(&str, &[f32]); 7] = [
        ("ray_inv", &[1.0, INF, INF]),
        ("ray_dir", &[1.0, 0.0, 0.0]),
        ("ray_extent", &[INF]),
        ("aabb_0", &[3.0, -1.0, -1.0, 3.0, 1.0, 1.0]),
        ("aabb_1", &[1.0, -1.0, -1.0, 2.0, 1.0, 1.0]),
        ("aabb_2", &[1.0, 0.0, 0.0, -1.0, 0.0, 0.0]),
        ("aabb_3", &[1.0, 0.0, 0.0, -1.0, 0.0, 0.0]),
    ];
    let ports = ["is_intersect", "tmin_0", "tmin_1", "box_index_0", "box_index_1"];
    let of = |rules| outcome(&Datapath::paper(Config::DEFAULT.rules(rules)), "quadbox", &job, ports);
    assert_eq!(of(Rules::Paper), [0b0011, bits(1.0), bits(3.0), 1, 0]);
    // The original misses the flat box.
    assert_eq!(of(Rules::Chisel)[..2], [0b0001, bits(1.0)]);
    let eight = ["octbox_is_intersect", "octbox_tmin_0", "octbox_tmin_1", "octbox_box_index_0", "octbox_box_index_1"];
    let mut job = job.to_vec();
    job.push(("aabb_7", &[0.5, -1.0, -1.0, 2.0, 1.0, 1.0]));
    // Boxes 4 to 6 are flat, at 0, where the ray starts.
    assert_eq!(outcome(&with("octbox"), "octbox", &job, eight), [0b11_1111, 0, 0, 4, 5]);
}

/// 4097² is a tie, which goes to even, and is inexact; ∞ − ∞ in a lane is invalid.
#[test]
fn sums_and_exceptions_by_hand() {
    let datapath = Datapath::paper(Config::DEFAULT.lanes(Lanes::Two).exception_flags(true));
    let beat = |name: &str, sum: &str, a: f32, b: f32| {
        let job: [(&str, &[f32]); 2] = [("euclidean_a_0", &[a]), ("euclidean_b_0", &[b])];
        outcome(&datapath, name, &job, [sum, "exception_flags"])
    };
    assert_eq!(beat("angular", "angular_dot_product", 4097.0, 4097.0), [bits(16_785_408.0), 1]);
    let distance = |a: f32, b: f32| beat("euclidean", "euclidean_accumulator", a, b);
    assert_eq!(distance(INF, INF), [0x7fc0_0000, 8]);
    assert_eq!(distance(1e30, 0.0), [bits(INF), 5]);
    assert_eq!(distance(1e-22, 0.0)[1], 3);
}

#[test]
fn keys_by_hand() {
    let datapath = with("key_compare");
    let child = |key: f32, separators: &[f32], padding: f32| {
        let mut all = [padding; 36];
        all[..separators.len()].copy_from_slice(separators);
        let [child] = outcome(&datapath, "key_compare", &[("key", &[key]), ("separator", &all)], ["child_index"]);
        child
    };
    let tens = [10.0, 20.0, 30.0];
    let found = [-INF, 9.0, 10.0, 19.0, 20.0, 30.0, f32::MAX, INF].map(|key| child(key, &tens, INF));
    assert_eq!(found, [0, 0, 1, 1, 2, 3, 3, 36]);
    assert_eq!((child(INF, &tens, f32::NAN), child(f32::NAN, &tens, INF), child(5.0, &[5.0; 36], INF)), (3, 0, 36));
    assert_eq!((child(-0.0, &[0.0], INF), child(0.0, &[-0.0, 0.0], INF)), (1, 2));
    assert_eq!((child(0.0, &[f32::from_bits(1)], INF), child(-f32::from_bits(1), &[-0.0], INF)), (0, 0));
    let separators: Vec<f32> = (1..=36).map(|i| i as f32).collect();
    assert!((0..=36).all(|key| child(key as f32, &separators, INF) == key));
}

#[test]
fn points_by_hand() {
    let datapath = with("point_in_box");
    let inside = |point: [f32; 3], min: [f32; 3], max: [f32; 3]| {
        let bounds = [min, max].concat();
        let [mask] = outcome(&datapath, "point_in_box", &[("point", &point), ("aabb_2", &bounds)], ["is_inside"]);
        mask >> 2 & 1 == 1
    };
    let (nan, least) = (f32::NAN, f32::from_bits(1));
    assert!(inside([0.0, 1.0, -0.0], [0.0; 3], [1.0; 3]), "faces belong to the box");
    assert!(inside([0.0; 3], [-0.0; 3], [-0.0; 3]), "a flat box has its points");
    assert!(!inside([0.5, 0.5, -least], [0.0; 3], [1.0; 3]), "just beside");
    assert!(inside([INF, 0.0, -INF], [-INF; 3], [INF; 3]), "all of space");
    assert!(!inside([nan, 0.0, 0.0], [-INF; 3], [INF; 3]), "no place");
    assert!(!inside([0.5; 3], [0.0, nan, 0.0], [1.0; 3]) && !inside([0.5; 3], [0.0; 3], [1.0, 1.0, nan]));
    assert!(!inside([0.5; 3], [1.0; 3], [0.0; 3]), "inside out");
}

/// Four children of 8 bits a bound: two in a row, one that is empty, and one behind the ray.
#[test]
fn quantised_boxes_by_hand() {
    let datapath = with("quantised_box");
    let model = datapath.model();
    let kind = model.kind("quantised_box").expect("an operation");
    let slabs = [[30, 40], [10, 20], [9, 3], [0, 2]];
    let run = |x: f32, towards: f32, used: u64| {
        let job = model.job(kind, |port| match port {
            "ray_origin_x" => bits(x),
            "ray_origin_y" => bits(0.5),
            "ray_origin_z" => bits(3.0),
            "ray_dir_z" => bits(towards),
            "ray_inv_x" | "ray_inv_y" | "ray_extent" => bits(INF),
            "ray_inv_z" => bits(1.0 / towards),
            "node_used" => used,
            _ if port.starts_with("node_scale") => bits(1.0),
            _ if port.starts_with("node_child") => {
                let child: usize = port[11..12].parse().expect("a child");
                slabs[child][usize::from(port.ends_with("max"))] * u64::from(port.contains("_z_"))
                    + u64::from(port.ends_with("max") && !port.contains("_z_"))
            }
            _ => 0,
        });
        let found = Oracle::new(Config::DEFAULT.semantics, &model).run(&job).expect("an outcome");
        assert_eq!(model.clone().run(&job), found, "{job:?}");
        (
            found.port("is_intersect"),
            [0, 1].map(|place| found.port(&format!("box_index_{place}"))),
            found.port("tmin_0"),
        )
    };
    assert_eq!(run(0.5, 2.0, 15), (0b11, [1, 0], bits(3.5)));
    assert_eq!(run(1.0, 2.0, 15), (0b11, [1, 0], bits(3.5)), "in a face");
    assert_eq!(run(1.0_f32.next_up(), 2.0, 15).0, 0, "beside");
    assert_eq!(run(0.5, 2.0, 0b1101), (0b01, [0, 1], bits(13.5)), "not used");
    assert_eq!(run(0.5, -1.0, 15), (0b01, [3, 0], bits(1.0)), "the other way");
}

#[test]
fn spheres_by_hand() {
    let datapath = with("sphere");
    let run = |origin: [f32; 3], dir: [f32; 3], centre: [f32; 3], radius: f32| {
        let job: [(&str, &[f32]); 4] =
            [("ray_origin", &origin), ("ray_dir", &dir), ("sphere_centre", &centre), ("sphere_radius", &[radius])];
        let ports = ["sphere_a", "sphere_b", "sphere_c", "sphere_discriminant", "sphere_hit"];
        let [a, b, c, discriminant, hit] = outcome(&datapath, "sphere", &job, ports);
        ([a, b, c, discriminant].map(|word| f32::from_bits(word as u32)), hit == 1)
    };
    let along = [0.0, 0.0, 2.0];
    // The solutions are t = 2 and 3, at 4 and 6 along z.
    assert_eq!(run([0.0; 3], along, [0.0, 0.0, 5.0], 1.0), ([4.0, 10.0, 24.0, 4.0], true));
    assert_eq!(run([0.0; 3], along, [0.0, 0.0, -5.0], 1.0), ([4.0, -10.0, 24.0, 4.0], false));
    assert_eq!(run([0.0; 3], along, [0.0, 0.0, -0.5], 1.0), ([4.0, -1.0, -0.75, 4.0], true));
    assert_eq!(run([1.0, 0.0, 0.0], along, [0.0, 0.0, 5.0], 1.0), ([4.0, 10.0, 25.0, 0.0], true));
    assert_eq!(run([2.0, 0.0, 0.0], along, [0.0, 0.0, 5.0], -1.0), ([4.0, 10.0, 28.0, -12.0], false));
    let hit = |origin, dir, centre, radius| run(origin, dir, centre, radius).1;
    assert!(hit([0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0; 3], 1.0), "starts on the sphere, away from it");
    assert!(hit([0.0; 3], along, [0.0, 0.0, 3.0], 0.0), "a point on the ray");
    assert!(!hit([0.0; 3], [0.0; 3], [0.0; 3], 1.0), "no direction");
    assert!(!hit([0.0; 3], [0.0, 0.0, 1e-30], [0.0, 0.0, 3.0], 1.0), "a direction whose square is zero");
    assert!(!hit([0.0; 3], [0.0, 0.0, INF], [0.0, 0.0, 3.0], 1.0), "0 times infinity");
    // A sphere of radius 1 at a distance of 4,096, passed at 0.9 or 1.1. b² − a c would be 0.
    for (side, hits) in [(0.9, true), (1.1, false)] {
        let ([.., discriminant], hit) = run([0.0; 3], [0.0, 0.0, 1.0], [side, 0.0, 4096.0], 1.0);
        assert!((discriminant - (1.0 - side * side)).abs() < 1e-6 && hit == hits, "{side}: {discriminant}");
    }
}

/// Defines a test of an added operation: the SIMD lanes of every instruction set have the oracle's outcomes, and an
/// oracle with a mistake has others.
macro_rules! lanes_agree {
    ($($name:ident: $operation:ident, $input:ident, $output:ident, $mistake:ident;)*) => { $(
        #[test]
        fn $name() {
            let datapath = with(stringify!($name));
            let model = datapath.model();
            let kind = model.kind(stringify!($name)).expect("an operation");
            let specs = [added_operation(stringify!($name)).expect("an operation")];
            let words: Vec<_> = jobs(&datapath, &specs, 1, &[kind]).take(16 * 200).collect();
            let mut oracle = Oracle::new(datapath.config().semantics, &model);
            let mut wrong = oracle.clone().with(Mistake::$mistake);
            let expected: Vec<_> = words.iter().map(|job| oracle.run(job).expect("an outcome")).collect();
            let others = words.iter().zip(&expected).filter(|(job, right)| wrong.run(job).as_ref() != Ok(right));
            assert!(others.count() > 10);
            let jobs: Vec<$input<Binary32>> =
                words.iter().map(|job| from_words(Binary32, &model.all_inputs(job))).collect();
            let blocks = pack::<$input<Binary32>>(&jobs);
            for level in levels() {
                let mut found = vec![blank::<$output<Binary32>>(); blocks.len()];
                dispatch!(level, simd => run_blocks(simd, &$operation, &blocks, &mut found, &mut ()));
                for (found, expected) in unpack::<$output<Binary32>>(&found, jobs.len()).zip(&expected) {
                    let mut words = Vec::new();
                    to_words(&found, &mut words);
                    assert_eq!(model.outcome_of_words(kind, &words), *expected, "{level:?}");
                }
            }
        }
    )* };
}

lanes_agree! {
    key_compare: KeyCompare, KeyCompareInput, KeyCompareOutput, StrictKeys;
    octbox: Octbox, OctboxInput, OctboxOutput, TiesReversed;
    point_in_box: PointInBox, PointInBoxInput, PointInBoxOutput, OpenPoints;
    quantised_box: QuantisedBox, QuantisedBoxInput, RayBoxOutput, UnusedChildren;
    sphere: Sphere, SphereInput, SphereOutput, SpheresBehind;
}
