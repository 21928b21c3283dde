//! Random jobs that are worth running: scenes where rays are aimed at things, and numbers from the edges of the format.

use crate::numbers::edges;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_float::Format;
use raypath_model::{OperationId, WordModel, Words};
use raypath_ops::{Aabb, Job, JobKind, Port, PortKind, Ray, RayBoxInput, RayTriangleInput, Triangle};
use std::collections::HashMap;

/// An endless stream of jobs of the paper's operations `kinds`, which the model must have, in numbers of `format`,
/// reproducible by `seed`. Three quarters of the rays are from a scene of any size, sometimes on a grid, rounded to the
/// format. In half of these a few numbers are replaced by NaN, by edge values (zeros, subnormals, infinities), and by
/// other numbers of the job, so that differences are zero. Other jobs have small integers, or edge values and random
/// bits among ordinary numbers. `kinds` must not be empty.
pub fn random(model: &WordModel, format: Format, seed: u64, kinds: &[JobKind]) -> impl Iterator<Item = Words> + use<> {
    let rng = ChaCha8Rng::seed_from_u64(seed);
    let kinds = kinds.iter().filter_map(|&paper| Some((paper, model.kind(paper.name())?))).collect();
    let mut generator = Generator { model: model.clone(), format, edges: edges(format), rng, kinds };
    std::iter::repeat_with(move || generator.job())
}

/// An endless stream of jobs of all operations of a model, drawn port by port ([`any_job`]), reproducible by `seed`.
pub fn any_jobs(model: WordModel, seed: u64) -> impl Iterator<Item = Words> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let kinds = model.kinds();
    std::iter::repeat_with(move || {
        let kind = kinds[rng.random_range(0..kinds.len())];
        any_job(&model, kind, &mut rng)
    })
}

/// A job whose ports are drawn one by one: in one of four many of its numbers are from the format's edges (zeros,
/// subnormals, infinities, NaN), in one most are small whole numbers, of which many are equal; raw bits now and then.
pub fn any_job(model: &WordModel, kind: OperationId, rng: &mut ChaCha8Rng) -> Words {
    let mood = [(0.5, false), (0.05, false), (0.01, false), (0.1, true)][rng.random_range(0..4)];
    let words: Vec<u64> = model.inputs(kind).iter().map(|port| value(port, model.format(), mood, rng)).collect();
    model.job_of_words(kind, &words)
}

fn value(port: &Port, format: Format, (at_edges, are_whole): (f64, bool), rng: &mut ChaCha8Rng) -> u64 {
    match port.kind {
        // Half of the masks are full: what only a full one does is met as well.
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
    edges: [u64; 16],
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
            _ => self.ports(kind),
        }
    }

    /// A ray aimed at one of the boxes, or at a place in or near the triangle; some scenes are very small or very
    /// large. On a grid rays run along axes, in faces and through corners: zeros of both signs, ties, zero times
    /// infinity.
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
        // Only a direction of zero or a division by zero above is refused; any other scene will do instead.
        let Ok(ray) = Ray::new(origin, direction, extent) else { return self.scene(kind) };
        if kind == JobKind::Triangle {
            return Job::Triangle(RayTriangleInput { ray, triangle: Triangle::new(a, b, c) });
        }
        // Half of the boxes stand on the ray: of four boxes anywhere more than two are hardly ever hit.
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

    /// A job in binary32 as one of the model's.
    fn rounded(&mut self, kind: OperationId, job: &Job) -> Words {
        let value = |kind, bits: u64| match kind {
            PortKind::Number => self.number(f32::from_bits(bits as u32)),
            PortKind::Flags | PortKind::Word => bits,
        };
        let mut ports = job.ports();
        ports.iter_mut().for_each(|port| port.bits = value(port.kind, port.bits));
        // The extent meets every box.
        for port in ports.iter_mut().filter(|port| port.name == "ray_extent") {
            if self.rng.random_bool(0.05) {
                port.bits = self.format.nan();
            }
        }
        // Boxes are hit at infinity, as far away as those that are missed.
        if self.rng.random_bool(0.05) {
            let minus = 1 << (self.format.ieee_width() - 1);
            for port in ports.iter_mut().filter(|port| port.name.starts_with("ray_inv_")) {
                port.bits = (port.bits & minus) | self.format.infinity();
            }
        }
        // So that every unit meets each of them among ordinary numbers, and its answer to it is the one that decides.
        if self.rng.random_bool(0.5) {
            for _ in 0..self.rng.random_range(1..=ports.len().div_ceil(5)) {
                let [place, other] = [(); 2].map(|()| self.rng.random_range(0..ports.len()));
                if ports[place].kind == PortKind::Number && ports[other].kind == PortKind::Number {
                    ports[place].bits = match self.rng.random_range(0..4) {
                        0 => self.format.nan(),
                        1 => ports[other].bits,
                        _ => self.edges[self.rng.random_range(0..self.edges.len())],
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

    /// A job whose ports are drawn one by one. In a quarter of the jobs half of the numbers are edge values, in another
    /// quarter most are small integers, of which many are equal.
    fn ports(&mut self, kind: OperationId) -> Words {
        let (edges, are_whole) = [(0.5, false), (0.05, false), (0.01, false), (0.1, true)][self.rng.random_range(0..4)];
        let model = self.model.clone();
        let inputs = model.inputs(kind).iter();
        let words: Vec<u64> = inputs.map(|port| self.word(port, edges, are_whole)).collect();
        model.job_of_words(kind, &words)
    }

    fn word(&mut self, port: &Port, edges: f64, are_whole: bool) -> u64 {
        match port.name.as_str() {
            "ray_kx" | "ray_ky" | "ray_kz" => self.rng.random_range(0..4),
            "euclidean_mask" if self.rng.random_bool(0.5) => u64::MAX,
            "euclidean_reset_accum" => self.rng.random_bool(0.1).into(),
            _ if port.kind != PortKind::Number => self.rng.random(),
            _ if self.rng.random_bool(edges) => self.edges[self.rng.random_range(0..self.edges.len())],
            _ if are_whole => {
                let number = self.rng.random_range(-2i8..=2);
                self.number(number.into())
            }
            _ if self.rng.random_bool(0.05) => self.rng.random(),
            _ => {
                let number = self.rng.random_range(-1.0f32..1.0);
                self.number(number)
            }
        }
    }

    /// A number's bits in the format: the nearest.
    fn number(&self, number: f32) -> u64 {
        self.format.from_f32(number)
    }

    fn point(&mut self, reach: f32) -> [f32; 3] {
        std::array::from_fn(|_| self.rng.random_range(-reach..reach))
    }
}
