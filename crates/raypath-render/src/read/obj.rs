use super::{Parsed, RawMesh, coordinates, decoded};

/// Parses OBJ: the vertices and faces. A polygon becomes a fan from its first corner.
///
/// A comment begins with `#` anywhere in a line. A `\\` at the end of a line, which is not in a comment, continues it.
pub(super) fn parse(bytes: &[u8], mut raw: RawMesh) -> Parsed {
    let text = decoded(bytes);
    let mut lines = text.lines().map(|line| line.split('#').next().unwrap_or("").trim_end()).enumerate();
    let mut statement = String::new();
    while let Some((number, line)) = lines.next() {
        statement.clear();
        statement.push_str(line);
        while statement.ends_with('\\') {
            statement.pop();
            statement.push(' ');
            statement.push_str(lines.next().map_or("", |(_, line)| line));
        }
        raw.add(&statement).map_err(|problem| format!("line {}: {problem}", number + 1))?;
    }
    Ok(raw)
}

impl RawMesh {
    /// Adds the vertex or the face of a statement, if it has one.
    fn add(&mut self, statement: &str) -> Result<(), String> {
        let mut words = statement.split_whitespace();
        match words.next() {
            Some("v") => {
                self.check(1, 0)?;
                self.positions.push(coordinates("v", words)?);
            }
            Some("f") => {
                let vertices = self.positions.len();
                let corners = words.map(|word| corner(word, vertices)).collect::<Result<Vec<_>, _>>()?;
                self.fan(&corners).map_err(|problem| format!("f with {problem}"))?;
            }
            _ => {}
        }
        Ok(())
    }
}

/// The vertex of a corner: the number before the first slash, from 1, or from the last vertex backwards if negative.
fn corner(word: &str, vertices: usize) -> Result<u32, String> {
    let index = word.split('/').next().and_then(|index| index.parse::<i64>().ok());
    let index = index.and_then(|index| if index < 0 { index.checked_add(vertices as i64) } else { Some(index - 1) });
    index.filter(|index| (0..vertices as i64).contains(index)).and_then(|index| u32::try_from(index).ok()).ok_or_else(
        || format!("corner '{word}', expected an index from 1 to {vertices}, the vertices so far, or its negative"),
    )
}
