use crate::environment::Environment;
use raypath_model::{CycleModel, Model, Shape};

/// A simulated system: the pipeline of a datapath and its environment.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct System {
    /// The environment: agents in flight, memory latency and sink.
    pub environment: Environment,
    /// The shape of the pipeline.
    pub shape: Shape,
}

impl System {
    /// An empty pipeline of this shape, with `model` for the outcomes.
    pub fn pipeline<M: Model>(&self, model: M) -> CycleModel<M> {
        CycleModel::new(model, &self.shape)
    }
}
