use super::common::{Written, assert_error, base};
use crate::common::unzip;
use hdf5_pure::{AttrValue, FileBuilder};
use raypath_search::{Dataset, Exact, Metric, read_vectors};
use raypath_tools::MemoryLimit;

const PLAIN: &[u8] = include_bytes!("../data/plain.hdf5.gz");
const DEFLATED: &[u8] = include_bytes!("../data/deflated.hdf5.gz");

#[test]
fn files_of_h5py() {
    for bytes in [PLAIN, DEFLATED] {
        let file = Written::new("a.hdf5", &unzip(bytes));
        let dataset = file.dataset().expect("a data set");
        assert_eq!((dataset.base.dimensions(), dataset.base.data()), (5, &base()[..]));
        assert_eq!(dataset.metric, Some(Metric::Euclidean));
        let queries: Vec<f32> = base()[10..25].iter().map(|x| x + 0.25).collect();
        assert_eq!(dataset.queries.data(), queries);

        // A search finds the neighbours and distances of the file.
        let truth = dataset.truth.expect("truth");
        let distances = dataset.distances.expect("distances");
        let found = Exact::new(&dataset.base, Metric::Euclidean);
        let found = found.search(&dataset.queries, truth.count(), &|_| true).expect("results");
        for ((row, indices), distances) in found.rows.iter().zip(truth.rows()).zip(distances.iter()) {
            assert!(row.iter().map(|near| near.index).eq(indices.iter().copied()), "{row:?} and {indices:?}");
            assert!(row.iter().zip(distances).all(|(near, &distance)| near.distance as f32 == distance));
        }
        assert_eq!(file.vectors().expect("the base"), dataset.base);
        assert_eq!(file.neighbours(7).expect("neighbours"), truth);

        let one = Written::new("q.fvecs", &[&5i32.to_le_bytes()[..], &[0; 20]].concat());
        let other = Dataset::read(&file.path, Some(&one.path), None, MemoryLimit::DEFAULT).expect("other queries");
        assert_eq!((other.queries.len(), other.truth), (1, None));
        let truth =
            Dataset::read(&file.path, None, Some(&file.path), MemoryLimit::DEFAULT).expect("truth by name").truth;
        assert_eq!(truth.map(|truth| truth.queries()), Some(3));
    }
}

/// A file with the datasets that `build` adds.
fn made(build: impl FnOnce(&mut FileBuilder)) -> Written {
    let mut builder = FileBuilder::new();
    build(&mut builder);
    Written::new("a.hdf5", &builder.finish().expect("a file"))
}

fn train(builder: &mut FileBuilder) {
    builder.create_dataset("train").with_f32_data(&[0.0; 6]).with_shape(&[3, 2]);
    builder.create_dataset("test").with_f32_data(&[0.0; 2]).with_shape(&[1, 2]);
}

