//! A traversal unit around the datapath: a ray goes in, the closest or any hit comes out.
//!
//! Three functions, generic over their circuit, say what happens to a ray: [`set_up`] derives its constants, [`fold()`]
//! finds the closest hit of a block, and [`step()`] decides what follows from an answer. [`Unit`] is the functional
//! model, which steps a ray until it ends. [`UnitNetlist`] is the hardware. [`blocks`] is the layout of a scene in
//! memory, and [`traffic`] has random scenes, rays and memories. [`search`] has searches, as functional models.

mod answers;
pub mod blocks;
mod candidate;
mod codes;
mod cycle;
mod descent;
mod engine;
mod error;
mod fold;
mod hardware;
mod instance;
mod model;
mod native;
mod netlist;
mod query;
pub mod search;
pub mod set_up;
pub mod state;
mod step;
pub mod system;
pub mod traffic;
mod walk;
mod words;

pub use candidate::{Candidate, Verdict};
pub use cycle::{RayInside, RayPhase, UnitCounts, UnitModel};
pub use engine::{
    AskedCandidate, BlockRequest, NetlistEngine, Response, SearchInputs, SearchOutputs, SearchResult, UnitEngine,
    UnitInputs, UnitOutputs, UnitPorts,
};
pub use error::UnitError;
pub use fold::{After, HitLimits, fold};
pub use hardware::{
    SearchPorts, UnitNetlist, UnitParameter, UnitParameters, UnitParametersError, fixed_parameters, search_engine,
};
pub use instance::{INSTANCE_KIND, Instance, Row, Transform, TransformInput, TransformOutput};
pub use model::{Hit, HitInstance, Memory, MemoryError, Query, RayRequest, Reply, Unit};
pub use netlist::{Netlist, Value};
pub use query::{
    Culls, Front, InstanceFlags, InstanceWords, ParseNameError, Queries, RayFlags, instance_flags, ray_flags,
};
pub use step::{HalfStep, NODE_LIMIT, StepParameters, UnitFeatures, finish, prepare, step};
pub use words::{LEVELS, Levels, WordCircuit, WordMethods};
