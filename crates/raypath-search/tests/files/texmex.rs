use super::common::{Written, assert_error, assert_neighbours_error, assert_vectors_error};
use raypath_search::{Neighbour, SearchResults, Vectors, Work, write_fvecs, write_ivecs};
use raypath_tools::MemoryLimit;

/// Records with the given dimension fields and content.
fn records<const S: usize>(rows: &[(i32, Vec<[u8; S]>)]) -> Vec<u8> {
    rows.iter().flat_map(|(dimension, row)| [&dimension.to_le_bytes()[..], row.as_flattened()].concat()).collect()
}

fn floats(rows: &[(i32, &[f32])]) -> Vec<u8> {
    records(&rows.iter().map(|(n, row)| (*n, row.iter().map(|x| x.to_le_bytes()).collect())).collect::<Vec<_>>())
}

fn integers(rows: &[(i32, &[i32])]) -> Vec<u8> {
    records(&rows.iter().map(|(n, row)| (*n, row.iter().map(|x| x.to_le_bytes()).collect())).collect::<Vec<_>>())
}

fn bytes(rows: &[(i32, &[u8])]) -> Vec<u8> {
    records(&rows.iter().map(|(n, row)| (*n, row.iter().map(|&x| [x]).collect())).collect::<Vec<_>>())
}

#[test]
fn good_files() {
    let file = Written::new("a.fvecs", &floats(&[(3, &[1.0, -2.5, 1e-40]), (3, &[0.0, 3.0, 4.0])]));
    let expected = Vectors::new(3, vec![1.0, -2.5, 1e-40, 0.0, 3.0, 4.0]).expect("vectors");
    assert_eq!(file.vectors().expect("vectors"), expected);
    let mut written = Vec::new();
    write_fvecs(&expected, &mut written).expect("written");
    assert_eq!(written, std::fs::read(&file.path).expect("bytes"));

    let file = Written::new("A.BVECS", &bytes(&[(2, &[0, 255]), (2, &[7, 128])]));
    assert_eq!(file.vectors().expect("vectors").data(), [0.0, 255.0, 7.0, 128.0]);

    let file = Written::new("a.ivecs", &integers(&[(2, &[-1, 1 << 20]), (2, &[3, 4])]));
    assert_eq!(file.vectors().expect("vectors").data(), [-1.0, 1_048_576.0, 3.0, 4.0]);

    let file = Written::new("a.ivecs", &integers(&[(2, &[9, 0]), (2, &[3, 4])]));
    let truth = file.neighbours(10).expect("neighbours");
    assert_eq!((truth.queries(), truth.count()), (2, 2));
    assert_eq!(truth.rows().collect::<Vec<_>>(), [[9, 0], [3, 4]]);
}

#[test]
fn results_are_written_as_neighbours() {
    let near = |index| Neighbour { index, distance: 0.0 };
    let rows = vec![vec![near(5), near(3)], vec![near(0), near(1)]];
    let mut results = SearchResults { rows, work: Work::default(), seconds: 0.0 };
    let mut written = Vec::new();
    write_ivecs(&results, &mut written).expect("written");
    let read = Written::new("a.ivecs", &written).neighbours(6).expect("neighbours");
    assert_eq!(read.rows().collect::<Vec<_>>(), [[5, 3], [0, 1]]);

    results.rows[1].pop();
    written.clear();
    write_ivecs(&results, &mut written).expect("written");
    assert_eq!(written, integers(&[(2, &[5, 3]), (2, &[0, -1])]));
}

#[test]
fn cut_files() {
    let whole = floats(&[(3, &[1.0, 2.0, 3.0]), (3, &[4.0, 5.0, 6.0])]);
    for length in 0..whole.len() {
        let file = Written::new("a.fvecs", &whole[..length]);
        if length == 16 {
            assert_eq!(file.vectors().expect("one vector").len(), 1);
        } else {
            assert_error("a.fvecs", file.vectors(), &["found the ", "more of vector"]);
        }
    }
    assert_vectors_error("a.fvecs", &[], &["byte 0", "found the end of the file", "expected 4 more of vector 0"]);
    assert_vectors_error(
        "a.fvecs",
        &whole[..30],
        &["byte 20", "found the last 10 bytes", "expected 12 more of vector 1"],
    );
    assert_vectors_error(
        "a.bvecs",
        &[3, 0, 0, 0, 1],
        &["byte 4", "found the last 1 bytes", "expected 3 more of vector 0"],
    );
}

#[test]
fn wrong_files() {
    let file = floats(&[(2, &[1.0, 2.0]), (3, &[1.0, 2.0, 3.0])]);
    assert_vectors_error("a.fvecs", &file, &["dimension of vector 1", "found 3", "expected 2 as in vector 0"]);
    let file = floats(&[(2, &[1.0, 2.0]), (2, &[1.0, f32::NAN])]);
    assert_vectors_error("a.fvecs", &file, &["vector 1, coordinate 1", "found NaN", "finite"]);
    let file = floats(&[(1, &[f32::NEG_INFINITY])]);
    assert_vectors_error("a.fvecs", &file, &["vector 0, coordinate 0", "found -inf"]);
    assert_vectors_error("a.vecs", &[], &["extension", "found `vecs`", "expected fvecs, bvecs, ivecs, npy or hdf5"]);
    assert_vectors_error("a", &[], &["extension", "found ``"]);
    assert_neighbours_error("a.fvecs", &[], 1, &["extension", "found `fvecs`", "expected ivecs, npy or hdf5"]);

    let file = integers(&[(2, &[0, 1]), (2, &[3, 10])]);
    assert_neighbours_error("a.ivecs", &file, 10, &["query 1, neighbour 1", "found index 10", "expected 0 to 9"]);
    let file = integers(&[(2, &[0, -1])]);
    assert_neighbours_error("a.ivecs", &file, 10, &["query 0, neighbour 1", "found index -1"]);

    let directory = Written::new("a.fvecs", &[]).directory;
    let absent = raypath_search::read_vectors(&directory.path().join("absent.fvecs"), MemoryLimit::DEFAULT);
    assert_error("absent.fvecs", absent, &["No such file"]);
}

#[test]
fn hostile_files() {
    for dimension in [0, -1, i32::MIN, i32::MAX, 65_537] {
        let file = floats(&[(dimension, &[1.0])]);
        let found = format!("found {dimension}");
        assert_vectors_error("a.fvecs", &file, &["dimension of vector 0", &found, "expected 1 to 65536"]);
        assert_neighbours_error("a.ivecs", &file, 1, &["dimension of vector 0", &found, "expected 1 to 65536"]);
        let file = floats(&[(1, &[1.0]), (dimension, &[1.0])]);
        assert_vectors_error("a.fvecs", &file, &["dimension of vector 1", &found]);
    }
    assert_vectors_error("a.fvecs", &floats(&[(65_536, &[1.0])]), &["found the last 4 bytes", "expected 262144 more"]);
    let file = Written::new("a.bvecs", &bytes(&[(2, &[0, 255]), (2, &[7, 128])]));
    let problem = raypath_search::read_vectors(&file.path, MemoryLimit::of(2 * 8 * 66 - 1));
    assert_error("a.bvecs", problem, &["2 vectors of 2 coordinates take 1056 bytes of memory, expected at most 1055"]);
}
