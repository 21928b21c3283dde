//! Searches by jobs of the unit against the exact search.

use raypath_model::{Control, Shape};
use raypath_search::{
    Clusters, Dataset, Exact, GraphParameters, Layer, Metric, Neighbours, SearchError, SearchMemory, SearchResults,
    StoredAs, UnitJobs, UnitPlace, UnitSpec, Vectors, recall,
};
use raypath_traversal::UnitParameters;
use raypath_traversal::search::{self as unit, SearchParameters};

const COUNT: usize = 10;

fn dataset() -> Dataset {
    Clusters { seed: 3, ..Clusters::default() }
        .generate()
        .map(|all| Dataset { base: all.base.first(2000), queries: all.queries.first(20), ..all })
        .expect("vectors")
}

fn indices(results: &SearchResults) -> Vec<Vec<u32>> {
    results.rows.iter().map(|row| row.iter().map(|near| near.index).collect()).collect()
}

fn exact(Dataset { base, queries, .. }: &Dataset, metric: Metric) -> SearchResults {
    Exact::new(base, metric).search(queries, COUNT, &|_| true).expect("a search")
}

fn jobs(
    Dataset { base, queries, .. }: &Dataset,
    metric: Metric,
    stored: StoredAs,
    neighbours: usize,
    place: UnitPlace<'_>,
) -> Result<UnitJobs, SearchError> {
    let (metric, elements, unit) = (metric.into(), stored.elements([base, queries]), SearchParameters::MOST);
    UnitJobs::new(&UnitSpec { base, queries, metric, elements, neighbours, bound: f32::INFINITY, place, unit })
}

fn layer(base: &Vectors, metric: Metric) -> Layer {
    Layer::build(base, metric, &GraphParameters::default(), &|_| true).expect("a graph").0
}

/// The recall of a search by jobs.
fn found(dataset: &Dataset, metric: Metric, stored: StoredAs, place: UnitPlace<'_>) -> (SearchResults, f64) {
    let Dataset { base, queries, .. } = dataset;
    let found = jobs(dataset, metric, stored, COUNT, place).expect("jobs").search(&|_| true).expect("a search");
    let results = found.results(metric);
    let truth: Vec<i64> = exact(dataset, metric).rows.iter().flatten().map(|near| near.index.into()).collect();
    let truth = Neighbours::new(COUNT, &truth, base.len()).expect("neighbours");
    let recall = recall(&results, &truth, base, queries, metric, COUNT).expect("a recall");
    (results, recall)
}

#[test]
fn a_scan_finds_what_the_exact_search_finds() {
    let dataset = dataset();
    let (results, recall) = found(&dataset, Metric::Euclidean, StoredAs::Binary32, UnitPlace::All);
    let exact = exact(&dataset, Metric::Euclidean);
    assert_eq!(indices(&results), indices(&exact));
    assert_eq!((results.work, recall), (exact.work, 1.0));
    for (near, exact) in results.rows.iter().flatten().zip(exact.rows.iter().flatten()) {
        assert_eq!(near.distance, f64::from(exact.distance as f32));
    }
    // Ranks of cosines have two roundings.
    assert!(found(&dataset, Metric::Angular, StoredAs::Binary32, UnitPlace::All).1 > 0.99);
}

#[test]
fn rounded_elements_and_a_graph_find_most_neighbours() {
    let dataset = dataset();
    for (stored, least) in [(StoredAs::Binary16, 0.98), (StoredAs::Int8, 0.9)] {
        let (_, recall) = found(&dataset, Metric::Euclidean, stored, UnitPlace::All);
        assert!(recall >= least, "{stored}: {recall}");
    }
    for metric in Metric::ALL {
        let layer = layer(&dataset.base, metric);
        let (results, recall) = found(&dataset, metric, StoredAs::Binary32, UnitPlace::Graph(&layer, 64));
        assert!(recall >= 0.95, "{metric}: {recall}");
        assert!(results.work.evaluations < 20 * 1500, "{metric}: {:?}", results.work);
    }
}

#[test]
fn what_no_job_has_is_refused() {
    let found = jobs(&dataset(), Metric::Euclidean, StoredAs::Int8, 65, UnitPlace::All);
    assert_eq!(found.expect_err("65").to_string(), "65 neighbours in a job of the unit, expected 1 to 64");
}

#[test]
fn the_cycle_exact_model_finds_the_same_neighbours() {
    let dataset = dataset();
    let layer = layer(&dataset.base, Metric::Euclidean);
    for place in [UnitPlace::All, UnitPlace::Graph(&layer, 64)] {
        let jobs = jobs(&dataset, Metric::Euclidean, StoredAs::Binary32, COUNT, place).expect("jobs");
        let found = jobs.search(&|_| true).expect("a search");
        let shape = Shape { latency: 12, control: Control::Skid, interval: 1, loops: Vec::new() };
        let unit = UnitParameters { search: "k=10,m=64".parse().expect("searches"), ..UnitParameters::default() };
        let memory = SearchMemory { width: 256, latency: 50 };
        let all = jobs.time(&found, (&shape, unit), memory, [20, 0], &|_| true).expect("a timing");
        let alone = jobs.time(&found, (&shape, unit), memory, [2, 1], &|_| true).expect("a timing");
        assert!(all.beats_per_cycle() > 0.5 * all.bound(&alone, 8), "{all:?}, {alone:?}");
        assert!(all.cycles >= all.memory_beats.max(all.beats));
        let less = UnitParameters { search: "k=10,m=64,dimensions=16".parse().expect("searches"), ..unit };
        assert!(jobs.time(&found, (&shape, less), memory, [20, 0], &|_| true).is_err(), "jobs are refused");
    }
}

