//! Random searches.

use crate::search::{
    Elements, ImageError, Place, SearchImage, SearchJob, SearchMetric, SearchParameters, VectorLayout,
};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Places so many random jobs in memory, with their vectors, lists and graphs, and returns their addresses. Some are
/// refused, and some read behind the memory. Equal ranks, indices that name no vector and repeated ones are frequent.
///
/// # Errors
/// More than 4 GiB.
pub fn random_searches(
    seed: u64,
    count: usize,
    parameters: SearchParameters,
    image: &mut SearchImage,
) -> Result<Vec<u32>, ImageError> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..count).map(|_| random_search(&mut random, parameters, image)).collect()
}

fn random_search(
    random: &mut ChaCha8Rng,
    parameters: SearchParameters,
    image: &mut SearchImage,
) -> Result<u32, ImageError> {
    let elements = [Elements::Binary32, Elements::Binary16, Elements::Int8 { scale: 0.25 }][random.random_range(0..3)];
    let dimensions = [1, 3, 8, 16, 17, 31, 40, 64, 65, 100][random.random_range(0..10)].min(parameters.dimensions);
    let vectors = random.random_range(0..120);
    let layout = VectorLayout { elements, dimensions };
    let mut numbers = |count: u32| -> Vec<f32> {
        (0..count * dimensions).map(|_| f32::from(random.random_range(-9_i8..=9)) * 0.25).collect()
    };
    let (rows, query) = (numbers(vectors), numbers(1));
    let (base, query) = (image.vectors(layout, &rows)?, image.vectors(layout, &query)?);
    let metric = [SearchMetric::Euclidean, SearchMetric::Dot, SearchMetric::Cosine][random.random_range(0..3)];
    let least = parameters.neighbours.min(12);
    let indices = |random: &mut ChaCha8Rng, most: u32| -> Vec<u32> {
        let count = random.random_range(0..most);
        (0..count).map(|_| random.random_range(0..vectors + 20)).collect()
    };
    let place = match random.random_range(0..4) {
        0 => Place::Scan,
        1 => {
            let list = indices(random, 70);
            Place::Gather { list: image.lists(list.len() as u32, [&list[..]].into_iter())?, len: list.len() as u32 }
        }
        _ => {
            let degree = random.random_range(0..40);
            // A shorter list is filled up with words that name no vector.
            let lists: Vec<Vec<u32>> = (0..vectors).map(|_| indices(random, degree + 1)).collect();
            let entries = indices(random, 20);
            Place::Graph {
                neighbours: image.lists(degree, lists.iter().map(Vec::as_slice))?,
                degree,
                entries: image.lists(entries.len() as u32, [&entries[..]].into_iter())?,
                entry_count: entries.len() as u32,
                candidates: random.random_range(least..=parameters.candidates),
                expansions: [0, 1, 5, 1000][random.random_range(0..4)],
            }
        }
    };
    let (k, count) = match random.random_range(0..8) {
        0 => (0, vectors),
        1 => (least, vectors + 1_000_000),
        _ => (random.random_range(1..=least), vectors),
    };
    let bound = if random.random_range(0..4) == 0 { 2.0 } else { f32::INFINITY };
    let stride = layout.bytes();
    image.job(&SearchJob { metric, elements, dimensions, query, vectors: base, stride, count, k, bound, place })
}
