use crate::ir::graph::MAX_OPERATIONS;
use crate::ir::units::UnitKind;
use std::fmt;
use thiserror::Error;

/// The reason why operations cannot be elaborated.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Error {
    /// A value is read before the stage that computes it.
    #[error("operation {operation}: {reader} in stage {stage} reads {value}, which stage {made} computes")]
    UsedBeforeMade {
        /// The operation.
        operation: &'static str,
        /// The value that reads it.
        reader: String,
        /// The stage that reads it.
        stage: u32,
        /// The value that is read.
        value: String,
        /// The stage that computes it.
        made: u32,
    },
    /// A stage out of range.
    #[error(
        "operation {operation}: {value} is in stage {stage}, expected 1 to {last}; stages begin with \
         c.stage(number, what), or c.auto() finds them"
    )]
    NoSuchStage {
        /// The operation.
        operation: &'static str,
        /// The value in that stage.
        value: String,
        /// The stage.
        stage: u32,
        /// The last stage that operations may use.
        last: u32,
    },
    /// State that is not read in the stage that computes its next value.
    #[error(
        "operation {operation}: stage {read} reads {state}, but stage {made} computes its next value; expected both in \
         one stage, so that a job reads the value that the job before it wrote"
    )]
    StateApart {
        /// The operation.
        operation: &'static str,
        /// The state.
        state: String,
        /// The stage that reads it.
        read: u32,
        /// The stage that computes its next value.
        made: u32,
    },
    /// An operation with automatic staging that marks stages as well.
    #[error(
        "operation {operation}: it selects automatic staging and also marks stage {stage}; expected either all stages \
         marked or none"
    )]
    StagesMixed {
        /// The operation.
        operation: &'static str,
        /// The first stage that it marks.
        stage: u32,
    },
    /// An operation whose longest chain of units needs more stages than the pipeline has.
    #[error(
        "operation {operation}: its longest chain needs {needed} stages, and there are {last}: {}; an adder or a \
         multiplier takes a stage to itself, three comparators share one",
        .chain.join(" -> ")
    )]
    TooLong {
        /// The operation.
        operation: &'static str,
        /// The values that the units of the chain compute, first to last.
        chain: Vec<String>,
        /// The stages that it needs.
        needed: u32,
        /// The last stage that operations may use.
        last: u32,
    },
    /// More units in a stage than the budget allows.
    #[error(
        "operation {operation}: it needs more units than the budget allows: {}; widen the budget or reduce \
         the work of the operation",
        .shortages.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
    )]
    TooManyUnits {
        /// The operation.
        operation: &'static str,
        /// The stages and kinds of units; with automatic staging, those of the best schedule found.
        shortages: Vec<Shortage>,
    },
    /// A value that is not available at the step that reads it.
    #[error(
        "operation {operation}: {value} is not available in a stage that reads it: state is available up to the stage \
         that computes its next value, and an input only if has_input declares it"
    )]
    Unplaced {
        /// The operation.
        operation: &'static str,
        /// The value.
        value: String,
    },
    /// An input, an output or a state that is a bare number, bit or word.
    #[error(
        "operation {operation}: its {part} is a bare value, expected a structure that `bundle!` declares, because the \
         names of its fields are those of ports and registers"
    )]
    Unnamed {
        /// The operation.
        operation: &'static str,
        /// "input", "output" or "state".
        part: &'static str,
    },
    /// An opcode that is in use or too large.
    #[error(
        "operation {operation}: opcode {opcode} {}",
        .taken.map_or(format!("is too large, expected 0 to {}", MAX_OPERATIONS - 1), |by| format!("is taken by {by}"))
    )]
    Opcode {
        /// The operation.
        operation: &'static str,
        /// The opcode.
        opcode: u64,
        /// The operation that uses it.
        taken: Option<&'static str>,
    },
    /// A name that another operation has, or that is not in snake_case.
    #[error(
        "operation {operation}: its name {}",
        if *.is_taken {
            "is taken by another operation"
        } else {
            "is not in snake_case, expected small letters, digits and _, the first a letter"
        }
    )]
    Name {
        /// The name.
        operation: &'static str,
        /// Whether another operation has it.
        is_taken: bool,
    },
    /// A port that another operation has with another type, or that the operation has twice.
    #[error(
        "operation {operation}: its port {port} is {ours}, and that of {other} {theirs}; ports of one name are one \
         port, expected the same type or another name"
    )]
    Port {
        /// The operation.
        operation: &'static str,
        /// The port.
        port: String,
        /// Its width in words.
        ours: String,
        /// The operation that has it already, which may be the same operation.
        other: &'static str,
        /// The width there.
        theirs: String,
    },
    /// A feature with an invalid value, or that cannot be combined with the others.
    #[error("{feature}: {problem}")]
    Feature {
        /// The name of the feature.
        feature: &'static str,
        /// The problem, and what was expected.
        problem: String,
    },
    /// Two operations whose shared units would make a combinational loop.
    #[error(
        "stage {stage}: the operations use its units in orders that form a combinational loop; expected chains of \
         units in the same order in all operations, or in other stages"
    )]
    UnitLoop {
        /// The stage.
        stage: u32,
    },
    /// A part of a unit without the part before it: a defect of the elaborator.
    #[error("step {step}: {unit} has no part before it")]
    PartApart {
        /// The unit's part.
        unit: String,
        /// The step.
        step: String,
    },
    /// An error of the netlist.
    #[error(transparent)]
    Netlist(#[from] raypath_hdl::Error),
}

/// A stage whose budget is less than what an operation needs there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shortage {
    /// The stage.
    pub stage: u32,
    /// The kind of unit.
    pub kind: UnitKind,
    /// The number that the operation needs.
    pub needed: usize,
    /// The number that the budget allows.
    pub allowed: usize,
}

/// `stage 2 needs 24 adders, 20 allowed`.
impl fmt::Display for Shortage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { stage, kind, needed, allowed } = self;
        let plural = if *needed == 1 { "" } else { "s" };
        write!(f, "stage {stage} needs {needed} {kind}{plural}, {allowed} allowed")
    }
}
