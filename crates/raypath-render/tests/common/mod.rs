//! Meshes, rays, and an independent oracle of hits.

#![allow(dead_code, reason = "each test uses a part")]

pub mod exact;
pub mod meshes;
pub mod oracle;
pub mod patches;
pub mod rays;
