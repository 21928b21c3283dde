//! Searches against exact arithmetic over integers, written anew.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use raypath_traversal::search::{
    Elements, ImageError, JOB_BYTES, Neighbour, Place, SearchImage, SearchJob, SearchMetric, SearchParameters,
    SearchReply, SearchStatus, VectorLayout, order_of_boxes, search,
};
use std::collections::BTreeSet;

/// Vectors of small integers, whose sums of products are exact in binary32, with the query behind them.
struct Subject {
    rows: Vec<Vec<i64>>,
    query: Vec<i64>,
    image: SearchImage,
    job: SearchJob,
}

const ELEMENTS: [Elements; 3] = [Elements::Binary32, Elements::Binary16, Elements::Int8 { scale: 0.25 }];

impl Subject {
    fn new(seed: u64, count: u32, dimensions: u32, elements: Elements, metric: SearchMetric) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut row = || -> Vec<i64> { (0..dimensions).map(|_| random.random_range(-9..=9)).collect() };
        let rows: Vec<Vec<i64>> = (0..count).map(|_| row()).collect();
        let query = row();
        let layout = VectorLayout { elements, dimensions };
        let mut image = SearchImage::new();
        let numbers = |rows: &[Vec<i64>]| -> Vec<f32> { rows.iter().flatten().map(|x| *x as f32).collect() };
        let vectors = image.vectors(layout, &numbers(&rows)).expect("vectors");
        let place = image.vectors(layout, &numbers(std::slice::from_ref(&query))).expect("a query");
        let job = SearchJob {
            metric,
            elements,
            dimensions,
            query: place,
            vectors,
            stride: layout.bytes(),
            count,
            k: 10,
            bound: f32::INFINITY,
            place: Place::Scan,
        };
        Self { rows, query, image, job }
    }

    fn run(&mut self, job: SearchJob) -> SearchReply {
        let address = self.image.job(&job).expect("a job");
        search(&self.image, 0, address, &SearchParameters::MOST)
    }

    /// The rank of a vector as a fraction of integers with a positive denominator, the lower the better; none of a
    /// cosine that does not exist.
    fn rank(&self, index: u32) -> Option<(i64, i64)> {
        let pairs = || self.query.iter().zip(&self.rows[index as usize]);
        let dot: i64 = pairs().map(|(a, b)| a * b).sum();
        match self.job.metric {
            SearchMetric::Euclidean => Some((pairs().map(|(a, b)| (a - b) * (a - b)).sum(), 1)),
            SearchMetric::Dot => Some((-dot, 1)),
            SearchMetric::Cosine => {
                let norm = pairs().map(|(_, b)| b * b).sum();
                (norm > 0).then_some((-dot * dot.abs(), norm))
            }
        }
    }

    /// The indices in the order of their ranks.
    fn sorted(&self, indices: impl IntoIterator<Item = u32>) -> Vec<u32> {
        let mut ranked: Vec<((i64, i64), u32)> =
            indices.into_iter().filter_map(|index| Some((self.rank(index)?, index))).collect();
        ranked.sort_by(|((a, b), i), ((c, d), j)| (a * d).cmp(&(c * b)).then(i.cmp(j)));
        ranked.into_iter().map(|(_, index)| index).collect()
    }
}

fn indices(reply: &SearchReply) -> Vec<u32> {
    reply.neighbours.iter().map(|neighbour| neighbour.index).collect()
}

const METRICS: [SearchMetric; 3] = [SearchMetric::Euclidean, SearchMetric::Dot, SearchMetric::Cosine];

/// Equal ranks are frequent: there are few dimensions of few values.
#[test]
fn scans_have_the_order_of_exact_ranks() {
    for (seed, metric) in (1..4).flat_map(|seed| METRICS.map(|metric| (seed, metric))) {
        for (dimensions, elements) in [1, 2, 7, 16, 17, 40].into_iter().flat_map(|n| ELEMENTS.map(|e| (n, e))) {
            let mut subject = Subject::new(seed, 150, dimensions, elements, metric);
            for k in [1, 10, 64] {
                let reply = subject.run(SearchJob { k, ..subject.job });
                let expected: Vec<u32> = subject.sorted(0..150).into_iter().take(k as usize).collect();
                // Two roundings make the ranks of some cosines equal that differ.
                if metric != SearchMetric::Cosine {
                    assert_eq!(indices(&reply), expected, "{metric:?}, {dimensions} {elements:?}, {k}");
                }
                let exact = |Neighbour { index, distance }: &Neighbour| {
                    let (rank, norm) = subject.rank(*index).expect("a rank");
                    let query: i64 = subject.query.iter().map(|x| x * x).sum();
                    let exact = match metric {
                        SearchMetric::Euclidean => (rank as f64).sqrt(),
                        SearchMetric::Dot => -rank as f64,
                        SearchMetric::Cosine => {
                            (-rank as f64).signum() * (rank.abs() as f64 / norm as f64 / query as f64).sqrt()
                        }
                    };
                    (f64::from(*distance) - exact).abs() <= 4e-7 * exact.abs()
                };
                assert!(reply.neighbours.iter().all(exact), "{metric:?}: {reply:?}");
                assert_eq!(reply.neighbours.len(), expected.len());
            }
        }
    }
}

