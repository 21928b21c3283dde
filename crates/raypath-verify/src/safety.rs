//! Proofs by Yosys and ABC that assertions in SystemVerilog hold in every cycle.

mod model_checker;
mod texts;

pub use model_checker::{CheckResult, Method, ModelChecker, SafetyProblem};
pub use texts::{ModuleTexts, RESET, TextFault};
