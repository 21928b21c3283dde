//! Random damage to files, reproducible by seed.

use flate2::read::MultiGzDecoder;
use flate2::{Compression, write::GzEncoder};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::io::{Read, Write};

/// Inserted words, separated by `~`: punctuation of all formats, numbers at the ends of their ranges, and bytes that
/// are not text.
const WORDS: &[u8] =
    b"(~)~{~}~[~]~\"~\\~;~:~,~=~/*~\n~\0~'~!~ ~-1~0~1e999~-0.0~nan~inf~4294967296~18446744073709551615~\
    18446744073709551616~ffffffffffffffff~\xff~\xf0\x9f\x8e\xb2~null~g(){";
/// The largest size of a mutated file, in bytes.
const MAX_BYTES: usize = 64 << 10;

/// Mutation `number` of `files[file]`. Two of three compressed files are damaged before compression, so that they pass
/// the checksum.
pub fn mutated(files: &[Vec<u8>], file: usize, number: u64, seed: u64) -> Vec<u8> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ (file as u64) << 48);
    rng.set_stream(number);
    let other = &files[rng.random_range(0..files.len())];
    match unpacked(&files[file]) {
        Some(text) if rng.random_range(0..3) > 0 => {
            let other = unpacked(other).unwrap_or_else(|| other.clone());
            packed(&damaged(text, &other, &mut rng))
        }
        _ => damaged(files[file].clone(), other, &mut rng),
    }
}

fn damaged(mut bytes: Vec<u8>, other: &[u8], rng: &mut ChaCha8Rng) -> Vec<u8> {
    for _ in 0..rng.random_range(1..=4) {
        let (at, end) = (position(&bytes, rng), position(&bytes, rng));
        let range = at.min(end)..at.max(end);
        let near = at..bytes.len().min(at + rng.random_range(0..16));
        match rng.random_range(0..9) {
            0 => bytes.truncate(at),
            1 if at < bytes.len() => bytes[at] ^= 1 << rng.random_range(0..8),
            2 if at < bytes.len() => bytes[at] = rng.random(),
            3 => drop(bytes.drain(near)),
            4 => drop(bytes.drain(range)),
            5 => insert(&mut bytes, at, word(rng)),
            6 => drop(bytes.splice(near, word(rng).iter().copied())),
            7 => {
                let repeated = match rng.random() {
                    true => bytes[near].to_vec(),
                    false => word(rng).to_vec(),
                };
                let times = 1 << rng.random_range(1..12);
                insert(&mut bytes, at, &repeated.repeat(times));
            }
            _ => {
                let from = position(other, rng);
                bytes.truncate(at);
                bytes.extend_from_slice(&other[from..]);
            }
        }
    }
    bytes.truncate(MAX_BYTES);
    bytes
}

/// A random position, or the end.
fn position(bytes: &[u8], rng: &mut ChaCha8Rng) -> usize {
    rng.random_range(0..=bytes.len())
}

/// A random word of [`WORDS`].
fn word(rng: &mut ChaCha8Rng) -> &'static [u8] {
    let words: Vec<&[u8]> = WORDS.split(|byte| *byte == b'~').collect();
    words[rng.random_range(0..words.len())]
}

fn insert(bytes: &mut Vec<u8>, at: usize, inserted: &[u8]) {
    drop(bytes.splice(at..at, inserted.iter().copied()));
}

fn unpacked(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut text = Vec::new();
    MultiGzDecoder::new(bytes).take(MAX_BYTES as u64).read_to_end(&mut text).ok().map(|_| text)
}

fn packed(text: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    // Writing to memory cannot fail.
    encoder.write_all(text).and_then(|()| encoder.finish()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn mutations_are_many_different_ones_and_always_the_same() {
        let files = [b"library (x) { cell (y) { area : 1; } }".repeat(10), packed(&b"lanes = 2\n".repeat(20))];
        for file in 0..files.len() {
            let all: Vec<Vec<u8>> = (0..1000).map(|number| mutated(&files, file, number, 1)).collect();
            assert_eq!(all, (0..1000).map(|number| mutated(&files, file, number, 1)).collect::<Vec<_>>());
            let different = all.iter().collect::<HashSet<_>>().len();
            assert!(different > 700, "{different}");
            assert!(all.iter().any(|bytes| bytes.len() < files[file].len() / 2));
            assert!(all.iter().any(|bytes| unpacked(bytes).unwrap_or(bytes.clone()).len() > 1000));
        }
        let whole_gzip = (0..1000).filter(|&number| unpacked(&mutated(&files, 1, number, 1)).is_some()).count();
        assert!((500..950).contains(&whole_gzip), "{whole_gzip}");
    }
}
