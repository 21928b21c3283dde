//! Meshes from files.

mod gltf;
mod obj;
mod ply;
mod stl;

use crate::mesh::{Mesh, MeshError};
use std::fmt;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A format of meshes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Wavefront OBJ; polygons become triangles, materials are ignored.
    Obj,
    /// glTF 2, as JSON or binary; the default scene with its transforms, triangles only. Buffers are in the file, in data
    /// URIs or in files beside it.
    Gltf,
    /// PLY, as text or binary of either byte order; polygons become fans.
    Ply,
    /// STL, as text or binary; equal vertices become one.
    Stl,
}

/// Why a file gave no mesh. Messages begin with the file.
#[derive(Debug, Error)]
pub enum ReadError {
    /// The name says nothing about the format.
    #[error("{}: extension {found}, expected one of {}", .path.display(), Known)]
    Extension {
        /// Which file.
        path: PathBuf,
        /// What its name ends in, in quotes, or "none".
        found: String,
    },
    /// The operating system refused.
    #[error("{}: cannot read: {problem}", .path.display())]
    File {
        /// Which file.
        path: PathBuf,
        /// What it said.
        problem: std::io::Error,
    },
    /// It is not what its name says, or not all of it is there.
    #[error("{}: {problem}", .path.display())]
    Content {
        /// Which file.
        path: PathBuf,
        /// Where, what was found, and what was expected.
        problem: String,
    },
    /// It can be read, but is no mesh.
    #[error("{}: {problem}", .path.display())]
    Mesh {
        /// Which file.
        path: PathBuf,
        /// Why not.
        problem: MeshError,
    },
}

/// Reads a mesh from a file whose extension says its format.
///
/// # Errors
/// An extension that is not known, a file that cannot be read, is not of that format, is cut off, or holds no mesh.
pub fn read_mesh(path: &Path) -> Result<Mesh, ReadError> {
    let format = Format::of(path)?;
    let bytes = std::fs::read(path).map_err(|problem| ReadError::File { path: path.to_owned(), problem })?;
    parse_mesh(format, &bytes, path)
}

/// Reads a mesh from the content of a file. `path` is for messages, and for the files beside it that a glTF names.
///
/// # Errors
/// Content that is not of that format, is cut off, or holds no mesh.
pub fn parse_mesh(format: Format, bytes: &[u8], path: &Path) -> Result<Mesh, ReadError> {
    let parsed = match format {
        Format::Obj => obj::parse(bytes),
        Format::Gltf => gltf::parse(bytes, path),
        Format::Ply => ply::parse(bytes),
        Format::Stl => stl::parse(bytes),
    };
    let Soup { positions, triangles } =
        parsed.map_err(|problem| ReadError::Content { path: path.to_owned(), problem })?;
    Mesh::new(positions, triangles).map_err(|problem| ReadError::Mesh { path: path.to_owned(), problem })
}

impl Format {
    /// The extensions that are known, and what they stand for.
    pub const EXTENSIONS: [(&'static str, Self); 5] =
        [("obj", Self::Obj), ("gltf", Self::Gltf), ("glb", Self::Gltf), ("ply", Self::Ply), ("stl", Self::Stl)];

    /// The format that a file's extension stands for, in either case.
    ///
    /// # Errors
    /// An extension that is not known, or none.
    pub fn of(path: &Path) -> Result<Self, ReadError> {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        let known = Self::EXTENSIONS.into_iter().find(|(name, _)| extension.as_deref() == Some(name));
        known.map(|(_, format)| format).ok_or_else(|| ReadError::Extension {
            path: path.to_owned(),
            found: extension.map_or("none".to_string(), |extension| format!("'{extension}'")),
        })
    }
}

/// The list of extensions for messages.
struct Known;

impl fmt::Display for Known {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = Format::EXTENSIONS.iter().map(|(name, _)| *name).collect();
        f.write_str(&names.join(", "))
    }
}

/// What a reader makes: a mesh that has not been checked.
#[derive(Default)]
struct Soup {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

/// A reader's result; the problem names the place in the file.
type Parsed = Result<Soup, String>;
