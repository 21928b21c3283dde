use crate::{SearchResults, Vectors};
use std::io::{self, Write};

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