#[test]
fn lists_name_vectors_once_and_a_bound_leaves_those_behind_it_out() {
    let mut subject = Subject::new(5, 100, 20, Elements::Binary32, SearchMetric::Euclidean);
    let list = [7, 99, 100, 7, 3, u32::MAX, 50, 3, 0];
    let address = subject.image.lists(list.len() as u32, [&list[..]].into_iter()).expect("a list");
    let place = Place::Gather { list: address, len: list.len() as u32 };
    let reply = subject.run(SearchJob { place, ..subject.job });
    assert_eq!(indices(&reply), subject.sorted([7, 99, 3, 50, 0]));
    assert_eq!(reply.counts.distances, 5);

    let sorted = subject.sorted(0..100);
    let bound = subject.rank(sorted[4]).expect("a rank").0;
    let within: Vec<u32> =
        sorted.into_iter().filter(|index| subject.rank(*index).expect("a rank").0 <= bound).collect();
    let reply = subject.run(SearchJob { bound: bound as f32, ..subject.job });
    assert_eq!(indices(&reply), within);
    let reply = subject.run(SearchJob { bound: -1.0, count: 0, ..subject.job });
    assert_eq!((reply.status, reply.neighbours.len()), (SearchStatus::Done, 0));
}

/// The same search with sets: the best `candidates` of all that were seen, and those that were expanded.
fn best_first(subject: &Subject, lists: &[Vec<u32>], entries: &[u32], candidates: usize, most: usize) -> Vec<u32> {
    let mut seen: BTreeSet<u32> = entries.iter().copied().filter(|index| *index < subject.job.count).collect();
    let mut expanded = BTreeSet::new();
    loop {
        let best: Vec<u32> = subject.sorted(seen.iter().copied()).into_iter().take(candidates).collect();
        let next = best.iter().find(|index| !expanded.contains(*index)).filter(|_| expanded.len() < most);
        let Some(next) = next else { return best.into_iter().take(subject.job.k as usize).collect() };
        expanded.insert(*next);
        seen.extend(lists[*next as usize].iter().copied().filter(|index| *index < subject.job.count));
    }
}

#[test]
fn graphs_are_searched_best_first() {
    for (seed, degree) in (1..6).flat_map(|seed| [0, 1, 5, 16, 17].map(|degree| (seed, degree))) {
        let mut subject = Subject::new(seed, 200, 12, Elements::Binary32, SearchMetric::Euclidean);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        // Some words name no vector, some the vector itself.
        let lists: Vec<Vec<u32>> =
            (0..200).map(|_| (0..degree).map(|_| random.random_range(0..210)).collect()).collect();
        let neighbours = subject.image.lists(degree, lists.iter().map(Vec::as_slice)).expect("a graph");
        let entries: Vec<u32> = (0..3).map(|_| random.random_range(0..210)).collect();
        let entry_list = subject.image.lists(3, [&entries[..]].into_iter()).expect("a list");
        for (candidates, expansions) in [(10, 1000), (32, 1000), (32, 4), (256, 0)] {
            let place =
                Place::Graph { neighbours, degree, entries: entry_list, entry_count: 3, candidates, expansions };
            let reply = subject.run(SearchJob { place, ..subject.job });
            let expected = best_first(&subject, &lists, &entries, candidates as usize, expansions as usize);
            assert_eq!(indices(&reply), expected, "{seed}, {degree}, {candidates}, {expansions}");
            assert!(reply.counts.expansions <= expansions.into());
        }
    }
}

