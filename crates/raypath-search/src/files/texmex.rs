//! `.fvecs`, `.bvecs` and `.ivecs`: each vector is preceded by its dimension in four bytes, little-endian.

use super::{FileError, check};
use crate::vectors::MAX_DIMENSIONS;
use crate::{SearchResults, Vectors};
use raypath_tools::MemoryLimit;
use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

/// Reads the dimension and all coordinates, of `S` bytes each.
pub(super) fn read<const S: usize, T>(
    file: &Path,
    limit: MemoryLimit,
    decode: impl Fn([u8; S]) -> T,
) -> Result<(usize, Vec<T>), FileError> {
    let io = FileError::of(file);
    let source = File::open(file).map_err(&io)?;
    let length = source.metadata().map_err(&io)?.len();
    let mut source = Bytes { file, source: BufReader::new(source), at: 0, length };

    let dimensions = source.dimension(0)?;
    let expected = format!("1 to {MAX_DIMENSIONS}");
    let dimensions = usize::try_from(dimensions)
        .ok()
        .filter(|dimensions| (1..=MAX_DIMENSIONS).contains(dimensions))
        .ok_or_else(|| FileError::content(file, "dimension of vector 0", dimensions, &expected))?;

    let record = 4 + dimensions * S;
    let vectors = length / record as u64;
    check(file, vectors, dimensions as u64, limit)?;
    let mut data = Vec::with_capacity(vectors as usize * dimensions);
    let mut bytes = vec![0; dimensions * S];
    for vector in 0.. {
        if vector > 0 {
            if source.is_at_end() {
                break;
            }
            let found = source.dimension(vector)?;
            if usize::try_from(found) != Ok(dimensions) {
                let expected = format!("{dimensions} as in vector 0");
                return Err(FileError::content(file, format_args!("dimension of vector {vector}"), found, expected));
            }
        }
        source.fill(&mut bytes, vector)?;
        data.extend(bytes.as_chunks::<S>().0.iter().map(|&bytes| decode(bytes)));
    }
    Ok((dimensions, data))
}

struct Bytes<'f> {
    file: &'f Path,
    source: BufReader<File>,
    at: u64,
    length: u64,
}

impl Bytes<'_> {
    fn is_at_end(&self) -> bool {
        self.at == self.length
    }

    fn dimension(&mut self, vector: usize) -> Result<i32, FileError> {
        let mut bytes = [0; 4];
        self.fill(&mut bytes, vector)?;
        Ok(i32::from_le_bytes(bytes))
    }

    fn fill(&mut self, bytes: &mut [u8], vector: usize) -> Result<(), FileError> {
        let left = self.length.saturating_sub(self.at);
        if left < bytes.len() as u64 {
            let expected = format!("{} more of vector {vector}", bytes.len());
            return Err(FileError::content(self.file, format_args!("byte {}", self.at), left_over(left), expected));
        }
        self.source.read_exact(bytes).map_err(FileError::of(self.file))?;
        self.at += bytes.len() as u64;
        Ok(())
    }
}

fn left_over(bytes: u64) -> String {
    if bytes == 0 { "the end of the file".to_owned() } else { format!("the last {bytes} bytes") }
}

/// Writes the neighbours of each query, nearest first, as `.ivecs`. Rows with fewer neighbours are padded with −1.
///
/// # Errors
/// The errors of `out`.
pub fn write_ivecs(results: &SearchResults, out: &mut impl Write) -> io::Result<()> {
    let count = results.rows.iter().map(Vec::len).max().unwrap_or(0);
    for row in &results.rows {
        out.write_all(&dimension(count)?.to_le_bytes())?;
        for rank in 0..count {
            // Indices from 2^31 on wrap to the bits of an unsigned integer.
            let index = row.get(rank).map_or(-1, |near| near.index as i32);
            out.write_all(&index.to_le_bytes())?;
        }
    }
    Ok(())
}

/// Writes vectors as `.fvecs`.
///
/// # Errors
/// The errors of `out`.
pub fn write_fvecs(vectors: &Vectors, out: &mut impl Write) -> io::Result<()> {
    for vector in vectors.iter() {
        out.write_all(&dimension(vector.len())?.to_le_bytes())?;
        for x in vector {
            out.write_all(&x.to_le_bytes())?;
        }
    }
    Ok(())
}

fn dimension(count: usize) -> io::Result<i32> {
    i32::try_from(count)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidInput, "more columns than the format can represent"))
}
