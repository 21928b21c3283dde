//! The accuracy of a number format: compares operations in the format, run in software, with binary64.
//!
//! Every job runs three times: in the format, on inputs rounded to it; in binary64, on the same rounded inputs; and in
//! binary64, on the original inputs. Comparing the first with the second gives the error of the arithmetic, comparing
//! it with the third the error of the format. Rays are derived (inverse, shear) in binary64 and rounded last, as a host
//! does.
//!
//! The results do not depend on the machine: a table is reproducible to the last digit.

mod host;
mod random;
mod scene;
mod table;

use host::{HostJob, Rounding, quadbox, triangle};
pub use random::DIMENSIONS;
use random::RandomJobs;
use raypath_float::Format;
use raypath_model::{Binary64, Functional, Soft};
use raypath_ops::{Concrete, Outcome, Rules};
pub use scene::RAYS;
use std::fmt;
use std::ops::RangeInclusive;
pub use table::{Errors, Quantiles, table};

/// A result whose error is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// The distance at which a ray enters a box that it hits.
    BoxEntry,
    /// The distance at which a ray hits a triangle: `t_num / t_denom`, divided in binary64.
    TriangleDistance,
    /// The distance at which a ray hits a mesh: the least of the triangles whose boxes it hits.
    Pixel,
    /// The squared Euclidean distance of two vectors.
    EuclideanSum,
    /// The dot product of two vectors.
    DotProduct,
    /// The squared norm of a vector.
    Norm,
}

/// The errors of a result in a format.
#[derive(Debug, Clone)]
pub struct Row {
    /// The format.
    pub format: Format,
    /// The result that is measured.
    pub quantity: Quantity,
    /// Compared with binary64 on the inputs rounded to the format.
    pub on_rounded: Errors,
    /// Compared with binary64 on the original inputs.
    pub on_original: Errors,
}

/// The parameters of a measurement.
#[derive(Debug, Clone, Copy)]
pub struct Accuracy {
    /// The format.
    pub format: Format,
    /// The rule set for edge cases.
    pub rules: Rules,
    /// A factor on all coordinates, within [`SCALES`], to test the range of a format.
    pub scale: f64,
}

/// The scales for which products of coordinates stay far inside the range of binary64, the reference.
pub const SCALES: RangeInclusive<f64> = 1e-30..=1e30;

impl Accuracy {
    /// Measures `rounds` random jobs of each kind, the same for every format, reproducible by `seed`. Distance jobs
    /// have vectors of [`DIMENSIONS`] dimensions. `proceed` is called after each round; false ends the measurement.
    pub fn random_jobs(self, seed: u64, rounds: u32, mut proceed: impl FnMut() -> bool) -> Vec<Row> {
        let mut measurement = Measurement::new(self);
        let mut jobs = RandomJobs::new(seed, self.scale);
        for _ in 0..rounds {
            for job in jobs.round() {
                measurement.run(&job);
            }
            if !proceed() {
                break;
            }
        }
        measurement.finish()
    }

    /// Measures a scene: [`RAYS`] rays of a camera against the boxes around the triangles of a torus, and against the
    /// triangles whose boxes are hit. `proceed` is called after each ray; false ends the measurement.
    pub fn scene(self, mut proceed: impl FnMut() -> bool) -> Vec<Row> {
        let mut measurement = Measurement::new(self);
        let triangles = scene::triangles(self.scale);
        let (groups, _) = triangles.as_chunks::<4>();
        for ray in scene::rays(self.scale) {
            let mut nearest = MISS;
            for group in groups {
                let boxes = measurement.run(&quadbox(ray, group.map(scene::bounds)));
                for (vertices, entered) in group.iter().zip(boxes) {
                    if entered != MISS {
                        let hit = measurement.run(&triangle(ray, *vertices));
                        for (run, hit) in hit.iter().flat_map(|hit| hit.iter().enumerate()) {
                            let hit = entered[run].and(*hit);
                            nearest[run] = nearest[run].into_iter().chain(hit).reduce(f64::min);
                        }
                    }
                }
            }
            measurement.add(Quantity::Pixel, nearest);
            if !proceed() {
                break;
            }
        }
        measurement.finish()
    }
}

impl Quantity {
    /// All results, in the order of rows.
    pub const ALL: [Self; 6] =
        [Self::BoxEntry, Self::TriangleDistance, Self::Pixel, Self::EuclideanSum, Self::DotProduct, Self::Norm];

    /// Whether a job may have no such result: a ray may miss, a sum always exists.
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

/// A result of the three runs: in the format, in binary64 on rounded inputs and on original ones. `None` is a miss.
type Answer = [Option<f64>; 3];

const MISS: Answer = [None; 3];

/// The three datapaths, and the errors so far.
struct Measurement {
    format: Format,
    rounding: Rounding,
    in_format: Functional<16, 8, Soft>,
    on_rounded: Functional<16, 8, Binary64>,
    on_original: Functional<16, 8, Binary64>,
    /// A row for each quantity, in the order of [`Quantity::ALL`].
    rows: [Row; 6],
}

impl Measurement {
    fn new(Accuracy { format, rules, .. }: Accuracy) -> Self {
        let row = |quantity| Row { format, quantity, on_rounded: Errors::default(), on_original: Errors::default() };
        Self {
            format,
            rounding: Rounding::new(),
            in_format: Functional::over(Soft { format }, rules),
            on_rounded: Functional::over(Binary64, rules),
            on_original: Functional::over(Binary64, rules),
            rows: Quantity::ALL.map(row),
        }
    }

    /// Runs a job three times, adds its results to the rows and returns them: four for boxes, one for a triangle, none
    /// for a beat that is not the last.
    fn run(&mut self, job: &HostJob) -> Vec<Answer> {
        let Self { format, rounding, .. } = self;
        let format = *format;
        let in_format = rounding.job(job, Soft { format }, |x| format.from_f64(x));
        let on_rounded = rounding.job(job, Binary64, |x| format.to_f64(format.from_f64(x)).to_bits());
        let in_format = self.in_format.run(&in_format);
        let on_rounded = self.on_rounded.run(&on_rounded);
        let on_original = self.on_original.run(job);
        let in_format = results(&in_format, |number| format.to_f64(number.0));
        let on_rounded = results(&on_rounded, |number| number.0);
        let on_original = results(&on_original, |number| number.0);
        let together = in_format.into_iter().zip(on_rounded).zip(on_original);
        together
            .map(|(((quantity, in_format), (_, on_rounded)), (_, on_original))| {
                let answer = [in_format, on_rounded, on_original];
                self.add(quantity, answer);
                answer
            })
            .collect()
    }

    fn add(&mut self, quantity: Quantity, [in_format, on_rounded, on_original]: Answer) {
        let row = &mut self.rows[quantity as usize];
        row.on_rounded.add(self.format, in_format, on_rounded);
        row.on_original.add(self.format, in_format, on_original);
    }

    /// The rows that have results.
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
