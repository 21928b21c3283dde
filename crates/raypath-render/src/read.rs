//! Readers of mesh files.

mod gltf;
mod obj;
mod ply;
mod stl;

use raypath_scene::mesh::Mesh;
use raypath_tools::MemoryLimit;
use std::borrow::Cow;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A mesh file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Wavefront OBJ; polygons become triangles, materials are ignored.
    Obj,
    /// glTF 2, as JSON or binary: the triangles of the default scene with its transforms. Buffers may be in the file,
    /// in data URIs or in other files of the same folder.
    Gltf,
    /// PLY, as text or binary of either byte order; polygons become triangle fans.
    Ply,
    /// STL, as text or binary; equal vertices are merged.
    Stl,
}

/// A file that cannot be read, or whose content is not valid. The message has the form `path:line: problem`.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{}:{} {problem}", path.display(), line.map_or(String::new(), |line| format!("{line}:")))]
pub struct ReadError {
    /// The file.
    pub path: PathBuf,
    /// The line of a file of rays or hits, from 1; `None` for a mesh, and if the file cannot be read.
    pub line: Option<usize>,
    /// The position in the file, what was found there, and what was expected.
    pub problem: String,
}

/// The bytes that a triangle takes at most, with its part of the tree and of what the tree is built from.
const TRIANGLE_BYTES: u128 = 512;
/// The bytes of a vertex, with its place among those that are merged.
const VERTEX_BYTES: u128 = 40;

/// Reads a mesh from a file. The extension determines the format.
///
/// # Errors
/// An unknown extension; a file that cannot be read, is not of its format, is truncated, or has no valid mesh; a mesh
/// that takes more memory than `limit`.
pub fn read_mesh(path: &Path, limit: MemoryLimit) -> Result<Mesh, ReadError> {
    let format = Format::of(path)?;
    parse_mesh(format, &read(path, limit)?, path, limit)
}

/// Reads a mesh from the content of a file. `path` appears in messages, and locates the other files that a glTF refers
/// to.
///
/// # Errors
/// Content that is not of the format, is truncated, or has no valid mesh; a mesh that takes more memory than `limit`:
/// 512 bytes for a triangle, 40 for a vertex, those of repeated meshes counted each time.
pub fn parse_mesh(format: Format, bytes: &[u8], path: &Path, limit: MemoryLimit) -> Result<Mesh, ReadError> {
    let raw = RawMesh { positions: Vec::new(), triangles: Vec::new(), limit };
    let parsed = match format {
        Format::Obj => obj::parse(bytes, raw),
        Format::Gltf => gltf::parse(bytes, path, raw),
        Format::Ply => ply::parse(bytes, raw),
        Format::Stl => stl::parse(bytes, raw),
    };
    let RawMesh { positions, triangles, .. } = parsed.map_err(|problem| ReadError::new(path, problem))?;
    Mesh::new(positions, triangles).map_err(|problem| ReadError::new(path, problem.to_string()))
}

fn read(path: &Path, limit: MemoryLimit) -> Result<Vec<u8>, ReadError> {
    limit.read(path).map_err(|problem| ReadError::new(path, format!("cannot read: {problem}")))
}

/// The text of a file whose lines take `each` bytes when they are parsed.
pub(crate) fn text(path: &Path, limit: MemoryLimit, each: u64) -> Result<String, ReadError> {
    let text = String::from_utf8(read(path, limit)?);
    let text = text.map_err(|_| ReadError::new(path, "cannot read: no UTF-8, expected text".to_string()))?;
    let lines = text.lines().count() as u64;
    limit.check(lines, "lines", each).map_err(|problem| ReadError::new(path, problem))?;
    Ok(text)
}

/// What `parse` makes of each line, comments and empty lines left out.
pub(crate) fn parse_lines<T>(
    text: &str,
    path: &Path,
    parse: impl Fn(&str) -> Result<T, String>,
) -> Result<Vec<T>, ReadError> {
    let lines = text.lines().enumerate().map(|(index, line)| (index + 1, line.split('#').next().unwrap_or("")));
    let filled = lines.filter(|(_, line)| !line.trim().is_empty());
    let parsed =
        |(line, text)| parse(text).map_err(|problem| ReadError { line: Some(line), ..ReadError::new(path, problem) });
    filled.map(parsed).collect()
}

impl ReadError {
    pub(crate) fn new(path: &Path, problem: String) -> Self {
        Self { path: path.to_owned(), line: None, problem }
    }
}

impl Format {
    /// The known extensions with their formats.
    pub const EXTENSIONS: [(&'static str, Self); 5] =
        [("obj", Self::Obj), ("gltf", Self::Gltf), ("glb", Self::Gltf), ("ply", Self::Ply), ("stl", Self::Stl)];

    /// The format of a file by its extension, in upper or lower case.
    ///
    /// # Errors
    /// An unknown extension, or none.
    pub fn of(path: &Path) -> Result<Self, ReadError> {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        let known = Self::EXTENSIONS.into_iter().find(|(name, _)| extension.as_deref() == Some(name));
        known.map(|(_, format)| format).ok_or_else(|| {
            let found = extension.map_or("none".to_string(), |extension| format!("'{extension}'"));
            let expected = Self::EXTENSIONS.map(|(name, _)| name).join(", ");
            ReadError::new(path, format!("extension {found}, expected one of {expected}"))
        })
    }
}

/// The positions and triangles of a file, not yet validated.
struct RawMesh {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    limit: MemoryLimit,
}

/// The result of a reader. The error names the position in the file.
type Parsed = Result<RawMesh, String>;

impl RawMesh {
    /// Checks that more vertices and triangles are within the limit.
    fn check(&self, vertices: usize, triangles: usize) -> Result<(), String> {
        let vertices = (self.positions.len() as u64).saturating_add(vertices as u64);
        let triangles = (self.triangles.len() as u64).saturating_add(triangles as u64);
        let bytes = u128::from(vertices) * VERTEX_BYTES + u128::from(triangles) * TRIANGLE_BYTES;
        self.limit.check_bytes(format_args!("{vertices} vertices and {triangles} triangles"), bytes)
    }

    /// Adds the triangles of a polygon, as a fan from its first corner.
    fn fan(&mut self, corners: &[u32]) -> Result<(), String> {
        let [first, others @ ..] = corners else { return Err("0 corners, expected at least 3".to_string()) };
        if others.len() < 2 {
            return Err(format!("{} corners, expected at least 3", corners.len()));
        }
        self.check(0, others.len() - 1)?;
        self.triangles.extend(others.windows(2).map(|pair| [*first, pair[0], pair[1]]));
        Ok(())
    }
}

/// The text of a file without a byte order mark. Names and comments can have bytes that are no UTF-8.
fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))
}

/// The three finite coordinates that follow a keyword. More words are ignored.
fn coordinates<'w>(keyword: &str, mut words: impl Iterator<Item = &'w str>) -> Result<[f32; 3], String> {
    let mut position = [0.0; 3];
    for (axis, coordinate) in ["x", "y", "z"].into_iter().zip(&mut position) {
        let word = words.next().ok_or_else(|| format!("{keyword} without {axis}, expected three coordinates"))?;
        let number = word.parse::<f32>().ok().filter(|number| number.is_finite());
        *coordinate = number.ok_or_else(|| format!("{axis} = '{word}', expected a finite number"))?;
    }
    Ok(position)
}
