//! Meshes, rays, and an independent judge of what rays hit.

#![allow(dead_code, reason = "each test uses a part")]

pub mod exact;
pub mod judge;
pub mod meshes;
pub mod patches;
pub mod rays;
