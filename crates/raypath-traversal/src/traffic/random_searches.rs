//! Random searches.

use crate::search::{
    Elements, ImageError, Place, SearchImage, SearchJob, SearchMetric, SearchParameters, VectorLayout, order_of_boxes,
};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Places so many random jobs in memory, with their vectors, lists, graphs and trees, and returns their addresses. Some are
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
    if parameters.has_trees() && random.random_range(0..3) == 0 {
        return random_tree(random, parameters, image);
    }
    let elements = [Elements::Binary32, Elements::Binary16, Elements::Int8 { scale: 0.25 }][random.random_range(0..3)];
    let dimensions = [1, 3, 8, 16, 17, 31, 40, 64, 65, 100][random.random_range(0..10)].min(parameters.dimensions);
    let vectors = random.random_range(0..120);
    let fills_list = random.random_range(0..3) == 0;
    let k = if fills_list { parameters.neighbours } else { random.random_range(1..=parameters.neighbours.min(12)) };
    let layout = VectorLayout { elements, dimensions };
    let mut numbers = |count: u32| -> Vec<f32> {
        (0..count * dimensions).map(|_| f32::from(random.random_range(-9_i8..=9)) * 0.25).collect()
    };
    let (mut rows, query) = (numbers(vectors), numbers(1));
    if fills_list {
        // Each vector is nearer than those before, so that it is inserted, and vectors wait for the list.
        let squared = |row: &[f32]| row.iter().zip(&query).map(|(a, b)| (a - b) * (a - b)).sum::<f32>();
        let mut sorted: Vec<&[f32]> = rows.chunks(dimensions as usize).collect();
        sorted.sort_by(|a, b| squared(b).total_cmp(&squared(a)));
        rows = sorted.concat();
    }
    let (base, query) = (place_vectors(random, image, layout, &rows)?, place_vectors(random, image, layout, &query)?);
    let metric = [SearchMetric::Euclidean, SearchMetric::Dot, SearchMetric::Cosine][random.random_range(0..3)];
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
                candidates: random.random_range(k..=parameters.candidates),
                expansions: [0, 1, 5, 1000][random.random_range(0..4)],
            }
        }
    };
    let (k, count) = match random.random_range(0..8) {
        0 => (0, vectors),
        1 => (k, vectors + 1_000_000),
        _ => (k, vectors),
    };
    let bound = if random.random_range(0..4) == 0 { 2.0 } else { f32::INFINITY };
    let stride = layout.bytes();
    image.job(&SearchJob { metric, elements, dimensions, query, vectors: base, stride, count, k, bound, place })
}

/// Places vectors, with any bytes behind the elements of each.
fn place_vectors(
    random: &mut ChaCha8Rng,
    image: &mut SearchImage,
    layout: VectorLayout,
    numbers: &[f32],
) -> Result<u32, ImageError> {
    let address = image.vectors(layout, numbers)?;
    let size = (layout.elements.bytes() * layout.dimensions) as usize;
    for vector in image.bytes_mut()[address as usize..].chunks_mut(layout.bytes() as usize) {
        random.fill(&mut vector[size..]);
    }
    Ok(address)
}

/// A tree of keys or of boxes. Some are damaged: their nodes are elsewhere, or refer to each other.
fn random_tree(
    random: &mut ChaCha8Rng,
    parameters: SearchParameters,
    image: &mut SearchImage,
) -> Result<u32, ImageError> {
    let layout = |dimensions| VectorLayout { elements: Elements::Binary32, dimensions };
    let k = random.random_range(1..=parameters.neighbours.min(12));
    let expansions = if random.random_range(0..4) == 0 { random.random_range(0..6) } else { 300 };
    let is_keys = random.random_range(0..2) == 0;
    let count: u32 = random.random_range(0..if is_keys { 1500 } else { 400 });
    let mut number = || f32::from(random.random_range(-9_i8..=9)) * 0.5;
    let (nodes, vectors, query, bound) = if is_keys {
        let mut keys: Vec<f32> = (0..count).map(|_| number() * number() + number()).collect();
        keys.sort_by(f32::total_cmp);
        let (query, bound) = ([-1.0, 0.0, 0.0, number().next_down()], number());
        let query = image.vectors(layout(4), &query)?;
        (image.keys(&keys)?, place_vectors(random, image, layout(1), &keys)?, query, bound)
    } else {
        let points: Vec<[f32; 3]> = (0..count).map(|_| std::array::from_fn(|_| number())).collect();
        let points: Vec<[f32; 3]> = order_of_boxes(&points).into_iter().map(|index| points[index as usize]).collect();
        let (radius, query) = (number().abs(), [number(), number(), number()]);
        let (nodes, query) = (image.boxes(&points, radius)?, place_vectors(random, image, layout(3), &query)?);
        (nodes, place_vectors(random, image, layout(3), points.as_flattened())?, query, radius * radius)
    };
    let nodes = match random.random_range(0..12) {
        0 => query,
        1 => {
            // Nodes whose children they are, around everything: there are branches without end.
            let bounds = [f32::NEG_INFINITY, f32::INFINITY].map(f32::to_bits);
            let mut words: Vec<u32> = (0..24).map(|word| bounds[word % 6 / 3]).collect();
            words.resize(32, 0);
            image.lists(32, [&words[..]; 4][..random.random_range(1..=4)].iter().copied())?
        }
        _ => nodes,
    };
    let len = random.random_range(0..40);
    let place = if is_keys { Place::Keys { nodes, len, expansions } } else { Place::Boxes { nodes, expansions } };
    let (metric, dimensions) = if is_keys { (SearchMetric::Dot, 1) } else { (SearchMetric::Euclidean, 3) };
    let elements = if random.random_range(0..20) == 0 { Elements::Binary16 } else { Elements::Binary32 };
    image.job(&SearchJob { metric, elements, dimensions, query, vectors, stride: 64, count, k, bound, place })
}
