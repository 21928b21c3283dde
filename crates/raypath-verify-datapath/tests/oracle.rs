//! The exact oracle: known outcomes, and each of its deliberate mistakes shows.

use raypath_ops::Rules;
use raypath_rtl::{Config, Lanes};
use raypath_sim::Datapath;
use raypath_verify_datapath::oracle::Oracle;

/// A job of a datapath by its ports, all others 0, and words of its outcome by their ports.
fn outcome<const N: usize>(datapath: &Datapath, name: &str, job: &[(&str, f32)], ports: [&str; N]) -> [u64; N] {
    let model = datapath.model();
    let kind = model.kind(name).expect("an operation");
    let word = |port: &str| job.iter().find(|(name, _)| *name == port).map_or(0, |(_, x)| u64::from(x.to_bits()));
    let job = model.job(kind, |port| match port {
        "ray_ky" => 1,
        "ray_kz" => 2,
        "euclidean_mask" | "node_used" => u64::MAX,
        port => word(port),
    });
    let found = Oracle::new(datapath.config().semantics, &model).run(&job).expect("an outcome");
    ports.map(|port| found.port(port))
}

fn bits(number: f32) -> u64 {
    number.to_bits().into()
}

/// The triangle with corners at depth 2 around the ray along z: U, V and W are 1, 2 and 1.
#[test]
fn a_triangle_by_hand() {
    let config = Config::DEFAULT.lanes(Lanes::None).barycentrics(true).facing(true);
    let corners = [
        ("triangle_a_x", -1.0),
        ("triangle_a_y", -1.0),
        ("triangle_a_z", 2.0),
        ("triangle_b_y", 1.0),
        ("triangle_b_z", 2.0),
        ("triangle_c_x", 1.0),
        ("triangle_c_y", -1.0),
        ("triangle_c_z", 2.0),
        ("ray_shear_z", 1.0),
    ];
    let ports = ["barycentric_u", "barycentric_v", "barycentric_w", "t_denom", "t_num", "triangle_hit", "facing"];
    let found = outcome(&Datapath::paper(config), "triangle", &corners, ports);
    assert_eq!(found, [bits(1.0), bits(2.0), bits(1.0), bits(4.0), bits(8.0), 1, 1]);
}

/// A ray along x meets box 1 at 1, touches the flat box 0 at 3, and misses boxes 2 and 3, which are empty.
#[test]
fn boxes_by_hand() {
    let mut job = vec![("ray_inv_x", 1.0), ("ray_inv_y", f32::INFINITY), ("ray_inv_z", f32::INFINITY)];
    job.extend([("ray_dir_x", 1.0), ("ray_extent", f32::INFINITY)]);
    job.extend([("aabb_0_x_min", 3.0), ("aabb_0_x_max", 3.0), ("aabb_1_x_min", 1.0), ("aabb_1_x_max", 2.0)]);
    job.extend([("aabb_0_y_min", -1.0), ("aabb_0_y_max", 1.0), ("aabb_0_z_min", -1.0), ("aabb_0_z_max", 1.0)]);
    job.extend([("aabb_1_y_min", -1.0), ("aabb_1_y_max", 1.0), ("aabb_1_z_min", -1.0), ("aabb_1_z_max", 1.0)]);
    job.extend([("aabb_2_x_min", 1.0), ("aabb_2_x_max", -1.0), ("aabb_3_x_min", 1.0), ("aabb_3_x_max", -1.0)]);
    let ports = ["is_intersect", "tmin_0", "tmin_1", "box_index_0", "box_index_1"];
    let of = |rules| outcome(&Datapath::paper(Config::DEFAULT.rules(rules)), "quadbox", &job, ports);
    assert_eq!(of(Rules::Paper), [0b0011, bits(1.0), bits(3.0), 1, 0]);
    // The original misses the flat box.
    assert_eq!(of(Rules::Chisel)[..2], [0b0001, bits(1.0)]);
}

/// 4097² is a tie, which goes to even, and is inexact; ∞ − ∞ in a lane is invalid.
#[test]
fn sums_and_exceptions_by_hand() {
    let config = Config::DEFAULT.lanes(Lanes::Two).exception_flags(true);
    let ports = ["angular_dot_product", "exception_flags"];
    let pair = |a: f32, b: f32| [("euclidean_a_0", a), ("euclidean_b_0", b)];
    let datapath = Datapath::paper(config);
    assert_eq!(outcome(&datapath, "angular", &pair(4097.0, 4097.0), ports), [bits(16_785_408.0), 1]);
    let ports = ["euclidean_accumulator", "exception_flags"];
    let infinities = pair(f32::INFINITY, f32::INFINITY);
    assert_eq!(outcome(&datapath, "euclidean", &infinities, ports), [0x7fc0_0000, 8]);
    assert_eq!(outcome(&datapath, "euclidean", &pair(1e30, 0.0), ports), [bits(f32::INFINITY), 5]);
    assert_eq!(outcome(&datapath, "euclidean", &pair(1e-22, 0.0), ports)[1], 3);
}
