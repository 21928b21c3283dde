//! Positions in the pipeline: stages before the schedule is divided into steps, and steps after it.

use std::fmt;

/// The number of stages between the input's registers and the output's (Table VII).
pub const STAGES: u32 = 11;

/// The last stage that operations may use; the stage after it decodes.
pub const LAST_STAGE: u32 = STAGES - 1;

/// The number of stages in the shorter pipeline of sums that round once: the last one also decodes.
pub const SHORT_STAGES: u32 = 9;

/// A stage of Table VII, from 1; 0 is the input's registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Stage(pub u32);

/// A step, which is the logic between two registers: a stage or a part of one. Steps count from 1; 0 is the input's
/// registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Step(pub u32);

/// A stage or a step.
pub trait Position: Copy + Ord + fmt::Debug {
    /// The input's registers.
    const INPUT: Self;
    /// The position of this number.
    fn at(number: u32) -> Self;
}

impl Position for Stage {
    const INPUT: Self = Self(0);
    fn at(number: u32) -> Self {
        Self(number)
    }
}

impl Position for Step {
    const INPUT: Self = Self(0);
    fn at(number: u32) -> Self {
        Self(number)
    }
}

/// The name of a step: its stage, and its number among the steps of the stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct StepLabel {
    /// The stage of Table VII; 0 for the input's registers.
    pub stage: u32,
    /// The number of the step in its stage, from 1.
    pub part: u32,
    /// The number of steps of the stage.
    pub parts: u32,
}

/// `2`, or `2.1` if the stage has several steps; `input` for the input's registers.
impl fmt::Display for StepLabel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self { stage: 0, .. } => f.write_str("input"),
            Self { stage, parts: 1, .. } => write!(f, "{stage}"),
            Self { stage, part, .. } => write!(f, "{stage}.{part}"),
        }
    }
}
