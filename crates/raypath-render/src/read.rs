//! Readers of mesh files.

mod gltf;
mod obj;
mod ply;
mod stl;

use crate::mesh::{Mesh, MeshError};
use std::fmt;
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

/// The reason why a mesh file could not be read. Messages begin with the path.
#[derive(Debug, Error)]
pub enum ReadError {
    /// The extension is unknown.
    #[error("{}: extension {found}, expected one of {}", .path.display(), KnownExtensions)]
    Extension {
        /// The file.
        path: PathBuf,
        /// The extension in quotes, or "none".
        found: String,
    },
    /// The operating system could not read the file.
    #[error("{}: cannot read: {problem}", .path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The error.
        problem: std::io::Error,
    },
    /// The content is not of the format, or is incomplete.
    #[error("{}: {problem}", .path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// The position in the file, what was found there, and what was expected.
        problem: String,
    },
    /// The content is not a valid mesh.
    #[error("{}: {problem}", .path.display())]
    Mesh {
        /// The file.
        path: PathBuf,
        /// The error.
        problem: MeshError,
    },
}

/// Reads a mesh from a file. The extension determines the format.
///
/// # Errors
/// An unknown extension; a file that cannot be read, is not of its format, is truncated, or has no valid mesh.
pub fn read_mesh(path: &Path) -> Result<Mesh, ReadError> {
    let format = Format::of(path)?;
    let bytes = std::fs::read(path).map_err(|problem| ReadError::File { path: path.to_owned(), problem })?;
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
    let RawMesh { positions, triangles } =
        parsed.map_err(|problem| ReadError::Content { path: path.to_owned(), problem })?;
    Mesh::new(positions, triangles).map_err(|problem| ReadError::Mesh { path: path.to_owned(), problem })
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
        known.map(|(_, format)| format).ok_or_else(|| ReadError::Extension {
            path: path.to_owned(),
            found: extension.map_or("none".to_string(), |extension| format!("'{extension}'")),
        })
    }
}

/// Displays the known extensions.
struct KnownExtensions;

impl fmt::Display for KnownExtensions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = Format::EXTENSIONS.iter().map(|(name, _)| *name).collect();
        f.write_str(&names.join(", "))
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
