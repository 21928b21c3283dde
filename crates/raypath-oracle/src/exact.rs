//! The outcome of every job, written from the text of `docs/reference` alone, in exact arithmetic with one rounding for
//! each operation: all numbers of lanes, formats, rules, roundings, features and added operations.
//!
//! The oracle shares no function with the operations, the models or the units. A number is an integer times a power of
//! two; sums and products of two of them are exact in 128 bits.

mod added;
mod boxes;
mod distances;
mod inputs;
mod mistake;
mod number;
mod triangles;

use crate::layout::Layout;
use added::Sphere;
use boxes::{Entry, Slabs};
use distances::Totals;
use inputs::Inputs;
pub use mistake::Mistake;
pub use number::Arithmetic;
use number::Number;
use raypath_model::{WordModel, Words};
use raypath_rtl::Semantics;
use triangles::Triangle;

/// The oracle of a datapath, with the accumulators of its distances.
#[derive(Debug, Clone)]
pub struct Oracle {
    semantics: Semantics,
    /// The ports of jobs and outcomes; no outcome comes from the model.
    ports: WordModel,
    layout: Layout,
    arithmetic: Arithmetic,
    totals: Totals,
}

/// What an operation answers.
enum Answer {
    /// Boxes in the order of the outcome.
    Boxes(Vec<Entry>),
    Triangle(Triangle),
    Euclidean(Number),
    /// The dot product and the norm.
    Angular([Number; 2]),
    Child(u64),
    Inside(u64),
    Sphere(Sphere),
}

impl Oracle {
    /// The oracle of a datapath with these semantics, whose model has the ports. The accumulators are zero.
    pub fn new(semantics: Semantics, model: &WordModel) -> Self {
        Self {
            semantics,
            layout: Layout::of(model),
            ports: model.clone(),
            arithmetic: Arithmetic::new(semantics.format),
            totals: Totals::new(semantics.features.accumulators.count()),
        }
    }

    /// The same oracle with a deliberate mistake: a negative control.
    pub fn with(mut self, mistake: Mistake) -> Self {
        self.arithmetic.mistake = Some(mistake);
        self
    }

    /// The expected outcome of a job. A beat leaves its sum in an accumulator.
    ///
    /// # Errors
    /// The operation or a port of its outcome is unknown.
    pub fn run(&mut self, job: &Words) -> Result<Words, String> {
        let (kind, name) = (job.kind(), job.kind().name());
        self.arithmetic.raised.set(0);
        let inputs = Inputs::read(self.layout.fields(name), job.as_words(), &self.arithmetic);
        let answer = self.answer(name, &inputs).ok_or_else(|| format!("the oracle does not know {name}"))?;
        let mut unknown = None;
        let outcome = self.ports.outcome(kind, |port| match port {
            "exception_flags" => self.arithmetic.raised.get(),
            "tag" => inputs.tag,
            "euclidean_reset_accum" | "angular_reset_accum" => inputs.is_last.into(),
            port => answer.word(port, &self.arithmetic).unwrap_or_else(|| {
                unknown = Some(port.to_string());
                0
            }),
        });
        unknown.map_or(Ok(outcome), |port| Err(format!("the oracle does not know the output {port} of {name}")))
    }

    fn answer(&mut self, name: &str, inputs: &Inputs) -> Option<Answer> {
        let (semantics, arithmetic) = (self.semantics, &self.arithmetic);
        Some(match name {
            "quadbox" => {
                let is_conservative = semantics.features.conservative;
                let slabs = Slabs { rules: semantics.rules_in_full(), is_conservative };
                Answer::Boxes(slabs.answer(arithmetic, inputs, 4))
            }
            "octbox" => Answer::Boxes(Slabs::PAPER.answer(arithmetic, inputs, 8)),
            "quantised_box" => Answer::Boxes(boxes::quantised(arithmetic, inputs)),
            "triangle" => Answer::Triangle(Triangle::of(arithmetic, semantics, inputs)),
            "euclidean" => Answer::Euclidean(self.totals.euclidean(arithmetic, semantics.rounding, inputs)),
            "angular" => Answer::Angular(self.totals.angular(arithmetic, semantics.rounding, inputs)),
            "key_compare" => Answer::Child(added::child(arithmetic, inputs)),
            "point_in_box" => Answer::Inside(added::inside(arithmetic, inputs)),
            "sphere" => Answer::Sphere(Sphere::of(arithmetic, inputs)),
            _ => return None,
        })
    }
}

impl Answer {
    /// The word at an output port, by the port's name in `docs/integration/ports.md`.
    fn word(&self, port: &str, arithmetic: &Arithmetic) -> Option<u64> {
        let port = port.trim_start_matches("octbox_");
        let number = match (self, port) {
            (Self::Boxes(boxes), "is_intersect") => {
                return Some(boxes.iter().rev().fold(0, |word, entry| word << 1 | u64::from(entry.is_hit)));
            }
            (Self::Boxes(boxes), port) => match port.strip_prefix("tmin_") {
                Some(place) => boxes.get(place.parse::<usize>().ok()?)?.tmin,
                None => {
                    let place: usize = port.strip_prefix("box_index_")?.parse().ok()?;
                    return Some(boxes.get(place)?.index as u64);
                }
            },
            (Self::Child(child), "child_index") => return Some(*child),
            (Self::Inside(mask), "is_inside") => return Some(*mask),
            (Self::Sphere(sphere), "sphere_hit") => return Some(sphere.is_hit.into()),
            (Self::Triangle(triangle), "triangle_hit") => return Some(triangle.is_hit.into()),
            (Self::Triangle(triangle), "facing") => return Some(triangle.is_front.into()),
            (Self::Triangle(triangle), "t_num") => triangle.t_num,
            (Self::Triangle(triangle), "t_denom") => triangle.t_denom,
            (Self::Triangle(triangle), "barycentric_u") => triangle.edges[0],
            (Self::Triangle(triangle), "barycentric_v") => triangle.edges[1],
            (Self::Triangle(triangle), "barycentric_w") => triangle.edges[2],
            (Self::Euclidean(sum), "euclidean_accumulator") => *sum,
            (Self::Angular([dot_product, _]), "angular_dot_product") => *dot_product,
            (Self::Angular([_, norm]), "angular_norm") => *norm,
            (Self::Sphere(sphere), "sphere_a") => sphere.a,
            (Self::Sphere(sphere), "sphere_b") => sphere.b,
            (Self::Sphere(sphere), "sphere_c") => sphere.c,
            (Self::Sphere(sphere), "sphere_discriminant") => sphere.discriminant,
            _ => return None,
        };
        Some(arithmetic.code(number))
    }
}
