//! Meshes, rays, and an independent oracle of hits.

pub mod meshes;
pub mod oracle;
pub mod patches;
pub mod rays;
