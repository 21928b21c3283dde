use thiserror::Error;

/// Why a netlist could not be built, printed or simulated. Every message names the module and the signal.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Error {
    /// Operands of widths that differ, or a width outside 1 to 64.
    #[error("module {module}, signal {signal}: {problem}")]
    Width {
        /// The module that was being built.
        module: String,
        /// The signal's name, or its operator and number where it has none.
        signal: String,
        /// The width found, and the width expected.
        problem: String,
    },
    /// A name that is taken, is not an identifier, or is reserved by SystemVerilog or Verilator; or a port that does
    /// not exist.
    #[error("module {module}: name '{name}' {problem}")]
    Name {
        /// The module.
        module: String,
        /// The name.
        name: String,
        /// The problem.
        problem: String,
    },
    /// A register or forward wire that nothing drives, or that is driven twice; or an operand from another module.
    #[error("module {module}: '{signal}' {problem}")]
    Drive {
        /// The module.
        module: String,
        /// The signal.
        signal: String,
        /// "is never driven", "is driven twice" or "belongs to another module".
        problem: String,
    },
    /// Signals that depend on themselves within one cycle.
    #[error("combinational loop through {}", .0.join(" -> "))]
    Loop(Vec<String>),
    /// The code generator returned an error: a defect of this crate.
    #[error("code generation: {0}")]
    Codegen(String),
}
