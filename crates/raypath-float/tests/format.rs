//! Formats in software, compared with the host's arithmetic, LLVM's soft float, and a search among all numbers.

mod apfloat;
mod exhaustive;
mod formats;
mod host;
pub mod operands;
