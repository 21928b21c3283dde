//! What keeps a pipeline from losing jobs: skid buffers, or credits and a FIFO at the exit.

mod credit;
mod exit;
mod skid;

pub use credit::{Spacing, credit};
pub use exit::exit;
pub use skid::skid;
