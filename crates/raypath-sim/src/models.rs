//! From a configuration, which is known when the program runs, to code that is generic over the model.

use raypath_float::Format;
use raypath_model::{Functional, Model, ModelCircuit, Soft};
use raypath_ops::{Binary32, JobKind};
use raypath_rtl::{Config, Lanes};

/// A model of the operations of the paper, whose jobs are plain values.
pub trait PaperModel: Model<Kind = JobKind, Job: Copy, Outcome: Copy> + 'static {}

impl<M: Model<Kind = JobKind, Job: Copy, Outcome: Copy> + 'static> PaperModel for M {}

/// Work that is the same for every model.
pub trait Visitor {
    /// What comes of it.
    type Answer;

    /// Does it. The model is that of a configuration, its accumulators at zero.
    fn visit<M: PaperModel>(self, model: M) -> Self::Answer;
}

/// Does work with the model of a configuration: its rules, its lanes, its numbers. Without distance modes the model
/// answers distance jobs all the same; who makes jobs keeps to [`Config::kinds`].
pub fn with_model<V: Visitor>(config: Config, visitor: V) -> V::Answer {
    if config.semantics.format == Format::BINARY32 {
        with_lanes(Binary32, config, visitor)
    } else {
        with_lanes(Soft { format: config.semantics.format }, config, visitor)
    }
}

fn with_lanes<C: ModelCircuit + 'static, V: Visitor>(circuit: C, config: Config, visitor: V) -> V::Answer {
    let rules = config.semantics.rules;
    match config.semantics.lanes {
        Lanes::Two => visitor.visit(Functional::<2, 1, C>::over(circuit, rules)),
        Lanes::Four => visitor.visit(Functional::<4, 2, C>::over(circuit, rules)),
        Lanes::Eight => visitor.visit(Functional::<8, 4, C>::over(circuit, rules)),
        Lanes::None | Lanes::Sixteen => visitor.visit(Functional::<16, 8, C>::over(circuit, rules)),
        Lanes::ThirtyTwo => visitor.visit(Functional::<32, 16, C>::over(circuit, rules)),
        Lanes::SixtyFour => visitor.visit(Functional::<64, 32, C>::over(circuit, rules)),
    }
}
