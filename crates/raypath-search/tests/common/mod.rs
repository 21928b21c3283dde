//! The digits of `tests/data`.

pub mod datapath;

use flate2::read::GzDecoder;
use raypath_search::Vectors;
use std::io::Read;

/// Pixels of a digit.
pub const PIXELS: usize = 64;

/// All 1797 digits, as integers.
pub fn digits() -> Vec<[u8; PIXELS]> {
    let lines = unzip_text(include_bytes!("../data/digits.csv.gz"));
    let digits = lines.lines().map(|line| {
        let numbers: Vec<u8> = line.split(',').map(|number| number.parse().expect("an integer")).collect();
        assert_eq!(numbers.len(), PIXELS + 1);
        std::array::from_fn(|i| numbers[i])
    });
    digits.collect()
}

/// Digits as vectors.
pub fn vectors<'d>(digits: impl IntoIterator<Item = &'d [u8; PIXELS]>) -> Vectors {
    Vectors::new(PIXELS, digits.into_iter().flatten().map(|&pixel| pixel.into()).collect()).expect("vectors")
}

/// The text in a gzip file.
pub fn unzip_text(bytes: &[u8]) -> String {
    String::from_utf8(unzip(bytes)).expect("text")
}

/// The bytes in a gzip file.
pub fn unzip(bytes: &[u8]) -> Vec<u8> {
    let mut data = Vec::new();
    GzDecoder::new(bytes).read_to_end(&mut data).expect("gzip");
    data
}