#[test]
fn special_numbers_and_bad_jobs_have_a_stated_outcome() {
    let mut image = SearchImage::new();
    let layout = VectorLayout { elements: Elements::Binary32, dimensions: 2 };
    let rows = [f32::NAN, 0.0, f32::INFINITY, 1.0, 3.0, 4.0, 0.0, 0.0];
    let vectors = image.vectors(layout, &rows).expect("vectors");
    let query = image.vectors(layout, &[0.0, 0.0]).expect("a query");
    let (metric, place) = (SearchMetric::Euclidean, Place::Scan);
    let job = SearchJob {
        metric,
        elements: Elements::Binary32,
        dimensions: 2,
        query,
        vectors,
        stride: layout.bytes(),
        count: 4,
        k: 10,
        bound: f32::INFINITY,
        place,
    };
    let address = image.job(&job).expect("a job");
    let reply = search(&image, 0, address, &SearchParameters::MOST);
    let found: Vec<(u32, f32)> = reply.neighbours.iter().map(|n| (n.index, n.distance)).collect();
    assert_eq!(found, [(3, 0.0), (2, 5.0), (1, f32::INFINITY)]);

    let status = |image: &mut SearchImage, job: SearchJob| {
        let address = image.job(&job).expect("a job");
        search(image, 0, address, &SearchParameters::MOST).status
    };
    let outside = SearchJob { count: 1 << 20, ..job };
    assert_eq!(status(&mut image, outside), SearchStatus::Memory);
    assert_eq!(search(&image, 1, address, &SearchParameters::MOST).status, SearchStatus::Memory);
    for (refused, word) in [
        (SearchJob { k: 0, ..job }, 0),
        (SearchJob { k: 65, ..job }, 0),
        (SearchJob { dimensions: 4097, ..job }, 1),
        (SearchJob { query: 4, ..job }, 2),
        (SearchJob { stride: 0, ..job }, 4),
        (SearchJob { bound: f32::NAN, ..job }, 11),
        (SearchJob { elements: Elements::Int8 { scale: f32::NAN }, ..job }, 12),
    ] {
        assert_eq!(
            SearchJob::from_words(refused.words(), &SearchParameters::MOST).expect_err("a refusal").word,
            word,
            "{refused:?}"
        );
        assert_eq!(status(&mut image, refused), SearchStatus::Refused);
    }
    let int8 = VectorLayout { elements: Elements::Int8 { scale: 0.5 }, dimensions: 1 };
    assert_eq!(image.vectors(int8, &[0.5, 0.3]), Err(ImageError::Element(1)));
}

/// The records from the first one that is not below `low`, at most `len`, and of these not above `high`.
fn in_range(keys: &[f32], low: f32, high: f32, len: usize) -> Vec<u32> {
    let reached = (0..keys.len() as u32).filter(|index| keys[*index as usize] >= low).take(len);
    reached.filter(|index| keys[*index as usize] <= high).collect()
}

fn tree_job(image: &mut SearchImage, dimensions: u32, numbers: &[f32], query: [f32; 4]) -> SearchJob {
    let layout = |dimensions| VectorLayout { elements: Elements::Binary32, dimensions };
    SearchJob {
        metric: SearchMetric::Euclidean,
        elements: Elements::Binary32,
        dimensions,
        query: image.vectors(layout(4), &query).expect("a query"),
        vectors: image.vectors(layout(dimensions), numbers).expect("vectors"),
        stride: JOB_BYTES,
        count: numbers.len() as u32 / dimensions,
        k: 64,
        bound: f32::INFINITY,
        place: Place::Scan,
    }
}

#[test]
fn keys_are_found_one_by_one_and_in_ranges() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for count in [0, 1, 29, 30, 31, 60, 930, 931, 5000] {
        let mut keys: Vec<f32> = (0..count).map(|_| f32::from(random.random_range(-700_i16..700)) * 0.5).collect();
        keys.sort_by(f32::total_cmp);
        for len in [0, 1, 17, 64] {
            let low = f32::from(random.random_range(-760_i16..760)) * 0.5;
            let high = if len == 17 { low } else { low + f32::from(random.random_range(-1_i8..9)) };
            let mut image = SearchImage::new();
            let nodes = image.keys(&keys).expect("a tree");
            // The dot product of a key and -1 ranks it by its value.
            let job = tree_job(&mut image, 1, &keys, [-1.0, 0.0, 0.0, low.next_down()]);
            let place = Place::Keys { nodes, len, expansions: 100 };
            let address =
                image.job(&SearchJob { metric: SearchMetric::Dot, bound: high, place, ..job }).expect("a job");
            let reply = search(&image, 0, address, &SearchParameters::MOST);
            assert_eq!(reply.status, SearchStatus::Done);
            assert_eq!(indices(&reply), in_range(&keys, low, high, len as usize), "{count} keys, {low} to {high}");
            assert!(reply.neighbours.iter().all(|found| found.distance == -keys[found.index as usize]));
            let levels = (1..).find(|&levels| 30 * 31_u64.pow(levels) >= count).expect("levels");
            assert!(reply.counts.expansions <= levels.into() && reply.counts.distances <= len.into());
        }
    }
    assert_eq!(SearchImage::new().keys(&[1.0, 2.0, 1.5]), Err(ImageError::Order(2)));
    assert_eq!(SearchImage::new().keys(&[f32::NAN]), Err(ImageError::Order(0)));
}

