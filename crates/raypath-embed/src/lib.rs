//! A datapath for programs in other languages: jobs and outcomes in the layout of C, arrays of jobs, a cycle-exact
//! pipeline whose jobs carry tags, and the files of the hardware. The same for the traversal unit around the datapath:
//! arrays of rays, and a cycle-exact model with the ports of the unit.
//!
//! `raypath-capi` exports it to C and C++, and `raypath-python` to Python. It is safe Rust.

mod card;
mod datapath;
mod error;
mod general;
mod job;
mod layout;
mod native;
mod paper;
mod pipeline;
mod ring;
mod state;
mod transpose;
mod unit;

pub use card::Card;
pub use datapath::Datapath;
pub use error::Error;
pub use job::{Beat, Job, Outcome, Tagged};
pub use layout::{AngularResult, Bounds, EuclideanResult, QuadboxResult, Ray, TriangleResult, Vertices};
pub use pipeline::Pipeline;
pub use raypath_model::Words;
pub use raypath_ops::RayError;
pub use raypath_sim::OperationId;
pub use raypath_traversal::search::{Neighbour, SearchCounts, SearchReply, SearchStatus};
pub use raypath_traversal::{
    BlockRequest, Front, Queries, RayInside, RayPhase, Response, SearchInputs, SearchOutputs, SearchResult, UnitCounts,
};
pub use unit::{
    SceneGeometry, SceneInput, SceneInstance, Unit, UnitCandidate, UnitHit, UnitInputs, UnitModel, UnitOutputs,
    UnitQuery, UnitRay, UnitScene, UnitStalls, UnitVerdict,
};
