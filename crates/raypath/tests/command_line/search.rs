//! `raypath search`.

use crate::command_line::{ends_with, file, folder, page, printed, text};
use std::path::Path;

fn fvecs(folder: &Path, name: &str, rows: &[&[f32]]) -> String {
    let row = |row: &&[f32]| -> Vec<u8> {
        let numbers = row.iter().flat_map(|x| x.to_le_bytes());
        (row.len() as u32).to_le_bytes().into_iter().chain(numbers).collect()
    };
    file(folder, name, rows.iter().flat_map(row).collect::<Vec<u8>>())
}

fn ivecs(rows: &[&[u32]]) -> Vec<u8> {
    rows.iter().flat_map(|row| [&[row.len() as u32], *row].concat()).flat_map(u32::to_le_bytes).collect()
}

/// Five points in three dimensions, and two queries, whose neighbours were computed by hand.
const BASE: [&[f32]; 5] = [&[0.0, 0.0, 9.0], &[1.0, 0.0, 0.0], &[0.0, 2.0, 0.0], &[3.0, 3.0, 0.0], &[-5.0, 0.0, 0.0]];
const QUERIES: [&[f32]; 2] = [&[1.0, 0.0, 1.0], &[0.0, 4.0, 0.5]];

#[test]
fn neighbours_are_found() {
    let folder = folder();
    let (base, queries) = (fvecs(folder.path(), "base.fvecs", &BASE), fvecs(folder.path(), "queries.fvecs", &QUERIES));
    let out = folder.path().join("found.ivecs");
    // Squared distances to the first query: 65, 1, 6, 14, 37; to the second: 88.25, 17.25, 4.25, 10.25, 41.25.
    // Cosines of the first: .707, .707 (equal or different by a rounding), 0, .5, -.707; of the second: .124, 0, .992,
    // .702, 0.
    let truth = file(folder.path(), "truth.ivecs", ivecs(&[&[1, 2, 3], &[2, 3, 1]]));
    for how in [&[][..], &["--through", "unit"], &["--through", "unit", "--index", "hnsw"]] {
        let arguments = ["search", &base, &queries, "-k", "3", "--truth", &truth];
        let said = page::succeeds(&[&arguments, how, &["--out", &text(&out)]].concat());
        assert_eq!(std::fs::read(&out).expect("neighbours"), ivecs(&[&[1, 2, 3], &[2, 3, 1]]), "{how:?}");
        assert_eq!(printed(&said, "recall at 3 against the file's truth"), "1.0000");
        assert!(said.contains("5 vectors of 3 dimensions, 2 queries, euclidean distance"), "{said}");
        assert_eq!((printed(&said, "distances "), printed(&said, "beats ")), ("10", "10"));
    }
    // Angular distance; -k 2 excludes the ties of the second query.
    page::succeeds(&["search", &base, &queries, "-k", "2", "--metric", "angular", "--out", &text(&out)]);
    assert_eq!(std::fs::read(&out).expect("neighbours")[12..], ivecs(&[&[0, 1], &[2, 3]])[12..]);
}

#[test]
fn the_report_agrees_with_the_output() {
    let folder = folder();
    let (base, queries) = (fvecs(folder.path(), "base.fvecs", &BASE), fvecs(folder.path(), "queries.fvecs", &QUERIES));
    let below = |name: &str| folder.path().join(name);
    for index in [&["--exact"][..], &["--index", "hnsw"]] {
        let arguments = ["search", &base, &queries, "-k", "2", "--metric", "angular", "--through", "unit"];
        let files = [("--report", "r.html"), ("--sweep", "s.svg")];
        let said = page::writes(&[&arguments[..], index].concat(), folder.path(), &files);
        assert_eq!(printed(&said, "queries timed"), "2 of 2");
        let html = std::fs::read_to_string(below("r.html")).expect("a page");
        assert!(html.contains("distances of a query"), "the report describes the search");
        assert!(html.contains("Throughput by"), "the report shows the sweep");
    }
}

