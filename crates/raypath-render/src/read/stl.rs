use super::{Parsed, Soup};
use std::collections::HashMap;
use std::io::Cursor;

const HEADER: usize = 84;
const FACET: usize = 50;

/// By `stl_io`, after sorting out which of the two formats it is.
pub(super) fn parse(bytes: &[u8]) -> Parsed {
    let mut bytes = bytes.to_vec();
    if is_text(&bytes) {
        // `stl_io` wants a space after the word, where there is no name too.
        bytes.splice(..5, *b"solid ");
    } else {
        check_length(&bytes)?;
        // What is in a binary header means nothing, but "solid" would be taken for text.
        bytes[0] = 0;
    }
    let mut cursor = Cursor::new(bytes);
    let facets = stl_io::create_stl_reader(&mut cursor).map_err(|problem| format!("not STL: {problem}"))?;
    let (mut soup, mut known) = (Soup::default(), HashMap::new());
    for (number, facet) in facets.enumerate() {
        let facet = facet.map_err(|problem| format!("facet {number}: {problem}"))?;
        let mut corners = [0; 3];
        for (corner, vertex) in corners.iter_mut().zip(facet.vertices) {
            // -0 and 0 are one place.
            let position = vertex.0.map(|x| x + 0.0);
            *corner = *known.entry(position.map(f32::to_bits)).or_insert_with(|| {
                soup.positions.push(position);
                soup.positions.len() as u32 - 1
            });
        }
        soup.triangles.push(corners);
    }
    Ok(soup)
}

/// A file that begins like text and is not exactly as long as its binary header would have it.
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
                "{found} bytes, expected {claimed} for the {facets} facets of its header, or text that begins with 'solid'"
            ))
        }
        Some(_) => Ok(()),
    }
}
