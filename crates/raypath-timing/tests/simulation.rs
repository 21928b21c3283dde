//! Simulations of agents before the cycle-exact model, and sweeps of them.

mod analytic;
pub mod common;
mod reference;
mod sample;
mod sweep;
