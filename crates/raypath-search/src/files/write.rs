use crate::answers::Answers;
use crate::vectors::Vectors;
use std::io::{self, Write};

/// Writes the neighbours of each query, nearest first, as `.ivecs`. Where an index found fewer for some query than for
/// another, −1 stands in the places that are left.
///
/// # Errors
/// Those of `out`.
pub fn write_ivecs(answers: &Answers, out: &mut impl Write) -> io::Result<()> {
    let count = answers.rows.iter().map(Vec::len).max().unwrap_or(0);
    for row in &answers.rows {
        out.write_all(&dimension(count)?.to_le_bytes())?;
        for rank in 0..count {
            // Indices beyond 2^31 wrap to what C's unsigned integers would be.
            let index = row.get(rank).map_or(-1, |near| near.index as i32);
            out.write_all(&index.to_le_bytes())?;
        }
    }
    Ok(())
}

/// Writes vectors as `.fvecs`.
///
/// # Errors
/// Those of `out`.
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
    i32::try_from(count).map_err(|_| io::Error::new(io::ErrorKind::InvalidInput, "more columns than a file can say"))
}
