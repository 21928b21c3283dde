//! Readers of mesh files.

mod gltf;
mod obj;
mod ply;
mod stl;

use crate::mesh::Mesh;
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

/// Reads a mesh from a file. The extension determines the format.
///
/// # Errors
/// An unknown extension; a file that cannot be read, is not of its format, is truncated, or has no valid mesh.
pub fn read_mesh(path: &Path) -> Result<Mesh, ReadError> {
    let format = Format::of(path)?;
    let bytes = std::fs::read(path).map_err(|problem| ReadError::new(path, format!("cannot read: {problem}")))?;
    parse_mesh(format, &bytes, path)
}

/// Reads a mesh from the content of a file. `path` appears in messages, and locates the other files that a glTF refers
/// to.
///
/// # Errors
/// Content that is not of the format, is truncated, or has no valid mesh.
pub fn parse_mesh(format: Format, bytes: &[u8], path: &Path) -> Result<Mesh, ReadError> {
    let parsed = match format {
        Format::Obj => obj::parse(bytes),
        Format::Gltf => gltf::parse(bytes, path),
        Format::Ply => ply::parse(bytes),
        Format::Stl => stl::parse(bytes),
    };
    let RawMesh { positions, triangles } = parsed.map_err(|problem| ReadError::new(path, problem))?;
    Mesh::new(positions, triangles).map_err(|problem| ReadError::new(path, problem.to_string()))
}

/// The text of a file.
pub(crate) fn text(path: &Path) -> Result<String, ReadError> {
    std::fs::read_to_string(path).map_err(|problem| ReadError::new(path, format!("cannot read: {problem}")))
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
#[derive(Default)]
struct RawMesh {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

/// The result of a reader. The error names the position in the file.
type Parsed = Result<RawMesh, String>;
