//! A scene: a mesh with its bounding volume hierarchy.

use crate::blocks::{Blocks, BlocksError};
use crate::bvh::{Bvh4, MeshTooLarge};
use crate::mesh::{Bounds, Mesh};
use raypath_unit::blocks::NodeKind;

/// The default reach in units of the longest side of the mesh.
const DEFAULT_REACH: f32 = 16.0;

/// A mesh with its bounding volume hierarchy, built for ray origins within its [`reach`](Self::reach).
#[derive(Debug, Clone)]
pub struct Scene {
    mesh: Mesh,
    bounds: Bounds,
    bvh: Bvh4,
    blocks: Option<Blocks>,
}

impl Scene {
    /// A scene for ray origins within 16 times the longest side of the mesh.
    ///
    /// # Errors
    /// More than [`Bvh4::MAX_TRIANGLES`] triangles.
    pub fn new(mesh: Mesh) -> Result<Self, MeshTooLarge> {
        let bounds = mesh.bounds();
        Self::with_reach(mesh, DEFAULT_REACH * bounds.longest_side())
    }

    /// A scene for ray origins at `origins` or within 16 times the longest side of the mesh.
    ///
    /// # Errors
    /// More than [`Bvh4::MAX_TRIANGLES`] triangles.
    pub fn for_origins(mesh: Mesh, origins: impl IntoIterator<Item = [f32; 3]>) -> Result<Self, MeshTooLarge> {
        let bounds = mesh.bounds();
        let near = DEFAULT_REACH * bounds.longest_side();
        let reach = origins.into_iter().map(|origin| bounds.reach_from(origin)).fold(near, f32::max);
        Self::with_reach(mesh, reach)
    }

    /// A scene for ray origins from which every point of the mesh is within `reach` along each axis. A smaller reach
    /// than the longest side of the mesh is raised to it. Boxes are padded in proportion to the reach (see [`Bvh4`]),
    /// so a greater reach costs a little time.
    ///
    /// # Errors
    /// More than [`Bvh4::MAX_TRIANGLES`] triangles.
    pub fn with_reach(mesh: Mesh, reach: f32) -> Result<Self, MeshTooLarge> {
        let bounds = mesh.bounds();
        let bvh = Bvh4::build(&mesh, reach.max(bounds.longest_side()))?;
        Ok(Self { mesh, bounds, bvh, blocks: None })
    }

    /// The scene with its blocks in memory, so that [`Tracer`](crate::Tracer) traces rays through the functional model
    /// of the traversal unit with wide nodes.
    ///
    /// # Errors
    /// Those of [`Blocks::of`].
    pub fn through_unit(self) -> Result<Self, BlocksError> {
        self.through_unit_of(NodeKind::Wide4)
    }

    /// The same with these nodes.
    ///
    /// # Errors
    /// Those of [`Blocks::of`].
    pub fn through_unit_of(mut self, nodes: NodeKind) -> Result<Self, BlocksError> {
        self.blocks = Some(Blocks::of(&self.bvh, nodes)?);
        Ok(self)
    }

    /// The scene in memory, if rays are traced through the unit.
    pub fn blocks(&self) -> Option<&Blocks> {
        self.blocks.as_ref()
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The bounds of the mesh.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The bounding volume hierarchy.
    pub fn bvh(&self) -> &Bvh4 {
        &self.bvh
    }

    /// The distance, along any axis, between a ray origin and a point of the mesh up to which tracing is watertight.
    pub fn reach(&self) -> f32 {
        self.bvh.reach()
    }

    /// Whether tracing is watertight for rays from `origin`. Other rays may lose hits at the edge of a box, within the
    /// rounding errors of the box test.
    pub fn reaches(&self, origin: [f32; 3]) -> bool {
        self.bounds.reach_from(origin) <= self.reach()
    }
}
