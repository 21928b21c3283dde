//! What an operation of one's own is written with: `use raypath_lab::prelude::*`.

pub use crate::{Datapath, Study};
pub use rand::RngExt;
pub use rand_chacha::ChaCha8Rng;
pub use raypath_model::Model;
pub use raypath_ops::{
    Aabb, Binary32, Bit, Circuit, Flags, Num, Operation, Ray, Select, Slab, Triangle, Vec3, Word, bundle,
};
