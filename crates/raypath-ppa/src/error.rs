use raypath_tools::ToolError;
use std::path::PathBuf;
use thiserror::Error;

/// Why a design cannot be measured.
#[derive(Debug, Error)]
pub enum Error {
    /// An external program is missing, fails or was stopped, or a file cannot be read or written.
    #[error(transparent)]
    Tool(#[from] ToolError),
    /// A cell library is not a Liberty file.
    #[error("{}:{line}: found {found}, expected {expected}", path.display())]
    Liberty {
        /// The library.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The text at that line.
        found: String,
        /// What the format has there.
        expected: &'static str,
    },
    /// A cell library lacks a cell that every measurement needs.
    #[error("{}: no {what} in this library, expected one", path.display())]
    MissingCell {
        /// The library.
        path: PathBuf,
        /// The missing cell, in words.
        what: String,
    },
    /// A module cannot be printed as SystemVerilog.
    #[error(transparent)]
    Netlist(#[from] raypath_hdl::Error),
}
