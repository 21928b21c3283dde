//! Allocation: the unit and the register of every value.

mod affinity;
mod alike;
mod binding;
pub mod delays;
mod lanes;
pub mod layout;
pub mod plan;
mod registers;
mod terms;
