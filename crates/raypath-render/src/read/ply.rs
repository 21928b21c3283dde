use super::{Parsed, RawMesh};
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Header, Property, PropertyAccess, PropertyAccessResult};
use std::fmt::Display;
use std::io::Cursor;

/// Parses PLY with the crate `ply-rs-bw`, after a check of the header.
pub(super) fn parse(bytes: &[u8], mut raw: RawMesh) -> Parsed {
    // A byte of the file can become an index, or a vertex of another element, of 12 bytes.
    raw.limit.check(bytes.len() as u64, "bytes of PLY", 12)?;
    let mut reader = Reader::new(Cursor::new(bytes));
    let header = Parser::<Vertex>::new()
        .read_header(&mut reader)
        .map_err(|problem| format!("not PLY: {}", one_line(problem)))?;
    check(&header, bytes.len())?;
    for (name, element) in &header.elements {
        let wrong = |problem| format!("element {name}: {}", one_line(problem));
        match name.as_str() {
            "vertex" => {
                raw.check(element.count, 0)?;
                let vertices = Parser::<Vertex>::new().read_payload_for_element(&mut reader, element, &header);
                raw.positions.extend(vertices.map_err(wrong)?.into_iter().map(|vertex| vertex.0));
            }
            "face" => {
                raw.check(0, element.count)?;
                let faces =
                    Parser::<Face>::new().read_payload_for_element(&mut reader, element, &header).map_err(wrong)?;
                for (number, face) in faces.iter().enumerate() {
                    face.fan(&mut raw).map_err(|problem| format!("face {number}: {problem}"))?;
                }
            }
            // Another element is read and dropped.
            _ => {
                Parser::<Vertex>::new().read_payload_for_element(&mut reader, element, &header).map_err(wrong)?;
            }
        }
    }
    Ok(raw)
}

/// A message of the library on one line.
fn one_line(problem: impl Display) -> String {
    problem.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Checks that the header has vertices with coordinates and faces with indices, and no more elements than the file can
/// hold.
fn check(header: &Header, length: usize) -> Result<(), String> {
    for (name, element) in &header.elements {
        if element.count > length {
            return Err(format!(
                "{} of element {name}, expected no more than the {length} bytes of the file",
                element.count
            ));
        }
    }
    let has = |element: &str, properties: &[&str]| {
        let known = header.elements.get(element);
        known.is_some_and(|known| properties.iter().any(|property| known.properties.contains_key(*property)))
    };
    for axis in ["x", "y", "z"] {
        if !has("vertex", &[axis]) {
            return Err(format!("no property {axis} of element vertex, expected x, y and z"));
        }
    }
    if !has("face", &FACE_INDICES) {
        return Err(format!("no list {} of element face, expected one", FACE_INDICES.join(" or ")));
    }
    Ok(())
}

const FACE_INDICES: [&str; 2] = ["vertex_indices", "vertex_index"];

/// A vertex. Missing coordinates stay NaN, which [`Mesh::new`](crate::Mesh::new) rejects.
struct Vertex([f32; 3]);

struct Face(Vec<i64>);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self([f32::NAN; 3])
    }
    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let axis = ["x", "y", "z"].into_iter().position(|axis| axis == name);
        if let (Some(axis), Some(value)) = (axis, value.to_f32_lossy()) {
            self.0[axis] = value;
        }
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(Vec::new())
    }
    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if FACE_INDICES.contains(&name) {
            self.0 = match value {
                Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
                Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
                Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
                Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
                Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
                Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
                _ => Vec::new(),
            };
        }
        PropertyAccessResult::Set
    }
}

impl Face {
    fn fan(&self, raw: &mut RawMesh) -> Result<(), String> {
        let index = |&index: &i64| u32::try_from(index).map_err(|_| format!("index {index}, expected 0 or more"));
        raw.fan(&self.0.iter().map(index).collect::<Result<Vec<_>, _>>()?)
    }
}
