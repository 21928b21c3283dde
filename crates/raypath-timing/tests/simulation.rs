//! Simulations of agents before the cycle-exact model, and sweeps of them.

mod analytic;
mod common;
mod reference;
mod sample;
mod sweep;
