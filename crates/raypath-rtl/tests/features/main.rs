//! Features of the paper's operations, and of all operations.

mod driver;
mod exceptions;
mod options;
