use super::{Parsed, RawMesh, coordinates, decoded};
use std::collections::HashMap;

const HEADER: usize = 84;
const FACET: usize = 50;

/// Parses STL, text or binary. Normals are redundant, and ignored.
pub(super) fn parse(bytes: &[u8], raw: RawMesh) -> Parsed {
    let mut merged = Merged { raw, known: HashMap::new() };
    if is_text(bytes) {
        merged.add_text(&decoded(bytes))?
    } else {
        merged.add_binary(bytes)?
    }
    Ok(merged.raw)
}

/// Whether a file begins as text does. A binary header can, too, but binary files have the length that their header
/// says, or bytes of 0.
fn is_text(bytes: &[u8]) -> bool {
    let begin = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    begin.get(..5).is_some_and(|keyword| keyword.eq_ignore_ascii_case(b"solid"))
        && claimed_length(bytes) != Some(bytes.len())
        && !bytes.contains(&0)
}

fn claimed_length(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER - 4..)?.first_chunk()?;
    (u32::from_le_bytes(*count) as usize).checked_mul(FACET)?.checked_add(HEADER)
}

/// A mesh whose equal vertices are merged.
struct Merged {
    raw: RawMesh,
    known: HashMap<[u32; 3], u32>,
}

impl Merged {
    fn add(&mut self, corners: [[f32; 3]; 3]) -> Result<(), String> {
        self.raw.check(3, 1)?;
        // Adding 0 turns -0 into 0, so that both merge.
        let corners = corners.map(|corner| corner.map(|x| x + 0.0)).map(|position| {
            *self.known.entry(position.map(f32::to_bits)).or_insert_with(|| {
                self.raw.positions.push(position);
                self.raw.positions.len() as u32 - 1
            })
        });
        self.raw.triangles.push(corners);
        Ok(())
    }

    fn add_binary(&mut self, bytes: &[u8]) -> Result<(), String> {
        let found = bytes.len();
        let Some(claimed) = claimed_length(bytes) else {
            return Err(format!("{found} bytes, expected 'solid' or a binary header of {HEADER}"));
        };
        if claimed > found {
            let facets = (claimed - HEADER) / FACET;
            let expected = "or text after 'solid', without bytes of 0";
            return Err(format!("{found} bytes, expected {claimed} for the {facets} facets of its header, {expected}"));
        }
        for facet in bytes[HEADER..claimed].as_chunks::<FACET>().0 {
            let number = |index: usize| {
                let at = 12 + 4 * index;
                f32::from_le_bytes([facet[at], facet[at + 1], facet[at + 2], facet[at + 3]])
            };
            self.add([0, 1, 2].map(|corner| [0, 1, 2].map(|axis| number(3 * corner + axis))))?;
        }
        Ok(())
    }

    /// Adds the facets of all solids of a text. Keywords may be in capitals.
    fn add_text(&mut self, text: &str) -> Result<(), String> {
        let (mut is_solid, mut corners) = (false, Vec::new());
        for (number, line) in text.lines().enumerate() {
            self.add_line(line, &mut is_solid, &mut corners)
                .map_err(|problem| format!("line {}: {problem}", number + 1))?;
        }
        if is_solid { Err("the end of the file in a solid, expected endsolid".to_string()) } else { Ok(()) }
    }

    fn add_line(&mut self, line: &str, is_solid: &mut bool, corners: &mut Vec<[f32; 3]>) -> Result<(), String> {
        let mut words = line.split_whitespace();
        let Some(keyword) = words.next() else { return Ok(()) };
        match keyword.to_ascii_lowercase().as_str() {
            "solid" => *is_solid = true,
            "endsolid" => *is_solid = false,
            "vertex" => corners.push(coordinates("vertex", words)?),
            "facet" | "outer" | "endloop" => {}
            "endfacet" => {
                let corners = std::mem::take(corners);
                let found = corners.len();
                let three = corners.try_into().map_err(|_| format!("a facet of {found} vertices, expected 3"))?;
                self.add(three)?;
            }
            _ => {
                return Err(format!(
                    "'{keyword}', expected solid, facet, outer, vertex, endloop, endfacet or endsolid"
                ));
            }
        }
        Ok(())
    }
}
