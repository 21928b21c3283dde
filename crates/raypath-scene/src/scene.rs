//! A scene: a mesh with its bounding volume hierarchy.

use crate::blocks::{Blocks, BlocksError};
use crate::bvh::{Bvh, Bvh4, MeshTooLarge};
use crate::group::Margins;
use crate::mesh::{Bounds, Mesh};
use crate::placement::Placement;
use raypath_traversal::blocks::NodeKind;
use thiserror::Error;

/// A mesh, or instances of one, with its bounding volume hierarchy.
#[derive(Debug, Clone)]
pub struct Scene {
    mesh: Mesh,
    bounds: Bounds,
    bvh: Bvh4,
    blocks: Option<Blocks>,
    /// The instances, with how much larger the boxes of each are than it.
    placed: Vec<(Placement, f64)>,
    reach: f32,
}

/// The reason why a scene with instances cannot be built.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SceneError {
    /// Too many triangles.
    #[error(transparent)]
    Mesh(#[from] MeshTooLarge),
    /// Too many blocks.
    #[error(transparent)]
    Blocks(#[from] BlocksError),
    /// No instance.
    #[error("0 instances, expected at least 1")]
    Empty,
    /// A scene that others are made of was built for a smaller reach than they have.
    #[error("scene {member} was built for a reach of {built}, expected at least {needed} at its places")]
    Reach {
        /// Its number.
        member: usize,
        /// The reach for which it was built.
        built: f32,
        /// The reach that its places need.
        needed: f32,
    },
    /// A scene that others are made of is none.
    #[error("scene {number}: {problem}")]
    Member {
        /// Its number.
        number: usize,
        /// The problem.
        problem: String,
    },
    /// An instance that is too far away or too large.
    #[error("instance {0} has a coordinate beyond 2^40 in the scene or in its mesh, expected a smaller one")]
    Far(usize),
}

/// The error of a reach that is negative or not finite.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("reach: found {0}, expected a finite number of at least 0")]
pub struct ReachError(f32);

impl Scene {
    /// A scene of one level.
    ///
    /// # Errors
    /// More than [`Bvh4::MAX_TRIANGLES`] triangles.
    pub fn new(mesh: Mesh) -> Result<Self, MeshTooLarge> {
        let (bounds, bvh) = (mesh.bounds(), Bvh4::build(&mesh)?);
        Ok(Self { mesh, bounds, bvh, blocks: None, placed: Vec::new(), reach: f32::INFINITY })
    }

    /// A reach that a user gives.
    ///
    /// # Errors
    /// It is negative or not finite.
    pub fn check_reach(reach: Option<f32>) -> Result<(), ReachError> {
        match reach.filter(|reach| !(*reach >= 0.0 && reach.is_finite())) {
            Some(reach) => Err(ReachError(reach)),
            None => Ok(()),
        }
    }

    /// A scene of instances of a mesh, for ray origins at `origins` or within 16 times the longest side of the scene.
    /// Rays are traced through the functional model of the unit.
    ///
    /// # Errors
    /// Those of [`of_instances_with_reach`](Self::of_instances_with_reach).
    pub fn of_instances(
        mesh: Mesh,
        placements: &[Placement],
        origins: impl IntoIterator<Item = [f32; 3]>,
    ) -> Result<Self, SceneError> {
        let places = everywhere(&mesh, placements);
        let Margins { bounds, reach, .. } = Margins::of(&places, None)?;
        let reach = origins.into_iter().map(|origin| bounds.reach_from(origin)).fold(reach, f32::max);
        Self::of_instances_with_reach(mesh, placements, reach)
    }

    /// A scene of instances of a mesh, for ray origins from which every point of it is within `reach` along each axis.
    /// A smaller reach than the longest side is raised to it. The boxes of instances are padded in proportion to it,
    /// because transforms round ([`Placement::pad`]).
    ///
    /// # Errors
    /// No instance; a scene that is too large; an instance that is too far away.
    pub fn of_instances_with_reach(mesh: Mesh, placements: &[Placement], reach: f32) -> Result<Self, SceneError> {
        let Margins { bounds, reach, pads } = Margins::of(&everywhere(&mesh, placements), Some(reach))?;
        let bvh = Bvh4::build(&mesh)?;
        let placed = placements.iter().copied().zip(pads).collect();
        let scene = Self { mesh, bounds, bvh, blocks: None, placed, reach };
        Ok(scene.through_unit()?)
    }

    /// The scene with its blocks in memory, so that rays are traced through the functional model
    /// of the traversal unit with wide nodes.
    ///
    /// # Errors
    /// They take more than 4 GiB, the tree has more than 64 levels, or a box has no quantised bounds.
    pub fn through_unit(self) -> Result<Self, BlocksError> {
        self.through_unit_of(NodeKind::Wide4)
    }

    /// The same with these nodes.
    ///
    /// # Errors
    /// They take more than 4 GiB, the tree has more than 64 levels, or a box has no quantised bounds.
    pub fn through_unit_of(mut self, nodes: NodeKind) -> Result<Self, BlocksError> {
        if self.blocks.as_ref().is_some_and(|blocks| blocks.nodes() == nodes) {
            return Ok(self);
        }
        let own = self.mesh.bounds();
        let placed: Vec<_> =
            self.placed.iter().map(|(placement, pad)| (*placement, placement.bounds(own), *pad)).collect();
        let object = match nodes {
            NodeKind::Wide4 | NodeKind::Quantised => Blocks::of(&self.bvh, nodes)?,
            NodeKind::Wide8 => Blocks::of(&Bvh::<8>::within(&self.mesh, Bvh::<8>::MAX_LEVELS), nodes)?,
        };
        self.blocks = Some(if placed.is_empty() { object } else { object.with_instances(&placed)? });
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

    /// The number of instances; 0 if the scene is the mesh itself.
    pub fn instances(&self) -> usize {
        self.placed.len()
    }

    /// An instance, and how much larger its box is than it.
    pub fn placed(&self, instance: u32) -> Option<&(Placement, f64)> {
        self.placed.get(instance as usize)
    }

    /// The bounds of the mesh, or of its instances.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The bounding volume hierarchy.
    pub fn bvh(&self) -> &Bvh4 {
        &self.bvh
    }

    /// The distance, along any axis, between a ray origin and a point of the scene up to which tracing is watertight:
    /// infinite without instances.
    pub fn reach(&self) -> f32 {
        self.reach
    }

    /// Whether tracing is watertight for rays from `origin`. Other rays may lose hits at the edge of an instance.
    pub fn reaches(&self, origin: [f32; 3]) -> bool {
        self.bounds.reach_from(origin) <= self.reach()
    }
}

/// The mesh at each place.
fn everywhere(mesh: &Mesh, placements: &[Placement]) -> Vec<(Placement, Bounds)> {
    let own = mesh.bounds();
    placements.iter().map(|placement| (*placement, own)).collect()
}
