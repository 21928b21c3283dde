//! The operations in software arithmetic and in binary64, compared with native binary32: bit by bit in binary32, and in
//! other formats for values that need no rounding.

use crate::common::EDGES;
use fearless_simd::prelude::*;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_float::Format;
use raypath_model::{Binary64, Functional, ModelCircuit, Register, ShortFormat, Soft, SoftNumber};
use raypath_ops::{
    Aabb, Binary32, BoxBits, Circuit, Concrete, Job, JobKind, Outcome, PortKind, PortValue, Ray, RayBoxInput,
    RayTriangleInput, Relation, Rules, Test, Triangle,
};
use std::collections::BTreeMap;
use std::num::FpCategory;

/// All comparisons and tests, on pairs of special values.
#[test]
fn circuits_agree() {
    agree(Soft { format: Format::BINARY32 }, |number| number.to_bits().into());
    agree(Binary64, |number| f64::from(number).to_bits());
}

fn agree<C: Concrete>(circuit: C, code: impl Fn(f32) -> u64) {
    let host = Binary32;
    let relations =
        [Relation::Less, Relation::LessOrEqual, Relation::Equal, Relation::GreaterOrEqual, Relation::Greater];
    let tests =
        [Test::SignBit, Test::Zero, Test::Nan, Test::AtLeastZero, Test::AboveZero, Test::AtMostZero, Test::BelowZero];
    for a in EDGES {
        let (x, a) = (f32::from_bits(a), host.number(a.into()));
        let own = circuit.number(code(x));
        assert_eq!((circuit.raw_bits(own), circuit.bits(own)), (code(x), canonical(code(x), circuit)));
        assert_eq!(circuit.bits(circuit.negate(own)), canonical(code(-x), circuit), "{x:e} negated");
        for test in tests {
            assert_eq!(circuit.test(test, own), host.test(test, a), "{test:?} of {x:e}");
        }
        for b in EDGES {
            let (y, b) = (f32::from_bits(b), host.number(b.into()));
            let order = circuit.compare(own, circuit.number(code(y)));
            for relation in relations {
                let expected = host.relation(host.compare(a, b), relation);
                assert_eq!(circuit.relation(order, relation), expected, "{relation:?}: {x:e}, {y:e}");
            }
        }
    }
    for (a, b) in [(0, 0), (0, 1), (1, 0), (3, 3), (2, 3), (3, 2)] {
        assert_eq!(circuit.word_equal(a, b), host.word_equal(a, b), "{a} = {b}");
        assert_eq!(circuit.word_less(a, b), host.word_less(a, b), "{a} < {b}");
    }
    for constant in [0.0, f32::INFINITY] {
        assert_eq!(circuit.bits(circuit.constant(constant)), code(constant));
    }
}

/// `code`, or the canonical NaN of the circuit if it is a NaN.
fn canonical<C: Concrete>(code: u64, circuit: C) -> u64 {
    let infinity = circuit.constant(f32::INFINITY);
    let is_nan = circuit.test(Test::Nan, circuit.number(code));
    if is_nan { circuit.bits(circuit.subtract(infinity, infinity)) } else { code }
}

const RULES: [Rules; 4] = [Rules::Paper, Rules::Chisel, Rules::Bounds(BoxBits(8)), Rules::Bounds(BoxBits::DEFAULT)];

#[test]
fn soft_binary32_is_binary32() {
    const JOBS: usize = 50_000;
    let soft = Soft { format: Format::BINARY32 };
    for rules in RULES {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (mut host, mut in_software) = (Functional::<16, 8>::new(rules), Functional::<16, 8, _>::over(soft, rules));
        let mut seen = Seen::new();
        for _ in 0..JOBS {
            let job = job(&mut rng);
            let inputs = job.ports();
            let mut input = in_order(&inputs);
            let same = Job::from_ports_in(soft, job.kind(), |name| input(name).bits);
            let expected = host.run(&job);
            assert_eq!(in_software.run(&same).ports(), expected.ports(), "{job:?}");
            count(&mut seen, &expected);
        }
        // All kinds of outcomes must occur.
        assert!(seen.len() == 7 && seen.values().all(|&count| count >= JOBS / 1000), "{seen:?}");
    }
}

