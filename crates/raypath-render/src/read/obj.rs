use super::{Parsed, RawMesh};
use std::io::Cursor;
use tobj::{LoadError, LoadOptions};

/// Parses OBJ with `tobj`, after a check of all vertices and faces, because its messages have no line numbers.
pub(super) fn parse(bytes: &[u8]) -> Parsed {
    let text = std::str::from_utf8(bytes).map_err(|problem| {
        let line = 1 + bytes[..problem.valid_up_to()].iter().filter(|&&byte| byte == b'\n').count();
        format!("line {line}: not UTF-8, expected text")
    })?;
    check(text)?;
    let options = LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, single_index: false };
    let mut cursor = Cursor::new(bytes);
    let loaded = tobj::load_obj_buf(&mut cursor, &options, |_| Err(LoadError::OpenFileFailed));
    let (models, _) = loaded.map_err(|problem| {
        let line = bytes[..cursor.position() as usize].iter().filter(|&&byte| byte == b'\n').count();
        format!("line {line}: {problem}")
    })?;
    let mut raw = RawMesh::default();
    for mesh in models.into_iter().map(|model| model.mesh) {
        let first = raw.positions.len() as u32;
        raw.positions.extend(mesh.positions.as_chunks().0);
        raw.triangles.extend(mesh.indices.as_chunks().0.iter().map(|face: &[u32; 3]| face.map(|index| first + index)));
    }
    Ok(raw)
}

/// Checks that every vertex has three finite coordinates and every face at least three corners with indices of
/// preceding vertices.
fn check(text: &str) -> Result<(), String> {
    let mut vertices = 0_i64;
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        let problem = match words.next() {
            Some("v") => {
                vertices += 1;
                coordinates(words)
            }
            Some("f") => corners(words, vertices),
            _ => Ok(()),
        };
        problem.map_err(|problem| format!("line {}: {problem}", number + 1))?;
    }
    Ok(())
}

fn coordinates<'w>(mut words: impl Iterator<Item = &'w str>) -> Result<(), String> {
    for axis in ["x", "y", "z"] {
        let word = words.next().ok_or_else(|| format!("v without {axis}, expected three coordinates"))?;
        if !word.parse::<f32>().is_ok_and(f32::is_finite) {
            return Err(format!("{axis} = '{word}', expected a finite number"));
        }
    }
    Ok(())
}

fn corners<'w>(words: impl Iterator<Item = &'w str>, vertices: i64) -> Result<(), String> {
    let mut corners = 0;
    for word in words {
        corners += 1;
        let index = word.split('/').next().unwrap_or(word);
        let valid = index.parse::<i64>().is_ok_and(|index| index != 0 && index.unsigned_abs() <= vertices as u64);
        if !valid {
            return Err(format!(
                "corner '{word}', expected an index from 1 to {vertices}, the vertices so far, or its negative"
            ));
        }
    }
    if corners < 3 { Err(format!("f with {corners} corners, expected at least 3")) } else { Ok(()) }
}
