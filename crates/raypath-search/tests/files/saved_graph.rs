//! Graphs that hnswlib and faiss saved.

use super::common::{Written, assert_error};
use flate2::read::GzDecoder;
use raypath_search::{Exact, Metric, Neighbour, SavedGraph, UnitJobs, UnitPlace, UnitSpec, Vectors, read_graph};
use raypath_tools::MemoryLimit;
use raypath_traversal::search::{Elements, SearchMetric, SearchParameters};
use std::io::Read;

const FILES: [(&str, &[u8]); 2] = [
    ("hnswlib.bin", include_bytes!("../data/hnswlib.bin.gz")),
    ("faiss.index", include_bytes!("../data/faiss.index.gz")),
];

fn unpacked(file: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    GzDecoder::new(file).read_to_end(&mut bytes).expect("a file");
    bytes
}

/// The vectors that `tests/data/graphs.py` writes.
fn vectors() -> Vectors {
    let number = |i: i32, j: i32| ((i * 37 + j * 101 + i * j * 13 + i * i * 7) % 251 - 125) as f32;
    let numbers = (0..200).flat_map(|i| (0..12).map(move |j| number(i, j))).collect();
    Vectors::new(12, numbers).expect("vectors")
}

#[test]
fn the_unit_searches_a_saved_graph() {
    for (name, file) in FILES {
        let written = Written::new(name, &unpacked(file));
        let SavedGraph { vectors: base, layer, metric } = read_graph(&written.path, MemoryLimit::DEFAULT).expect(name);
        assert_eq!(base, vectors(), "{name}");
        assert_eq!((layer.degree(), layer.neighbours().len()), (12, 200), "{name}");
        assert_eq!(metric, (name == "faiss.index").then_some(Metric::Euclidean));
        let queries = base.first(20);
        let exact = Exact::new(&base, Metric::Euclidean);
        let exact = exact.search(&queries, 5, &|_| true).expect("neighbours");
        let spec = UnitSpec {
            base: &base,
            queries: &queries,
            metric: SearchMetric::Euclidean,
            elements: Elements::Binary32,
            neighbours: 5,
            bound: f32::INFINITY,
            place: UnitPlace::Graph(&layer, 64),
            unit: SearchParameters::MOST,
        };
        let found = UnitJobs::new(&spec).expect("jobs").search(&|_| true).expect("a search");
        let rows = found.results(Metric::Euclidean).rows;
        let indices = |row: &Vec<Neighbour>| row.iter().map(|near| near.index).collect::<Vec<_>>();
        let equal = rows.iter().zip(&exact.rows).filter(|(row, exact)| indices(row) == indices(exact)).count();
        assert!(equal >= 19, "{name}: {equal} of 20 queries have all neighbours");
        assert!(found.work.evaluations < 20 * 190, "{name}: {:?}", found.work);
    }
}

#[test]
fn other_files_are_named() {
    for (name, file) in FILES {
        let bytes = unpacked(file);
        let error = |bytes: &[u8], parts: &[&str]| {
            let written = Written::new(name, bytes);
            assert_error(name, read_graph(&written.path, MemoryLimit::DEFAULT).map(|_| ()), parts);
        };
        // Whatever is cut off is missed.
        for length in (0..bytes.len()).step_by(997) {
            error(&bytes[..length], &["found"]);
        }
        let small = read_graph(&Written::new(name, &bytes).path, MemoryLimit::of(1000)).map(|_| ());
        assert_error(name, small, &[&format!("the bytes of a graph take {} bytes", bytes.len())]);
        error(&[&bytes[..], &[0]].concat(), &["end of the file"]);
        error(&[7; 5000], &["other sizes", "hnswlib", "faiss"]);
        let changed = |at: usize, value: &[u8]| {
            let mut bytes = bytes.clone();
            bytes[at..at + value.len()].copy_from_slice(value);
            bytes
        };
        if name == "faiss.index" {
            error(&changed(33, &[9, 0, 0, 0]), &["metric", "9"]);
            continue;
        }
        // The head has 96 bytes; an element 52 bytes of links, 48 of numbers and 8 of its label.
        error(&changed(96 + 2, &[1]), &["element 0", "a deleted one"]);
        error(&changed(96 + 4, &[200, 0, 0, 0]), &["neighbour 200", "expected one of 200 vectors"]);
        error(&changed(96 + 52, &f32::NAN.to_le_bytes()), &["NaN"]);
        error(&changed(96 + 100, &[200]), &["labels", "200", "each of 0 to 199 once"]);
        error(&changed(96 + 100, &bytes[96 + 108 + 100..][..8]), &["labels", "each of 0 to 199 once"]);
    }
}
