//! Scenes: a [`Mesh`] or instances of one with a tree of boxes ([`Bvh4`]), and the blocks in which the traversal unit
//! reads it ([`Blocks`]).

pub mod blocks;
pub mod bvh;
mod cwbvh;
mod group;
pub mod mesh;
pub mod placement;
mod refit;
mod scene;
pub mod vector;

pub use blocks::{Blocks, BlocksError};
pub use bvh::Bvh4;
pub use cwbvh::CwbvhError;
pub use group::{Group, Member, MemberPlace, group};
pub use mesh::{Bounds, Geometry, Mesh, MeshError, TrianglePlace};
pub use placement::{Placement, PlacementError};
pub use refit::{RefitError, refit};
pub use scene::{Scene, SceneError};