/// Lanes of a short format give the codes of software arithmetic, for all pairs of an 8-bit format, and in others for
/// random ones, of which half have products about the least normal number.
#[test]
fn lanes_round_to_short_formats() {
    for (e, s) in [(4, 4), (5, 3), (3, 5), (5, 11), (8, 8), (7, 11), (8, 3), (8, 10), (8, 11)] {
        let format = Format::new(e, s).expect("a format");
        let lanes = ShortFormat::lanes(format).expect("a short format");
        let soft = Soft { format };
        let codes = 1_u64 << (e + s);
        let number = |code: u64| Register(SimdFrom::simd_from(lanes.simd(), format.to_f64(code) as f32));
        let mut random = ChaCha8Rng::seed_from_u64(3);
        for pair in 0..if codes == 256 { 1 << 16 } else { 1 << 19 } {
            let (mut a, mut b) = (pair / 256, pair % 256);
            if codes > 256 {
                (a, b) = (random.random_range(0..codes), random.random_range(0..codes));
                let (low, bias) = ((1 << (s - 1)) - 1, (1 << (e - 1)) - 1);
                let below = random.random_range(0..u64::from(s) + 2) + (a >> (s - 1)) % (1 << e);
                if below <= bias + 1 && random.random() {
                    b = (bias + 1 - below) << (s - 1) | b & low;
                }
            }
            let (x, y) = (number(a), number(b));
            let (own, other) = (SoftNumber(a), SoftNumber(b));
            for (found, expected) in [
                (lanes.add(x, y), soft.add(own, other)),
                (lanes.subtract(x, y), soft.subtract(own, other)),
                (lanes.multiply(x, y), soft.multiply(own, other)),
            ] {
                let (found, expected) = (found.0.as_slice()[0], format.to_f64(expected.0) as f32);
                let is_same = found.to_bits() == expected.to_bits() || found.is_nan() && expected.is_nan();
                assert!(is_same, "{format}: {a:#x}, {b:#x} give {found:e}, expected {expected:e}");
            }
        }
    }
    assert!(ShortFormat::lanes(Format::BINARY32).is_none());
}

/// The results for zeros, ones, infinities and NaN are exact in all of these formats.
#[test]
fn formats_agree_on_exact_results() {
    let widest = Format::new(11, 24).expect("a format");
    for rules in [Rules::Paper, Rules::Chisel] {
        for format in [Format::TF32, Format::BFLOAT16, Format::BINARY16, widest] {
            agree_exactly(Soft { format }, rules, |number| format.from_f32(number), |code| format.to_f64(code));
        }
        agree_exactly(Binary64, rules, |number| f64::from(number).to_bits(), f64::from_bits);
    }
}

fn agree_exactly<C: ModelCircuit>(circuit: C, rules: Rules, code: impl Fn(f32) -> u64, number: impl Fn(u64) -> f64) {
    const JOBS: usize = 20_000;
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let (mut host, mut other) = (Functional::<16, 8>::new(rules), Functional::<16, 8, _>::over(circuit, rules));
    let mut seen = Seen::new();
    for _ in 0..JOBS {
        let kind = JobKind::ALL[rng.random_range(0..4)];
        let specials = [0.0, 0.1][rng.random_range(0..2)];
        let along_z = rng.random_bool(0.5);
        let job: Job = Job::from_ports(kind, |port| match port {
            "ray_kx" if along_z => 0,
            "ray_ky" if along_z => 1,
            "ray_kz" if along_z => 2,
            "ray_kx" | "ray_ky" | "ray_kz" | "euclidean_mask" => rng.random(),
            "euclidean_reset_accum" => 1,
            port if port.starts_with("ray_origin") => 0,
            "ray_shear_x" | "ray_shear_y" if along_z => 0,
            _ if rng.random_bool(specials) => EDGES[rng.random_range(12..16)].into(),
            _ => [0.0, -0.0, 1.0, -1.0_f32][rng.random_range(0..4)].to_bits().into(),
        });
        let inputs = job.ports();
        let mut input = in_order(&inputs);
        let same = Job::from_ports_in(circuit, kind, |name| match input(name) {
            PortValue { kind: PortKind::Number, bits, .. } => code(f32::from_bits(*bits as u32)),
            port => port.bits,
        });
        let expected = host.run(&job);
        let widened = values(&expected, |bits| f32::from_bits(bits as u32).into());
        assert_eq!(values(&other.run(&same), &number), widened, "{circuit:?}: {job:?}");
        count(&mut seen, &expected);
    }
    seen.remove("subnormals");
    assert!(seen.len() == 6 && seen.values().all(|&count| count >= JOBS / 1000), "{seen:?}");
}

