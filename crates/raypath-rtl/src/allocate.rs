//! Allocation: the unit and the register of every value.

mod affinity;
mod binding;
pub mod layout;
pub mod plan;
mod registers;
