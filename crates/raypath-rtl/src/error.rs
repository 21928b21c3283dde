use crate::budget::Shortage;
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
    #[error(
        "operation {operation}: {value} is in stage {stage}, expected 1 to {last}; stages begin with c.stage(number, what), or \
         c.auto() finds them"
    )]
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
    #[error(
        "operation {operation}: {state} is read in stage {read}, but its next value is made in stage {made}; expected both \
         in one stage, so that a job finds what the job before it left"
    )]
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
    /// An operation that asks for automatic staging and marks stages as well.
    #[error(
        "operation {operation}: it asks for automatic staging and marks stage {stage}, expected one or the other: mark \
         every stage or none"
    )]
    StagesMixed {
        /// The operation.
        operation: &'static str,
        /// The first stage that it marks.
        stage: u32,
    },
    /// An operation whose longest chain of units has more stages than the pipeline, however it is staged.
    #[error(
        "operation {operation}: its longest chain needs {needed} stages, and there are {last}: {}; an adder or a \
         multiplier takes a stage to itself, three comparators share one",
        .chain.join(" -> ")
    )]
    TooLong {
        /// The operation.
        operation: &'static str,
        /// The units of the chain, by the values that they make, first to last.
        chain: Vec<String>,
        /// The stages that it needs.
        needed: u32,
        /// The last stage that operations may use.
        last: u32,
    },
    /// More units in a stage than the budget allows.
    #[error(
        "operation {operation}: it needs more units than the budget allows: {}; widen the budget to that, or have the operation do less",
        .shortages.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
    )]
    TooManyUnits {
        /// The operation.
        operation: &'static str,
        /// Where, and of what kind; of an operation that is staged automatically, the least that was found.
        shortages: Vec<Shortage>,
    },
    /// A value that nothing brings to where it is read.
    #[error(
        "operation {operation}: {value} is read in a stage that nothing brings it to: state is there up to the stage that \
         makes its next value, and an input only where has_input says so"
    )]
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
        "operation {operation}: its name {}",
        if *.is_taken { "is another operation's as well" } else { "is no identifier, expected letters, digits and _, in snake_case" }
    )]
    Name {
        /// The name.
        operation: &'static str,
        /// Whether it is another's.
        is_taken: bool,
    },
    /// A port that another operation has otherwise, or the operation itself.
    #[error(
        "operation {operation}: its port {port} is {ours}, and that of {other} {theirs}; ports of one name are one port, \
         expected the same type or another name"
    )]
    Port {
        /// The operation.
        operation: &'static str,
        /// The port.
        port: String,
        /// How wide it is, in words.
        ours: String,
        /// The operation that has it already; the same where it has it twice.
        other: &'static str,
        /// How wide that is.
        theirs: String,
    },
    /// A feature that cannot be had as it is asked for.
    #[error("{feature}: {problem}")]
    Feature {
        /// The feature, as [`Features`](crate::Features) has it.
        feature: &'static str,
        /// What is in its way, and what was expected.
        problem: String,
    },
    /// Two operations whose shared units would feed each other in a circle.
    #[error(
        "stage {stage}: the operations use its units in orders that make a loop; expected chains of units in the same order \
         everywhere, or in other stages"
    )]
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
