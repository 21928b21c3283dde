//! A mesh and the tree over it: what rays are traced through.

use crate::bvh::{Bvh4, MeshTooLarge};
use crate::mesh::{Bounds, Mesh};

/// How many times the mesh's longest side ray origins may be away where nothing else is said.
const DEFAULT_REACH: f32 = 16.0;

/// A mesh with the tree that rays are traced through, made for rays that begin within its [`reach`](Self::reach).
#[derive(Debug, Clone)]
pub struct Scene {
    mesh: Mesh,
    bounds: Bounds,
    bvh: Bvh4,
}

impl Scene {
    /// The scene of a mesh, for rays that begin within 16 times its longest side.
    ///
    /// # Errors
    /// More than [`Bvh4::MOST_TRIANGLES`] triangles.
    pub fn new(mesh: Mesh) -> Result<Self, MeshTooLarge> {
        let bounds = mesh.bounds();
        Self::with_reach(mesh, DEFAULT_REACH * bounds.longest_side())
    }

    /// The scene of a mesh, for rays that begin at one of `origins`, or within 16 times its longest side.
    ///
    /// # Errors
    /// More than [`Bvh4::MOST_TRIANGLES`] triangles.
    pub fn for_origins(mesh: Mesh, origins: impl IntoIterator<Item = [f32; 3]>) -> Result<Self, MeshTooLarge> {
        let bounds = mesh.bounds();
        let near = DEFAULT_REACH * bounds.longest_side();
        let reach = origins.into_iter().map(|origin| bounds.reach_from(origin)).fold(near, f32::max);
        Self::with_reach(mesh, reach)
    }

    /// The scene of a mesh, for rays from whose origins no point of it is farther than `reach` along any axis. Boxes are
    /// padded in proportion (see [`Bvh4`]), so a greater reach costs a little time. It is at least what rays that begin
    /// inside the mesh's bounds need.
    ///
    /// # Errors
    /// More than [`Bvh4::MOST_TRIANGLES`] triangles.
    pub fn with_reach(mesh: Mesh, reach: f32) -> Result<Self, MeshTooLarge> {
        let bounds = mesh.bounds();
        let bvh = Bvh4::build(&mesh, reach.max(bounds.longest_side()))?;
        Ok(Self { mesh, bounds, bvh })
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The mesh's bounds.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The tree.
    pub fn bvh(&self) -> &Bvh4 {
        &self.bvh
    }

    /// How far, along any axis, a point of the mesh may be from the origin of a ray that is to slip through nothing.
    pub fn reach(&self) -> f32 {
        self.bvh.reach()
    }

    /// Whether a ray that begins at `origin` slips through nothing. One that does not may lose hits that touch a box no
    /// more than by rounding.
    pub fn reaches(&self, origin: [f32; 3]) -> bool {
        self.bounds.reach_from(origin) <= self.reach()
    }
}
