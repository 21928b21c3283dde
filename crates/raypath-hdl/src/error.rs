use thiserror::Error;

/// Why a netlist could not be built, printed or simulated. Every message names the module and the signal.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Error {
    /// Widths that do not fit together, or a width outside 1 to 64.
    #[error("module {module}, signal {signal}: {problem}")]
    Width {
        /// The module that was being built.
        module: String,
        /// The signal's name, or its operator and number where it has none.
        signal: String,
        /// What was found and what was expected.
        problem: String,
    },
    /// A name that is taken, is no identifier, or means something to SystemVerilog or Verilator; or a port that is not
    /// there.
    #[error("module {module}: name '{name}' {problem}")]
    Name {
        /// The module.
        module: String,
        /// The offending name.
        name: String,
        /// What is wrong with it.
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
    /// The code generator refused; a defect of ours.
    #[error("code generation: {0}")]
    Codegen(String),
}