#[test]
fn wrong_files() {
    assert_error("a.hdf5", Written::new("a.hdf5", b"text").dataset(), &["file", "expected HDF5"]);
    assert_error("a.hdf5", made(|_| {}).dataset(), &["train", "expected HDF5 in the layout of ann-benchmarks"]);
    let file = made(|builder| {
        builder.create_dataset("train").with_f32_data(&[0.0; 6]).with_shape(&[6]);
    });
    assert_error("a.hdf5", file.dataset(), &["train", "found shape [6]", "expected two axes"]);
    let file = made(|builder| {
        builder.create_dataset("train").with_f32_data(&[0.0, f32::NAN]).with_shape(&[1, 2]);
    });
    assert_error("a.hdf5", file.dataset(), &["vector 0, coordinate 1", "found NaN"]);
    let file = made(|builder| {
        builder.create_group("train");
    });
    assert_error("a.hdf5", file.dataset(), &["train"]);
    let file = made(|builder| {
        train(builder);
        builder.create_dataset("neighbors").with_f32_data(&[0.0]).with_shape(&[1, 1]);
    });
    assert_error("a.hdf5", file.dataset(), &["neighbors", "found type f32", "expected integers"]);
    for (index, found) in [(3, "found index 3"), (-1, "found index -1")] {
        let file = made(|builder| {
            train(builder);
            builder.create_dataset("neighbors").with_i32_data(&[0, index]).with_shape(&[1, 2]);
        });
        assert_error("a.hdf5", file.dataset(), &["query 0, neighbour 1", found, "expected 0 to 2"]);
    }
    let file = made(|builder| {
        train(builder);
        builder.create_dataset("neighbors").with_i32_data(&[0, 1]).with_shape(&[2, 1]);
    });
    assert_error("a.hdf5", file.dataset(), &["rows of neighbours", "found 2", "expected 1, one for each query"]);
    let file = made(|builder| {
        builder.create_dataset("train").with_f32_data(&[0.0; 6]).with_shape(&[3, 2]);
        builder.create_dataset("test").with_f32_data(&[0.0; 3]).with_shape(&[1, 3]);
    });
    assert_error("a.hdf5", file.dataset(), &["dimensions of the queries", "found 3", "expected 2 as"]);
    let file = made(|builder| {
        train(builder);
        builder.set_attr("distance", AttrValue::AsciiString("hamming".into()));
    });
    assert_error("a.hdf5", file.dataset(), &["attribute distance", "found `hamming`", "expected euclidean or angular"]);
    let file = made(|builder| {
        train(builder);
        builder.set_attr("distance", AttrValue::I64(1));
    });
    assert_error("a.hdf5", file.dataset(), &["attribute distance", "expected a string"]);
    let alone = Written::new("a.bvecs", &[1, 0, 0, 0, 7]);
    assert_error("a.bvecs", alone.dataset(), &["queries", "no file of queries"]);
}

#[test]
fn cut_files() {
    let whole = unzip(PLAIN);
    let file = Written::new("a.hdf5", &whole);
    for length in (0..whole.len()).step_by(7) {
        file.rewrite(&whole[..length]);
        assert_error("a.hdf5", file.dataset(), &["found", "expected"]);
    }
}

/// A file in which the shape of `train` is replaced by another.
fn with_shape(bytes: &[u8], rows: u64, columns: u64) -> Vec<u8> {
    let shape = |rows: u64, columns: u64| [rows.to_le_bytes(), columns.to_le_bytes()].concat();
    let mut bytes = bytes.to_vec();
    let positions: Vec<usize> = (0..bytes.len() - 16).filter(|&i| bytes[i..i + 16] == shape(7, 5)).collect();
    assert!(!positions.is_empty());
    for position in positions {
        bytes[position..position + 16].copy_from_slice(&shape(rows, columns));
    }
    bytes
}

#[test]
fn hostile_sizes() {
    for bytes in [unzip(PLAIN), unzip(DEFLATED)] {
        for (rows, columns) in [(1 << 31, 1 << 20), (u64::MAX, u64::MAX), (1 << 40, 5), (7, 1 << 50), (1 << 63, 2)] {
            let file = Written::new("a.hdf5", &with_shape(&bytes, rows, columns));
            assert_error("a.hdf5", file.dataset(), &["train", "expected"]);
        }
        for (rows, columns) in [(0, 5), (7, 0)] {
            let file = Written::new("a.hdf5", &with_shape(&bytes, rows, columns));
            assert_error("a.hdf5", file.dataset(), &["expected"]);
        }
    }
}

/// Zeros, which deflate makes a thousand times smaller: their number is an error, before they are inflated.
#[test]
fn bombs_are_errors() {
    let (rows, columns) = (1 << 14, 64);
    let file = made(|builder| {
        let zeros = builder.create_dataset("train").with_f32_data(&vec![0.0; rows * columns]);
        zeros.with_shape(&[rows as u64, columns as u64]).with_chunks(&[1 << 12, columns as u64]).with_deflate(9);
    });
    assert!(std::fs::metadata(&file.path).expect("a file").len() < 16 << 10, "it is small");
    let needed = 8 * rows as u64 * (columns as u64 + 64);
    let read = |limit| read_vectors(&file.path, MemoryLimit::of(limit));
    let expected = format!("16384 vectors of 64 coordinates take {needed} bytes of memory, expected at most");
    assert_error("a.hdf5", read(needed - 1), &[&expected]);
    assert_eq!(read(needed).expect("within the limit").len(), rows);
}