/// An index as hnswlib 0.8 saves it, in which each vector is a neighbour of the next.
fn hnswlib(folder: &Path, rows: &[&[f32]]) -> String {
    let (count, size) = (rows.len() as u64, 4 * rows[0].len() as u64);
    let links = 2_u64;
    let vector = 4 + 4 * links;
    let head = [0, count, count, vector + size + 8, vector + size, vector].map(u64::to_le_bytes).concat();
    let rest = [links, links, 1, 0, 9].map(u64::to_le_bytes).concat();
    let mut bytes = [&head[..], &[0; 8], &rest].concat();
    for (index, row) in (0..count).zip(rows) {
        let next = ((index + 1) % count) as u32;
        bytes.extend([1_u32, next, 0].map(u32::to_le_bytes).concat());
        bytes.extend(row.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend(index.to_le_bytes());
    }
    bytes.extend(vec![0; 4 * rows.len()]);
    file(folder, "index.bin", bytes)
}

#[test]
fn a_saved_graph_is_searched_by_the_unit() {
    let folder = folder();
    let at = folder.path();
    let (graph, queries) = (hnswlib(at, &BASE), fvecs(at, "queries.fvecs", &QUERIES));
    let out = text(&at.join("found.ivecs"));
    for candidates in ["3", "5"] {
        let arguments = ["search", &graph, &queries, "-k", "3", "--through", "unit", "--ef", candidates, "--out", &out];
        let said = page::succeeds(&arguments);
        assert_eq!(std::fs::read(&out).expect("neighbours"), ivecs(&[&[1, 2, 3], &[2, 3, 1]]), "{candidates}");
        assert_eq!(printed(&said, "distances "), "10", "each vector leads to the next");
    }
    ends_with(&["search", &graph, &queries], 2, &["index.bin", "expected --through unit or --exact"]);
    for more in [&["--exact"][..], &["--through", "unit", "--exact"]] {
        let arguments = [&["search", &graph, &queries, "--ef", "4"], more].concat();
        ends_with(&arguments, 2, &["--ef 4", "expected --index hnsw or a saved graph"]);
    }
    ends_with(&["search", &graph, &queries, "--through", "unit", "--ef", "257"], 2, &["257", "256"]);
}

#[test]
fn trees_are_searched_by_the_unit() {
    let folder = folder();
    let at = folder.path();
    let (base, queries) = (fvecs(at, "base.fvecs", &BASE), fvecs(at, "queries.fvecs", &QUERIES));
    let keys = fvecs(at, "keys.fvecs", &[&[4.0], &[-2.0], &[4.0], &[9.5], &[0.0]]);
    let ranges = fvecs(at, "ranges.fvecs", &[&[-2.0, 4.0], &[4.0, 4.0], &[5.0, 9.0], &[9.5, 20.0]]);
    let out = text(&at.join("found.ivecs"));
    // A shorter row is filled up. The squared distances to the queries are those of the first test.
    const NONE: u32 = u32::MAX;
    let cases: [(&[&str], &[&[u32]]); 2] = [
        (&[&base, &queries, "--index", "boxes", "--radius", "4.2"], &[&[1, 2, 3], &[2, 3, 1]]),
        (&[&keys, &ranges, "--index", "keys"], &[&[1, 4, 0], &[0, 2, NONE], &[NONE; 3], &[3, NONE, NONE]]),
    ];
    for (arguments, expected) in cases {
        let said = page::succeeds(&[&["search"], arguments, &["-k", "3", "--through", "unit", "--out", &out]].concat());
        assert_eq!(printed(&said, "queries whose neighbours are not those of a scan"), "0");
        assert_eq!(std::fs::read(&out).expect("neighbours"), ivecs(expected));
    }
    for (more, words) in [
        (&[&base, &queries, "--index", "boxes"][..], "--index boxes: expected --radius"),
        (&[&base, &queries, "--index", "hnsw", "--radius", "1"], "--radius 1: expected --index boxes"),
        (&[&base, &queries, "--index", "boxes", "--radius", "-1"], "a distance, 0 to 1e30"),
        (&[&base, &queries, "--index", "keys"], "2"),
        (
            &[&base, &queries, "--index", "boxes", "--radius", "1", "--search", "k=4,m=4"],
            "--search trees=0, expected at least 1",
        ),
    ] {
        ends_with(&[&["search"], more, &["-k", "3", "--through", "unit"]].concat(), 2, &[words]);
    }
}

#[test]
fn wrong_input_is_named() {
    let folder = folder();
    let at = folder.path();
    let (base, queries) = (fvecs(at, "base.fvecs", &BASE), fvecs(at, "queries.fvecs", &QUERIES));
    let flat = fvecs(at, "flat.fvecs", &[&[1.0, 2.0]]);
    let nan = fvecs(at, "nan.fvecs", &[&[1.0, f32::NAN, 0.0]]);
    let empty = file(at, "empty.fvecs", b"");
    let cut = file(at, "cut.fvecs", &std::fs::read(&base).expect("base")[..30]);
    let lies = file(at, "lies.fvecs", [0xff, 0xff, 0xff, 0x7f, 0, 0, 0, 0]);
    let npy = file(
        at,
        "lies.npy",
        b"\x93NUMPY\x01\x00\x46\x00{'descr': '<f4', 'fortran_order': False, 'shape': (4000000000, 4000000000)}  \n",
    );
    let hdf5 = file(at, "wrong.hdf5", b"\x89HDF\r\n\x1a\nnothing");
    let unknown = file(at, "base.csv", "1,2,3\n");
    let far = file(at, "far.ivecs", ivecs(&[&[1], &[5]]));
    let short = file(at, "short.ivecs", ivecs(&[&[1]]));
    let out = text(&at.join("found.ivecs"));
    let limit = ["base.fvecs: 5 vectors of 3 coordinates take 2680 bytes of memory", "at most 2679", "--max-memory"];
    let cases: [(&[&str], &[&str]); 19] = [
        (&[&base, &queries, "--max-memory", "2679"], &limit),
        (&["/nonexistent/base.fvecs", &queries], &["/nonexistent/base.fvecs", "No such file"]),
        (&[&base], &["base.fvecs", "queries", "no file of queries"]),
        (&[&base, &flat], &["flat.fvecs", "dimensions", "found 2", "expected 3"]),
        (&[&nan, &queries], &["nan.fvecs", "vector 0, coordinate 1", "found NaN"]),
        (&[&empty, &queries], &["empty.fvecs"]),
        (&[&cut, &queries], &["cut.fvecs"]),
        (&[&lies, &queries], &["lies.fvecs"]),
        (&[&npy, &queries], &["lies.npy"]),
        (&[&hdf5], &["wrong.hdf5"]),
        (&[&unknown, &queries], &["base.csv"]),
        (&[&base, &queries, "-k", "6"], &["6 neighbours requested, expected 1 to 5"]),
        (&[&base, &queries, "-k", "0"], &["'0'", "expected a whole number from 1"]),
        (&[&base, &queries, "--metric", "manhattan"], &["manhattan", "euclidean or angular"]),
        (&[&base, &queries, "-k", "1", "--truth", &far], &["far.ivecs", "found index 5, expected 0 to 4"]),
        (
            &[&base, &queries, "-k", "1", "--truth", &short],
            &["short.ivecs", "rows of neighbours: found 1", "expected 2"],
        ),
        (&["--truth", &far], &["--truth", "expected BASE and QUERIES"]),
        (&[&base, &queries, "-k", "1", "--lanes", "8"], &["--lanes 8", "16 lanes only"]),
        (&[&base, &queries, "-k", "1", "--format", "fp16"], &["fp32 only"]),
    ];
    for (arguments, words) in cases {
        ends_with(&[&["search"], arguments, &["--out", &out]].concat(), 2, words);
    }
    assert!(!at.join("found.ivecs").exists());
}

/// Without files the program generates a data set, which the seed determines.
#[test]
fn a_data_set_is_generated() {
    let folder = folder();
    let found = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let arguments = ["search", "-k", "5", "--out", &text(&out)];
        let said = page::succeeds(&[&arguments, more].concat());
        assert!(said.contains("10000 vectors of 128 dimensions, 100 queries"), "{said}");
        std::fs::read(out).expect("neighbours")
    };
    let first = found("first", &[]);
    assert_eq!(first.len(), 100 * 4 * 6);
    assert_eq!(first, found("second", &["--exact"]));
    assert_ne!(first, found("third", &["--seed", "2"]));
}
