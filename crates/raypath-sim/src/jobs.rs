//! Random jobs: scenes in which rays are aimed at boxes and triangles, and numbers at the limits of the format.

use crate::numbers::edges;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_float::Format;
use raypath_model::{OperationId, WordModel, Words};
use raypath_ops::{Aabb, Job, JobKind, Port, PortKind, Ray, RayBoxInput, RayTriangleInput, Triangle};
use std::collections::HashMap;

/// An endless stream of jobs of the paper's operations `kinds`, reproducible by `seed`. The model must have these
/// operations, in numbers of `format`; `kinds` must not be empty.
///
/// Three quarters of the rays come from a scene of any size, sometimes on a grid, rounded to the format. In half of
/// these jobs, some numbers are replaced by NaN, by [edge values](edges) or by other numbers of the job, which makes
/// differences zero. The ports of the other jobs are drawn one by one.
pub fn random(model: &WordModel, format: Format, seed: u64, kinds: &[JobKind]) -> impl Iterator<Item = Words> + use<> {
    let rng = ChaCha8Rng::seed_from_u64(seed);
    let kinds = kinds.iter().filter_map(|&paper| Some((paper, model.kind(paper.name())?))).collect();
    let mut generator = Generator { model: model.clone(), format, rng, kinds };
    std::iter::repeat_with(move || generator.job())
}

/// An endless stream of jobs of all operations of a model, each an [`any_job`], reproducible by `seed`.
pub fn any_jobs(model: WordModel, seed: u64) -> impl Iterator<Item = Words> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let kinds = model.kinds();
    std::iter::repeat_with(move || {
        let kind = kinds[rng.random_range(0..kinds.len())];
        any_job(&model, kind, &mut rng)
    })
}

/// A job whose ports are drawn one by one. In a quarter of the jobs half of the numbers are [edge values](edges). In
/// another quarter most numbers are small integers, of which many are equal. A few numbers have random bits.
pub fn any_job(model: &WordModel, kind: OperationId, rng: &mut ChaCha8Rng) -> Words {
    job_by_ports(model, kind, rng, |_, _| None)
}

/// As [`any_job`], except for the ports for which `value` returns a value.
fn job_by_ports(
    model: &WordModel,
    kind: OperationId,
    rng: &mut ChaCha8Rng,
    value: impl Fn(&str, &mut ChaCha8Rng) -> Option<u64>,
) -> Words {
    let chances = [(0.5, false), (0.05, false), (0.01, false), (0.1, true)][rng.random_range(0..4)];
    let word = |port: &Port| value(&port.name, rng).unwrap_or_else(|| any_value(port, model.format(), chances, rng));
    let words: Vec<u64> = model.inputs(kind).iter().map(word).collect();
    model.job_of_words(kind, &words)
}

fn any_value(port: &Port, format: Format, (at_edges, are_whole): (f64, bool), rng: &mut ChaCha8Rng) -> u64 {
    match port.kind {
        // Half of the masks are full.
        PortKind::Flags if port.width > Some(1) && rng.random_bool(0.5) => u64::MAX,
        PortKind::Flags | PortKind::Word => rng.random(),
        PortKind::Number if rng.random_bool(at_edges) => {
            let edges = edges(format);
            edges[rng.random_range(0..edges.len())]
        }
        PortKind::Number if are_whole => format.from_f32(rng.random_range(-2i8..=2).into()),
        PortKind::Number if rng.random_bool(0.05) => rng.random(),
        PortKind::Number => format.from_f32(rng.random_range(-1.0f32..1.0)),
    }
}

struct Generator {
    model: WordModel,
    format: Format,
    rng: ChaCha8Rng,
    kinds: Vec<(JobKind, OperationId)>,
}

impl Generator {
    fn job(&mut self) -> Words {
        let (paper, kind) = self.kinds[self.rng.random_range(0..self.kinds.len())];
        match paper {
            JobKind::Triangle | JobKind::Quadbox if self.rng.random_bool(0.75) => {
                let scene = self.scene(paper);
                self.rounded(kind, &scene)
            }
            _ => job_by_ports(&self.model, kind, &mut self.rng, |port, rng| match port {
                "ray_kx" | "ray_ky" | "ray_kz" => Some(rng.random_range(0..4)),
                "euclidean_reset_accum" => Some(rng.random_bool(0.1).into()),
                _ => None,
            }),
        }
    }