/// A query of zeros has no angle, so that the cosines of its neighbours are NaN, in both models.
#[test]
fn neighbours_without_an_angle_are_the_same_in_both_models() {
    let queries = Vectors::new(dataset().base.dimensions(), vec![0.0; dataset().base.dimensions()]).expect("a query");
    let dataset = Dataset { queries, ..dataset() };
    let jobs = jobs(&dataset, Metric::Angular, StoredAs::Binary32, COUNT, UnitPlace::All).expect("jobs");
    let found = jobs.search(&|_| true).expect("a search");
    assert_eq!(found.rows[0].len(), COUNT);
    assert!(found.rows[0].iter().all(|near| near.distance.is_nan()), "{:?}", found.rows[0]);
    let unit = UnitParameters { search: "k=10,m=16".parse().expect("searches"), ..UnitParameters::default() };
    let memory = SearchMemory { width: 512, latency: 20 };
    jobs.time(&found, (&Shape::default(), unit), memory, [1, 0], &|_| true).expect("the same neighbours");
}

#[test]
fn trees_find_what_a_scan_finds() {
    let clusters = Clusters { seed: 5, ..Clusters::default() };
    let dataset = clusters.generate().expect("vectors");
    let first = |vectors: &Vectors, count: usize, dimensions: usize| {
        let numbers = vectors.data()[..count * dimensions].to_vec();
        Vectors::new(dimensions, numbers).expect("vectors")
    };
    let parameters =
        UnitParameters { search: "k=16,m=16,trees=1".parse().expect("searches"), ..UnitParameters::default() };
    let memory = SearchMemory { width: 512, latency: 40 };
    for dimensions in 1..=3 {
        let points = Dataset {
            base: first(&dataset.base, 3000, dimensions),
            queries: first(&dataset.queries, 30, dimensions),
            ..dataset.clone()
        };
        let exact = exact(&points, Metric::Euclidean);
        let radius = exact.rows[0][4].distance as f32;
        let place = UnitPlace::Boxes(radius);
        let tree = jobs(&points, Metric::Euclidean, StoredAs::Binary32, COUNT, place).expect("a tree");
        let found = tree.search(&|_| true).expect("a search");
        assert!(found.rows.iter().flatten().count() > 50);
        for (row, exact) in found.rows.iter().zip(&exact.rows) {
            let within = exact.iter().filter(|near| near.distance.powi(2) as f32 <= radius * radius);
            let distances: Vec<f32> = within.map(|near| near.distance as f32).collect();
            assert_eq!(row.iter().map(|near| near.distance).collect::<Vec<_>>(), distances);
            // Of equal distances, those of the same box may be in another order.
            let is_same = |near: &unit::Neighbour| exact.iter().any(|exact| exact.index == near.index);
            assert!(row.iter().filter(|near| is_same(near)).count() + 1 >= row.len());
        }
        tree.time(&found, (&Shape::default(), parameters), memory, [30, 0], &|_| true).expect("the same neighbours");
    }
    let keys = first(&dataset.base, 3000, 1);
    let ranges: Vec<f32> = keys.data()[..40].iter().flat_map(|key| [*key, *key + 0.01]).collect();
    let ranges = Vectors::new(2, ranges).expect("ranges");
    let subject = Dataset { base: keys, queries: ranges, ..dataset };
    let tree = jobs(&subject, Metric::Euclidean, StoredAs::Binary32, COUNT, UnitPlace::Keys).expect("a tree");
    let found = tree.search(&|_| true).expect("a search");
    for (row, range) in found.rows.iter().zip(subject.queries.iter()) {
        let mut keys: Vec<f32> =
            subject.base.data().iter().copied().filter(|x| (range[0]..=range[1]).contains(x)).collect();
        keys.sort_by(f32::total_cmp);
        keys.truncate(COUNT);
        assert_eq!(row.iter().map(|near| near.distance).collect::<Vec<_>>(), keys);
        assert!(row.iter().all(|near| subject.base.data()[near.index as usize] == near.distance));
    }
    tree.time(&found, (&Shape::default(), parameters), memory, [40, 0], &|_| true).expect("the same keys");
    let refused = |place, metric| {
        let problem = jobs(&subject, metric, StoredAs::Binary32, COUNT, place).map(|_| ()).expect_err("an error");
        problem.to_string()
    };
    assert!(refused(UnitPlace::Boxes(1.0), Metric::Euclidean).contains("dimensions"));
    assert!(
        refused(UnitPlace::Keys, Metric::Angular).contains("the metric cosine in a tree of keys, expected euclidean")
    );
}
