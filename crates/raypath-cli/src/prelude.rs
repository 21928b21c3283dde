//! The items that the description of an operation needs: `use raypath_cli::prelude::*`.

pub use rand::RngExt;
pub use rand::rngs::ChaCha8Rng;
pub use raypath_model::Model;
pub use raypath_ops::{
    Aabb, Binary32, Bit, Circuit, Flags, Num, Operation, Ray, Select, Slab, Triangle, Vec3, Word, bundle,
};
pub use raypath_oracle::OperationSpec;
pub use raypath_rtl::Budget;
pub use raypath_sim::Datapath;