/// Returns a port by name. Ports are requested in the order of the list, flags once for each bit.
fn in_order<'p>(ports: &'p [PortValue]) -> impl FnMut(&str) -> &'p PortValue {
    let mut place = 0;
    move |name| {
        while ports[place].name != name {
            place += 1;
        }
        &ports[place]
    }
}

/// The port values of an outcome, with numbers in binary64 and one code for all NaNs.
fn values<C: Concrete>(outcome: &Outcome<C>, number: impl Fn(u64) -> f64) -> Vec<(String, u64)> {
    let bits = |port: &PortValue| match port.kind {
        PortKind::Number if number(port.bits).is_nan() => f64::NAN.to_bits(),
        PortKind::Number => number(port.bits).to_bits(),
        PortKind::Flags | PortKind::Word => port.bits,
    };
    outcome.ports().into_iter().map(|port| (port.name.clone(), bits(&port))).collect()
}

/// A job with a ray aimed at boxes or a triangle, or with random port values, many of them special.
fn job(rng: &mut ChaCha8Rng) -> Job {
    let kind = JobKind::ALL[rng.random_range(0..4)];
    let mut point = |reach: f32| -> [f32; 3] { std::array::from_fn(|_| rng.random_range(-reach..reach)) };
    let (origin, a, b, c) = (point(4.0), point(1.0), point(1.0), point(1.0));
    let boxes: [[f32; 3]; 8] = std::array::from_fn(|_| point(1.0));
    let direction = std::array::from_fn(|axis| (a[axis] + b[axis] + c[axis]) / 3.0 - origin[axis]);
    match (kind, Ray::new(origin, direction, 2.0)) {
        (JobKind::Triangle, Ok(ray)) if rng.random() => {
            Job::Triangle(RayTriangleInput { ray, triangle: Triangle::new(a, b, c) })
        }
        (JobKind::Quadbox, Ok(ray)) if rng.random() => {
            let corners = |i: usize| {
                let (p, q) = (boxes[2 * i], boxes[2 * i + 1]);
                Aabb::new(std::array::from_fn(|k| p[k].min(q[k])), std::array::from_fn(|k| p[k].max(q[k])))
            };
            Job::Quadbox(RayBoxInput { ray, aabb: std::array::from_fn(corners) })
        }
        _ => {
            let edges = [0.01, 0.1, 0.5][rng.random_range(0..3)];
            Job::from_ports(kind, |port| match port {
                "ray_kx" | "ray_ky" | "ray_kz" => rng.random_range(0..4),
                "euclidean_reset_accum" => rng.random_bool(0.3).into(),
                _ if rng.random_bool(edges) => EDGES[rng.random_range(0..EDGES.len())].into(),
                _ if rng.random_bool(0.05) => rng.random(),
                _ => rng.random_range(-1.0_f32..1.0).to_bits().into(),
            })
        }
    }
}

/// The number of outcomes of each kind.
type Seen = BTreeMap<&'static str, usize>;

fn count(seen: &mut Seen, outcome: &Outcome) {
    let mut add = |what, count| *seen.entry(what).or_default() += count;
    match outcome {
        Outcome::Quadbox(output) => {
            let hits = output.is_intersect.to_array().into_iter().filter(|hit| *hit).count();
            add("box hits", hits);
            return add("box misses", 4 - hits);
        }
        Outcome::Triangle(output) if output.triangle_hit.into() => add("triangle hits", 1),
        Outcome::Triangle(_) => add("triangle misses", 1),
        Outcome::Euclidean(_) | Outcome::Angular(_) => {}
    }
    for port in outcome.ports().iter().filter(|port| port.kind == PortKind::Number) {
        match f32::from_bits(port.bits as u32).classify() {
            FpCategory::Nan => add("NaNs", 1),
            FpCategory::Infinite => add("infinities", 1),
            FpCategory::Subnormal => add("subnormals", 1),
            FpCategory::Zero | FpCategory::Normal => {}
        }
    }
}
