//! What a format costs: the operations in the format, in software, against the same operations in binary64.
//!
//! Every job runs three times: in the format, on inputs rounded into it; in binary64, on the same rounded inputs; and in
//! binary64, on the inputs as they were. The first against the second is what the arithmetic costs; the first against
//! the third is what the format costs. Rays are derived (inverse, shear) in binary64 and rounded last, as a host does.
//!
//! Nothing here depends on the machine, so a table is reproducible to the last digit.

mod errors;
mod host;
mod random;
mod scene;
mod table;

pub use errors::{Errors, Quantiles};
use host::HostJob;
pub use random::DIMENSIONS;
use random::RandomJobs;
use raypath_float::Format;
use raypath_model::{Binary64, Double, Functional, Soft, SoftNumber};
use raypath_ops::{Concrete, Outcome, Rules};
pub use scene::RAYS;
use std::fmt;
use std::ops::RangeInclusive;
pub use table::table;

/// A result that is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Where a ray enters a box that it hits.
    BoxEntry,
    /// Where a ray hits a triangle: `t_num / t_denom`, divided in binary64.
    TriangleDistance,
    /// Where a ray hits a mesh: the nearest of the triangles whose boxes it hits, both in the format.
    Pixel,
    /// The Euclidean distance of two vectors, squared.
    EuclideanSum,
    /// The dot product of two vectors.
    DotProduct,
    /// The squared norm of a vector.
    Norm,
}

/// What one format costs one result.
#[derive(Debug, Clone)]
pub struct Row {
    /// The format.
    pub format: Format,
    /// The result.
    pub quantity: Quantity,
    /// Against binary64 on the inputs rounded into the format.
    pub on_rounded: Errors,
    /// Against binary64 on the inputs as they were.
    pub on_original: Errors,
}

/// A measurement: a format, and what to measure it with.
#[derive(Debug, Clone, Copy)]
pub struct Accuracy {
    /// The format.
    pub format: Format,
    /// The rules on the edges.
    pub rules: Rules,
    /// A factor on all coordinates, within [`SCALES`]: a format of a short range suffers from large and small scenes.
    pub scale: f64,
}

/// Scales that keep products of coordinates far inside the range of binary64; with others it is no reference.
pub const SCALES: RangeInclusive<f64> = 1e-30..=1e30;

impl Accuracy {
    /// Measures `rounds` random jobs of each kind, the same for every format, reproducible by `seed`; a distance is one
    /// job here, of vectors of [`DIMENSIONS`] dimensions. After each round `watch` says whether to go on.
    pub fn random_jobs(self, seed: u64, rounds: u32, mut watch: impl FnMut() -> bool) -> Vec<Row> {
        let mut measurement = Measurement::new(self);
        let mut jobs = RandomJobs::new(seed);
        for _ in 0..rounds {
            for job in jobs.round() {
                measurement.run(&job);
            }
            if !watch() {
                break;
            }
        }
        measurement.finish()
    }

    /// Measures a scene as a ray tracer would see it: [`RAYS`] rays of a camera against the boxes around the triangles
    /// of a torus, and against the triangles whose boxes are hit. After each ray `watch` says whether to go on.
    pub fn scene(self, mut watch: impl FnMut() -> bool) -> Vec<Row> {
        let mut measurement = Measurement::new(self);
        let triangles = scene::triangles();
        let (groups, _) = triangles.as_chunks::<4>();
        for ray in scene::rays() {
            let mut nearest = Answer::MISS;
            for group in groups {
                let boxes = measurement.run(&HostJob::Quadbox { ray, boxes: group.map(scene::bounds) });
                for (vertices, entered) in group.iter().zip(boxes) {
                    if entered != Answer::MISS {
                        let hit = measurement.run(&HostJob::Triangle { ray, vertices: *vertices });
                        hit.into_iter().for_each(|hit| nearest.keep_nearer(hit.where_also(entered)));
                    }
                }
            }
            measurement.add(Quantity::Pixel, nearest);
            if !watch() {
                break;
            }
        }
        measurement.finish()
    }
}

impl Quantity {
    /// All of them, in the order of rows.
    pub const ALL: [Self; 6] =
        [Self::BoxEntry, Self::TriangleDistance, Self::Pixel, Self::EuclideanSum, Self::DotProduct, Self::Norm];

    /// Whether there may be no such result: a ray may miss, a sum may not.
    pub fn may_miss(self) -> bool {
        matches!(self, Self::BoxEntry | Self::TriangleDistance | Self::Pixel)
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::BoxEntry => "box tmin",
            Self::TriangleDistance => "triangle t",
            Self::Pixel => "pixel t",
            Self::EuclideanSum => "euclidean",
            Self::DotProduct => "angular dot",
            Self::Norm => "angular norm",
        })
    }
}

