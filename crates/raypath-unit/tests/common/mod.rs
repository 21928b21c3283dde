//! Rays, scenes and a memory for tests of the unit.
#![allow(unused_imports, reason = "each test binary uses a part")]

pub use raypath_unit::traffic::{Behaviour, BlockScene as Scene, Environment, never, random_ray as ray};
