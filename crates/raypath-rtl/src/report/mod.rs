//! An elaborated datapath in tables and pictures.

pub mod drawing;
pub mod picture;
pub mod tables;
