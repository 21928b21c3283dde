use super::common::{Written, assert_error, assert_neighbours_error, assert_vectors_error, base};
use crate::common::unzip;
use raypath_search::read_vectors;
use raypath_tools::MemoryLimit;

/// A file of version 1 with this header and data.
fn npy(header: &str, data: &[u8]) -> Vec<u8> {
    let length = u16::try_from(header.len() + 1).expect("short");
    [b"\x93NUMPY\x01\x00", &length.to_le_bytes()[..], header.as_bytes(), b"\n", data].concat()
}

fn header(kind: &str, shape: &str) -> String {
    format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}")
}

fn vectors_error(bytes: &[u8], parts: &[&str]) {
    assert_vectors_error("a.npy", bytes, parts);
}

fn neighbours_error(bytes: &[u8], base: usize, parts: &[&str]) {
    assert_neighbours_error("a.npy", bytes, base, parts);
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

#[test]
fn files_of_numpy() {
    let files: [(&str, &[u8]); 3] = [
        ("f4.npy", include_bytes!("../data/f4.npy.gz")),
        ("f8_fortran.npy", include_bytes!("../data/f8_fortran.npy.gz")),
        ("f4_big_endian.npy", include_bytes!("../data/f4_big_endian.npy.gz")),
    ];
    for (name, bytes) in files {
        let vectors = Written::new(name, &unzip(bytes)).vectors().expect("vectors");
        assert_eq!((vectors.dimensions(), vectors.data()), (5, &base()[..]), "{name}");
    }
    let file = Written::new("u1.npy", &unzip(include_bytes!("../data/u1_fortran.npy.gz")));
    let expected: Vec<f32> = base().iter().map(|x| x * 4.0 + 11.0).collect();
    assert_eq!(file.vectors().expect("vectors").data(), expected);

    let file = Written::new("i8.npy", &unzip(include_bytes!("../data/i8.npy.gz")));
    let truth = file.neighbours(7).expect("neighbours");
    assert_eq!((truth.queries(), truth.count()), (3, 4));
    assert_eq!(truth.rows().collect::<Vec<_>>(), [[2, 0, 6, 4], [5, 3, 1, 6], [6, 4, 0, 2]]);
}

#[test]
fn every_numeric_type() {
    fn one(kind: &str, bytes: &[u8]) {
        let file = Written::new("a.npy", &npy(&header(kind, "(1, 1)"), bytes));
        assert_eq!(file.vectors().expect(kind).data(), [5.0], "{kind}");
        if kind.contains(['i', 'u']) {
            assert_eq!(file.neighbours(6).expect(kind).rows().next(), Some(&[5][..]), "{kind}");
        }
    }
    one("<f2", &[0x00, 0x45]);
    one("<f4", &5f32.to_le_bytes());
    one(">f8", &5f64.to_be_bytes());
    one("|i1", &[5]);
    one("|u1", &[5]);
    one("<i2", &[5, 0]);
    one(">u2", &[0, 5]);
    one("<i4", &5i32.to_le_bytes());
    one("<u4", &5u32.to_le_bytes());
    one("<i8", &5i64.to_le_bytes());
    one("<u8", &5u64.to_le_bytes());
}

#[test]
fn cut_files() {
    let whole = npy(&header("<f4", "(2, 2)"), &floats(&[1.0, 2.0, 3.0, 4.0]));
    for length in 0..whole.len() {
        assert!(Written::new("a.npy", &whole[..length]).vectors().is_err(), "{length} bytes");
    }
    vectors_error(&whole[..7], &["header", "found the end of the file after 7 bytes"]);
    vectors_error(&whole[..whole.len() - 1], &["data", "found 15 bytes", "expected 2 x 2 of type '<f4'"]);
    let longer = [&whole[..], &[0]].concat();
    vectors_error(&longer, &["data", "found 17 bytes", "expected 2 x 2"]);
}

#[test]
fn wrong_files() {
    let data = floats(&[1.0, 2.0]);
    vectors_error(b"PK\x03\x04 a zip file", &["first bytes", "found \"PK"]);
    vectors_error(&npy(&header("<f4", "(2,)"), &data), &["shape [2]", "expected two axes"]);
    assert_vectors_error("a.npy", &npy(&header("<f4", "(2, 1, 1)"), &data), &["shape [2, 1, 1]", "expected two axes"]);
    vectors_error(&npy(&header("<c8", "(1, 1)"), &data), &["type '<c8'", "expected floats of 2, 4 or 8 bytes"]);
    vectors_error(&npy(&header("|b1", "(4, 2)"), &data), &["type '|b1'"]);
    vectors_error(&npy(&header("|O", "(4, 2)"), &data), &["type '|O'"]);
    vectors_error(&npy(&header("<q4", "(1, 2)"), &data), &["header", "Invalid type-string"]);
    vectors_error(&npy("{'descr': '<f4'}", &data), &["header", "fortran_order"]);
    vectors_error(&npy("words", &data), &["header", "expected a NumPy header"]);
    let record = "{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (1, 2), }";
    vectors_error(&npy(record, &data), &["type [('a', '<f4'), ]"]);
    assert_vectors_error(
        "a.npy",
        &npy(&header("<f4", "(1, 2)"), &floats(&[0.0, f32::NAN])),
        &["coordinate 1", "found NaN"],
    );
    vectors_error(&npy(&header("<f8", "(1, 1)"), &1e300f64.to_le_bytes()), &["coordinate 0", "found inf"]);

    neighbours_error(&npy(&header("<f4", "(1, 2)"), &data), 9, &["type '<f4'", "expected integers"]);
    let index = |index: i64| npy(&header("<i8", "(1, 1)"), &index.to_le_bytes());
    neighbours_error(&index(9), 9, &["query 0, neighbour 0", "found index 9", "expected 0 to 8"]);
    neighbours_error(&index(-1), 9, &["found index -1"]);
    neighbours_error(&index(1 << 32), 9, &["found index 4294967296"]);
    neighbours_error(&npy(&header("<u8", "(1, 1)"), &[0xff; 8]), 9, &["found index -1"]);
}

#[test]
fn hostile_files() {
    vectors_error(&npy(&header("<f4", "(0, 5)"), &[]), &["0 vectors, expected at least 1"]);
    vectors_error(&npy(&header("<f4", "(5, 0)"), &[]), &["0 dimensions"]);
    vectors_error(&npy(&header("<f4", "(0, 0)"), &[]), &["0 dimensions"]);
    vectors_error(&npy(&header("<f4", "(1, 65537)"), &vec![0; 4 * 65537]), &["65537 dimensions"]);
    neighbours_error(&npy(&header("<i4", "(0, 5)"), &[]), 1, &["no neighbours"]);
    neighbours_error(&npy(&header("<i4", "(5, 0)"), &[]), 1, &["no neighbours"]);
    for shape in ["(2147483648, 1024)", "(1, 4611686018427387)"] {
        vectors_error(&npy(&header("<f4", shape), &[0; 4]), &["found 4 bytes", "expected "]);
    }
    vectors_error(&npy(&header("<f4", "(4294967296, 0)"), &[]), &["4294967296 vectors of 0 coordinates take"]);
    for shape in [
        "(4294967296, 4294967296)",
        "(0, 4294967296, 4294967296, 16)",
        "(18446744073709551615, 1)",
        "(99999999999999999999999999, 1)",
        "(0xffffffffffffffff, 0xffffffffffffffff)",
        "(1_8446744073709551615, 9)",
        "((((((((((((((((((((1,),),),),),),),),),),),),),),),),),),), 1)",
    ] {
        vectors_error(&npy(&header("<f4", shape), &[0; 16]), &["header", "expected sizes of 64 bits"]);
    }
    vectors_error(&npy(&header("<f4", "(-1, 2)"), &[0; 16]), &["header", "negative"]);
    let long = [b"\x93NUMPY\x02\x00", &u32::MAX.to_le_bytes()[..], &[b' '; 100]].concat();
    vectors_error(&long, &["header", "found 4294967295 bytes", "expected 10000 at most"]);
    let file = Written::new("a.npy", &npy(&header("|u1", "(100, 10)"), &[0; 1000]));
    assert!(read_vectors(&file.path, MemoryLimit::of(100 * 8 * 74)).is_ok());
    let problem = read_vectors(&file.path, MemoryLimit::of(100 * 8 * 74 - 1));
    assert_error("a.npy", problem, &["100 vectors of 10 coordinates take 59200 bytes of memory"]);
}
