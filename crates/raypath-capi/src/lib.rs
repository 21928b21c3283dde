//! The C interface of raypath: `include/raypath.h` is generated from this crate, and `include/raypath.hpp` adds types
//! for C++. `docs/integration/c.md` shows how to install and use both.
//!
//! Every function that can fail returns a [`Status`]; [`raypath_last_error`] has the message. Pointers are checked for
//! null, alignment and overlap as far as they can be; what a caller must guarantee besides is that they point to as
//! many elements as the call says. No panic leaves a function.

mod arrays;
mod datapath;
mod inspect;
mod memory;
mod pipeline;
mod query;
mod scene;
mod search;
mod status;
mod unit;
mod unit_model;

pub use arrays::*;
pub use datapath::*;
pub use inspect::*;
pub use pipeline::*;
pub use query::*;
pub use raypath_embed::{
    Bounds, QuadboxResult, Ray, SceneGeometry, SceneInstance, TriangleResult, UnitCandidate, UnitHit, UnitRay,
    UnitVerdict, Vertices,
};
pub use scene::*;
pub use search::*;
pub use status::*;
pub use unit::*;
pub use unit_model::*;
