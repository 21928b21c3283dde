//! The outcome of every job, written from the text of `docs/reference` alone, in exact arithmetic with one rounding for
//! each operation: all numbers of lanes, formats, rules, roundings, features and added operations.
//!
//! The oracle shares no function with the operations, the models or the units. A number is an integer times a power of
//! two. [`quick`] computes the paper's operations of the default configuration in binary64, for more jobs; the item
//! `models` compares it with this oracle.

mod added;
mod boxes;
mod distances;
mod inputs;
mod mistake;
mod number;
pub mod quick;
mod triangles;

use crate::layout::Layout;
use added::Sphere;
use boxes::{Entry, Slabs};
use distances::{Sums, Totals};
use inputs::Inputs;
pub use mistake::Mistake;
use number::{Arithmetic, Number};
use raypath_model::{WordModel, Words};
use raypath_rtl::Semantics;
use triangles::Triangle;

/// The oracle of a datapath, with the accumulators of its distances.
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
    Euclidean {
        sum: Number,
        is_last: bool,
    },
    Angular {
        sums: Sums,
        is_last: bool,
    },
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
            port => answer.word(port, &self.arithmetic).unwrap_or_else(|| {
                unknown = Some(port.to_string());
                0
            }),
        });
        unknown.map_or(Ok(outcome), |port| Err(format!("the oracle does not know the output {port} of {name}")))
    }

    fn answer(&mut self, name: &str, inputs: &Inputs) -> Option<Answer> {
        let (semantics, arithmetic) = (self.semantics, &self.arithmetic);
        let features = semantics.features;
        Some(match name {
            "quadbox" => {
                let slabs = Slabs { rules: semantics.rules_in_full(), is_conservative: features.conservative };
                Answer::Boxes(slabs.answer(arithmetic, inputs, 4))
            }
            "octbox" => Answer::Boxes(Slabs::PAPER.answer(arithmetic, inputs, 8)),
            "quantised_box" => Answer::Boxes(boxes::quantised(arithmetic, inputs)),
            "triangle" => Answer::Triangle(Triangle::of(arithmetic, semantics, inputs)),
            "euclidean" => {
                let sum = self.totals.euclidean(arithmetic, semantics.rounding, inputs);
                Answer::Euclidean { sum, is_last: inputs.is_last }
            }
            "angular" => {
                let sums = self.totals.angular(arithmetic, semantics.rounding, inputs);
                Answer::Angular { sums, is_last: inputs.is_last }
            }
            "key_compare" => Answer::Child(added::child(arithmetic, inputs)),
            "point_in_box" => Answer::Inside(added::inside(arithmetic, inputs)),
            "sphere" => Answer::Sphere(Sphere::of(arithmetic, inputs)),
            _ => return None,
        })
    }

    /// A hardware reset: the accumulators are zero.
    pub fn reset(&mut self) {
        self.totals = Totals::new(self.semantics.features.accumulators.count());
    }
}

impl Answer {
    /// The word at an output port, by the port's name in `docs/integration/ports.md`.
    fn word(&self, port: &str, arithmetic: &Arithmetic) -> Option<u64> {
        let code = |number: &Number| Some(arithmetic.code(number));
        let parts: Vec<&str> = port.trim_start_matches("octbox_").split('_').collect();
        match (self, parts.as_slice()) {
            (Self::Boxes(boxes), ["is", "intersect"]) => {
                Some(boxes.iter().rev().fold(0, |word, entry| word << 1 | u64::from(entry.is_hit)))
            }
            (Self::Boxes(boxes), ["tmin", place]) => code(&boxes.get(place.parse::<usize>().ok()?)?.tmin),
            (Self::Boxes(boxes), ["box", "index", place]) => {
                Some(boxes.get(place.parse::<usize>().ok()?)?.index as u64)
            }
            (Self::Triangle(triangle), ["t", "num"]) => code(&triangle.t_num),
            (Self::Triangle(triangle), ["t", "denom"]) => code(&triangle.t_denom),
            (Self::Triangle(triangle), ["triangle", "hit"]) => Some(triangle.is_hit.into()),
            (Self::Triangle(triangle), ["facing"]) => Some(triangle.is_front.into()),
            (Self::Triangle(triangle), ["barycentric", edge]) => {
                code(&triangle.edges[["u", "v", "w"].iter().position(|name| name == edge)?])
            }
            (Self::Euclidean { sum, .. }, ["euclidean", "accumulator"]) => code(sum),
            (Self::Angular { sums, .. }, ["angular", "dot", "product"]) => code(&sums.dot_product),
            (Self::Angular { sums, .. }, ["angular", "norm"]) => code(&sums.norm),
            (Self::Euclidean { is_last, .. }, ["euclidean", "reset", "accum"])
            | (Self::Angular { is_last, .. }, ["angular", "reset", "accum"]) => Some((*is_last).into()),
            (Self::Child(child), ["child", "index"]) => Some(*child),
            (Self::Inside(mask), ["is", "inside"]) => Some(*mask),
            (Self::Sphere(sphere), ["sphere", part]) => match *part {
                "a" => code(&sphere.a),
                "b" => code(&sphere.b),
                "c" => code(&sphere.c),
                "discriminant" => code(&sphere.discriminant),
                "hit" => Some(sphere.is_hit.into()),
                _ => None,
            },
            _ => None,
        }
    }
}