    /// A ray aimed at one of the boxes, or at a point in or near the triangle, at any scale. On a grid, rays run along
    /// axes, in faces and through corners, which gives zeros of both signs, ties, and zero times infinity.
    fn scene(&mut self, kind: JobKind) -> Job {
        let size = if self.rng.random_bool(0.2) { self.rng.random_range(-70.0f32..60.0).round().exp2() } else { 1.0 };
        let grid = self.rng.random_bool(0.25).then_some(0.5 * size);
        let snap = |point: [f32; 3]| point.map(|x| grid.map_or(x, |grid| (x / grid).round() * grid));
        let reach = if grid.is_some() { size } else { 4.0 * size };
        let [origin, a, b, c] = [reach, size, size, size].map(|reach| snap(self.point(reach)));
        let [u, v, w]: [f32; 3] = std::array::from_fn(|_| self.rng.random_range(-0.1..1.0));
        let target: [f32; 3] = std::array::from_fn(|i| (u * a[i] + v * b[i] + w * c[i]) / (u + v + w));
        let target = if grid.is_some() { a } else { target };
        let direction: [f32; 3] = std::array::from_fn(|i| target[i] - origin[i]);
        let extent = if self.rng.random_bool(0.8) { f32::INFINITY } else { self.rng.random_range(0.0..2.0) * size };
        // An invalid ray is rare: it has a direction of zero, or u + v + w was zero. Try another scene.
        let Ok(ray) = Ray::new(origin, direction, extent) else { return self.scene(kind) };
        if kind == JobKind::Triangle {
            return Job::Triangle(RayTriangleInput { ray, triangle: Triangle::new(a, b, c) });
        }
        // Most boxes are placed on the ray, because a ray rarely hits more than two of four random boxes.
        let aabb = std::array::from_fn(|_| {
            let (mut centre, half) = (snap(self.point(size)), snap(self.point(0.5 * size)).map(f32::abs));
            if grid.is_none() && self.rng.random_bool(0.7) {
                let along = self.rng.random_range(0.2..2.0);
                let off: [f32; 3] = self.point(0.5);
                centre = std::array::from_fn(|i| origin[i] + along * direction[i] + half[i] * off[i]);
            }
            Aabb::new(std::array::from_fn(|i| centre[i] - half[i]), std::array::from_fn(|i| centre[i] + half[i]))
        });
        Job::Quadbox(RayBoxInput { ray, aabb })
    }

    /// Converts a job in binary32 to a job of the model, with some special values.
    fn rounded(&mut self, kind: OperationId, job: &Job) -> Words {
        let value = |kind, bits: u64| match kind {
            PortKind::Number => self.format.from_f32(f32::from_bits(bits as u32)),
            PortKind::Flags | PortKind::Word => bits,
        };
        let mut ports = job.ports();
        ports.iter_mut().for_each(|port| port.bits = value(port.kind, port.bits));
        // An extent of NaN is compared with every box.
        for port in ports.iter_mut().filter(|port| port.name == "ray_extent") {
            if self.rng.random_bool(0.05) {
                port.bits = self.format.nan();
            }
        }
        // With an infinite inverse, boxes are hit at infinity, the distance of missed boxes.
        if self.rng.random_bool(0.05) {
            let minus = 1 << (self.format.ieee_width() - 1);
            for port in ports.iter_mut().filter(|port| port.name.starts_with("ray_inv_")) {
                port.bits = (port.bits & minus) | self.format.infinity();
            }
        }
        // Single special values among ordinary numbers, so that the result depends on the unit that gets them.
        let edges = edges(self.format);
        if self.rng.random_bool(0.5) {
            for _ in 0..self.rng.random_range(1..=ports.len().div_ceil(5)) {
                let [place, other] = [(); 2].map(|()| self.rng.random_range(0..ports.len()));
                if ports[place].kind == PortKind::Number && ports[other].kind == PortKind::Number {
                    ports[place].bits = match self.rng.random_range(0..4) {
                        0 => self.format.nan(),
                        1 => ports[other].bits,
                        _ => edges[self.rng.random_range(0..edges.len())],
                    };
                }
            }
        }
        let ports: HashMap<String, u64> = ports.into_iter().map(|port| (port.name, port.bits)).collect();
        let has_more = self.model.inputs(kind).len() > ports.len();
        let more = has_more.then(|| any_job(&self.model, kind, &mut self.rng));
        let added = |name: &str| more.as_ref().map_or(0, |job| job.port(name));
        self.model.job(kind, |name| ports.get(name).copied().unwrap_or_else(|| added(name)))
    }

    fn point(&mut self, reach: f32) -> [f32; 3] {
        std::array::from_fn(|_| self.rng.random_range(-reach..reach))
    }
}
