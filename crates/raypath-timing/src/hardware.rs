use crate::machine::Machine;
use raypath_model::{CycleModel, Model, Shape};

/// The datapath and what surrounds it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Hardware {
    /// How many agents are in flight, how long memory takes, and who takes the answers.
    pub machine: Machine,
    /// The pipeline.
    pub shape: Shape,
}

impl Hardware {
    /// An empty pipeline of its shape, which answers as `model` does.
    pub fn model<M: Model>(&self, model: M) -> CycleModel<M> {
        CycleModel::new(model, &self.shape)
    }
}