#[test]
fn points_within_a_radius_are_found_in_few_boxes() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    for count in [0, 1, 4, 5, 16, 17, 64, 65, 3000] {
        let points: Vec<[f32; 3]> =
            (0..count).map(|_| std::array::from_fn(|_| f32::from(random.random_range(-64_i8..64)))).collect();
        let order = order_of_boxes(&points);
        assert_eq!(order.iter().copied().collect::<BTreeSet<u32>>(), (0..count).collect());
        let points: Vec<[f32; 3]> = order.into_iter().map(|index| points[index as usize]).collect();
        for radius in [0_i32, 1, 9, 15] {
            let query: [i32; 3] = match points.first() {
                Some(point) if radius < 9 => point.map(|x| x as i32),
                _ => std::array::from_fn(|_| random.random_range(-64..64)),
            };
            let squared =
                |point: &[f32; 3]| -> i32 { (0..3).map(|axis| (point[axis] as i32 - query[axis]).pow(2)).sum() };
            let near = |index: &u32| squared(&points[*index as usize]);
            let mut expected: Vec<u32> = (0..count).filter(|index| near(index) <= radius * radius).collect();
            expected.sort_by_key(|index| (near(index), *index));
            let mut image = SearchImage::new();
            let nodes = image.boxes(&points, radius as f32).expect("a tree");
            let [x, y, z] = query.map(|x| x as f32);
            // The fourth word is not read.
            let job = tree_job(&mut image, 3, points.as_flattened(), [x, y, z, f32::NAN]);
            let place = Place::Boxes { nodes, expansions: 10_000 };
            let address = image.job(&SearchJob { bound: (radius * radius) as f32, place, ..job }).expect("a job");
            let reply = search(&image, 0, address, &SearchParameters::MOST);
            expected.truncate(64);
            assert_eq!(indices(&reply), expected, "{count} points, radius {radius} of {query:?}");
            assert!(count < 3000 || reply.counts.distances < 300, "{:?}", reply.counts);
        }
    }
}

#[test]
fn damaged_trees_and_jobs_have_a_stated_outcome() {
    let mut image = SearchImage::new();
    let everywhere: Vec<f32> = (0..24).map(|word| [f32::NEG_INFINITY, f32::INFINITY][word % 6 / 3]).collect();
    let mut words: Vec<u32> = everywhere.iter().map(|bound| bound.to_bits()).collect();
    words.resize(32, 0);
    // The root is its own child 0, to which a key goes that is none. Nodes of zeros are behind it.
    let mut lists = vec![words];
    lists.resize(8, vec![0; 32]);
    let nodes = image.lists(32, lists.iter().map(Vec::as_slice)).expect("nodes");
    let job = tree_job(&mut image, 3, &[0.0; 9], [1.0, 1.0, 1.0, f32::NAN]);
    let run = |image: &mut SearchImage, place: Place, parameters: &SearchParameters, job: SearchJob| {
        let address = image.job(&SearchJob { place, ..job }).expect("a job");
        search(image, 0, address, parameters)
    };
    let most = SearchParameters::MOST;
    let mut ends = |place| run(&mut image, place, &most, job).status;
    assert_eq!(ends(Place::Boxes { nodes, expansions: 50 }), SearchStatus::Done, "expansions end a cycle");
    assert_eq!(ends(Place::Boxes { nodes: 1 << 20, expansions: 1 }), SearchStatus::Memory);
    assert_eq!(ends(Place::Keys { nodes, len: 4, expansions: 50 }), SearchStatus::Done);
    for (place, changed) in [
        (Place::Boxes { nodes: nodes + 4, expansions: 1 }, job),
        (Place::Keys { nodes, len: 1 << 16, expansions: 1 }, job),
        (Place::Boxes { nodes, expansions: 1 }, SearchJob { elements: Elements::Binary16, ..job }),
        (Place::Boxes { nodes, expansions: 1 }, SearchJob { dimensions: 4, ..job }),
    ] {
        assert_eq!(run(&mut image, place, &most, changed).status, SearchStatus::Refused, "{place:?}");
    }
    let without = SearchParameters { trees: 0, ..most };
    let place = Place::Boxes { nodes, expansions: 1 };
    assert_eq!(run(&mut image, place, &without, job).status, SearchStatus::Refused);
    // Each node's four children are everywhere, so that more branches wait than there are places.
    let lists: Vec<Vec<u32>> = (0..200_u32).map(|node| [&lists[0][..30], &[4 * node + 1, 0]].concat()).collect();
    let nodes = image.lists(32, lists.iter().map(Vec::as_slice)).expect("nodes");
    let place = Place::Boxes { nodes, expansions: 11 };
    assert_eq!(run(&mut image, place, &most, job).status, SearchStatus::Memory);
}
