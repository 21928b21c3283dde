//! Random jobs of any operation, where nobody says which are worth running.

use crate::model::{AnyKind, AnyModel, Words};
use crate::numbers::edges;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use raypath_float::Format;
use raypath_model::Model;
use raypath_ops::{Port, PortKind};

/// A job whose ports are drawn one by one: in one of four many of its numbers are from the format's edges (zeros,
/// subnormals, infinities, NaN), in one most are small whole numbers, of which many are equal; raw bits now and then.
pub fn any_job(model: &AnyModel, kind: AnyKind, rng: &mut ChaCha8Rng) -> Words {
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
