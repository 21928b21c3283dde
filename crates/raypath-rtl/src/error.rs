use crate::datapath::MOST_OPERATIONS;
use thiserror::Error;

/// Why operations do not make a datapath.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Error {
    /// A value is read in a stage before the one that makes it.
    #[error("operation {operation}: {reader} in stage {stage} reads {value}, which stage {made} makes")]
    UsedBeforeMade {
        /// The operation.
        operation: &'static str,
        /// What reads it.
        reader: String,
        /// Where it is read.
        stage: u32,
        /// What is read.
        value: String,
        /// Where it is made.
        made: u32,
    },
    /// A stage that the pipeline does not have.
    #[error("operation {operation}: {value} is in stage {stage}, expected 1 to {last}")]
    NoSuchStage {
        /// The operation.
        operation: &'static str,
        /// What is there.
        value: String,
        /// The stage.
        stage: u32,
        /// The last stage that operations may use.
        last: u32,
    },
    /// State that is read elsewhere than where its next value is made.
    #[error("operation {operation}: {state} is read in stage {read}, but its next value is made in stage {made}")]
    StateApart {
        /// The operation.
        operation: &'static str,
        /// The state.
        state: String,
        /// Where it is read.
        read: u32,
        /// Where its next value is made.
        made: u32,
    },
    /// A value that no register brings to where it is read; a defect of ours.
    #[error("operation {operation}: {value} is read in a stage that no register brings it to")]
    Unplaced {
        /// The operation.
        operation: &'static str,
        /// The value.
        value: String,
    },
    /// An opcode that is taken or too large.
    #[error("operation {operation}: opcode {opcode} {}", .taken.map_or(format!("is too large, expected 0 to {}", MOST_OPERATIONS - 1), |by| format!("is that of {by}")))]
    Opcode {
        /// The operation.
        operation: &'static str,
        /// The opcode asked for.
        opcode: u64,
        /// The operation that has it.
        taken: Option<&'static str>,
    },
    /// A name that another operation has, or that is no identifier.
    #[error(
        "operation {operation}: its name is another's as well, or no identifier; expected letters, digits and _, in snake_case"
    )]
    Name {
        /// The name.
        operation: &'static str,
    },
    /// Two operations whose shared units would feed each other in a circle.
    #[error("stage {stage}: the operations use its units in orders that make a loop")]
    UnitLoop {
        /// The stage.
        stage: u32,
    },
    /// A part of a unit that the part before has handed nothing; a defect of ours.
    #[error("step {step}: {unit} has no part before it")]
    PartApart {
        /// The unit's part.
        unit: String,
        /// The step.
        step: String,
    },
    /// The netlist did not build.
    #[error(transparent)]
    Netlist(#[from] raypath_hdl::Error),
}