/// A result three times; `None` is a miss.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Answer {
    in_format: Option<f64>,
    on_rounded: Option<f64>,
    on_original: Option<f64>,
}

impl Answer {
    const MISS: Self = Self { in_format: None, on_rounded: None, on_original: None };

    fn map_with(self, other: Self, f: impl Fn(Option<f64>, Option<f64>) -> Option<f64>) -> Self {
        Self {
            in_format: f(self.in_format, other.in_format),
            on_rounded: f(self.on_rounded, other.on_rounded),
            on_original: f(self.on_original, other.on_original),
        }
    }

    /// A miss where `other` is one.
    fn where_also(self, other: Self) -> Self {
        self.map_with(other, |hit, other| other.and(hit))
    }

    fn keep_nearer(&mut self, other: Self) {
        *self = self.map_with(other, |hit, other| match (hit, other) {
            (Some(hit), Some(other)) => Some(hit.min(other)),
            _ => hit.or(other),
        });
    }
}

/// The three datapaths, and what was found.
struct Measurement {
    format: Format,
    scale: f64,
    in_format: Functional<16, 8, Soft>,
    on_rounded: Functional<16, 8, Binary64>,
    on_original: Functional<16, 8, Binary64>,
    /// One of each quantity, in the order of [`Quantity::ALL`].
    rows: [Row; 6],
}

impl Measurement {
    fn new(Accuracy { format, rules, scale }: Accuracy) -> Self {
        let row = |quantity| Row { format, quantity, on_rounded: Errors::default(), on_original: Errors::default() };
        Self {
            format,
            scale,
            in_format: Functional::over(Soft { format }, rules),
            on_rounded: Functional::over(Binary64, rules),
            on_original: Functional::over(Binary64, rules),
            rows: Quantity::ALL.map(row),
        }
    }

    /// Runs a job three times, notes its results, and gives them: four for boxes, one for a triangle, none for a beat
    /// that is not the last.
    fn run(&mut self, job: &HostJob) -> Vec<Answer> {
        let Self { format, scale, .. } = *self;
        let rounded = |x| Double(format.to_f64(format.from_f64(x)));
        let in_format = self.in_format.run(&job.job(scale, Soft { format }, |x| SoftNumber(format.from_f64(x))));
        let on_rounded = self.on_rounded.run(&job.job(scale, Binary64, rounded));
        let on_original = self.on_original.run(&job.job(scale, Binary64, Double));
        let in_format = results(&in_format, |number| format.to_f64(number.0));
        let on_rounded = results(&on_rounded, |number| number.0);
        let on_original = results(&on_original, |number| number.0);
        let together = in_format.into_iter().zip(on_rounded).zip(on_original);
        together
            .map(|(((quantity, in_format), (_, on_rounded)), (_, on_original))| {
                let answer = Answer { in_format, on_rounded, on_original };
                self.add(quantity, answer);
                answer
            })
            .collect()
    }

    fn add(&mut self, quantity: Quantity, answer: Answer) {
        let row = &mut self.rows[quantity as usize];
        row.on_rounded.add(self.format, answer.in_format, answer.on_rounded);
        row.on_original.add(self.format, answer.in_format, answer.on_original);
    }

    /// The rows of what was measured.
    fn finish(self) -> Vec<Row> {
        self.rows.into_iter().filter(|row| row.on_original.results > 0).collect()
    }
}

/// The results of a job, those of boxes in the order of the boxes.
fn results<C: Concrete>(outcome: &Outcome<C>, number: impl Fn(C::Num) -> f64) -> Vec<(Quantity, Option<f64>)> {
    match outcome {
        Outcome::Quadbox(output) => {
            let entry = |index: u32| {
                let place = (0..4).find(|&place| output.box_index[place].value == index)?;
                output.is_intersect.0[place].value.then(|| number(output.tmin[place].value))
            };
            (0..4).map(|index| (Quantity::BoxEntry, entry(index))).collect()
        }
        Outcome::Triangle(output) => {
            let distance = || number(output.t_num.value) / number(output.t_denom.value);
            vec![(Quantity::TriangleDistance, output.triangle_hit.value.then(distance))]
        }
        Outcome::Euclidean(output) if output.euclidean_reset_accum.value => {
            vec![(Quantity::EuclideanSum, Some(number(output.euclidean_accumulator.value)))]
        }
        Outcome::Angular(output) if output.angular_reset_accum.value => {
            let sums = [(Quantity::DotProduct, output.angular_dot_product), (Quantity::Norm, output.angular_norm)];
            sums.map(|(quantity, sum)| (quantity, Some(number(sum.value)))).to_vec()
        }
        Outcome::Euclidean(_) | Outcome::Angular(_) => Vec::new(),
    }
}
