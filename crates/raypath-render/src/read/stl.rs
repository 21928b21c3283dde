use super::{Parsed, RawMesh};
use std::collections::HashMap;
use std::io::Cursor;

const HEADER: usize = 84;
const FACET: usize = 50;

/// Parses STL with the crate `stl_io`, after distinguishing text and binary files.
pub(super) fn parse(bytes: &[u8]) -> Parsed {
    let mut bytes = bytes.to_vec();
    if is_text(&bytes) {
        // `stl_io` requires a space after the keyword, even without a name.
        bytes.splice(..5, *b"solid ");
    } else {
        check_length(&bytes)?;
        // A binary header has no meaning, but `stl_io` would take "solid" for a text file.
        bytes[0] = 0;
    }
    let mut cursor = Cursor::new(bytes);
    let facets = stl_io::create_stl_reader(&mut cursor).map_err(|problem| format!("not STL: {problem}"))?;
    let (mut raw, mut known) = (RawMesh::default(), HashMap::new());
    for (number, facet) in facets.enumerate() {
        let facet = facet.map_err(|problem| format!("facet {number}: {problem}"))?;
        let mut corners = [0; 3];
        for (corner, vertex) in corners.iter_mut().zip(facet.vertices) {
            // Adding 0 turns -0 into 0, so that both merge.
            let position = vertex.0.map(|x| x + 0.0);
            *corner = *known.entry(position.map(f32::to_bits)).or_insert_with(|| {
                raw.positions.push(position);
                raw.positions.len() as u32 - 1
            });
        }
        raw.triangles.push(corners);
    }
    Ok(raw)
}

/// Whether a file starts as text and its length does not match a binary header.
fn is_text(bytes: &[u8]) -> bool {
    bytes.starts_with(b"solid")
        && bytes.get(5).is_some_and(u8::is_ascii_whitespace)
        && claimed_length(bytes) != Some(bytes.len())
}

fn claimed_length(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER - 4..)?.first_chunk()?;
    (u32::from_le_bytes(*count) as usize).checked_mul(FACET)?.checked_add(HEADER)
}

fn check_length(bytes: &[u8]) -> Result<(), String> {
    let found = bytes.len();
    match claimed_length(bytes) {
        None => Err(format!("{found} bytes, expected 'solid' or a binary header of {HEADER}")),
        Some(claimed) if claimed > found => {
            let facets = (claimed - HEADER) / FACET;
            Err(format!(
                "{found} bytes, expected {claimed} for the {facets} facets of its header, or text after 'solid'"
            ))
        }
        Some(_) => Ok(()),
    }
}
