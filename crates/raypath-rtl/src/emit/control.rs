//! Handshake control: skid buffers, or credits and a FIFO at the exit.
//!
//! The netlist has the control of a buffer in a module of its own and the data registers in each stage. The text holds
//! both in one module, whose width is a parameter. Both are built by the same functions.

mod credit;
mod exit;
mod register;
mod skid;

pub use credit::{Spacing, credit};
pub use exit::Exit;
pub use register::Register;
pub use skid::Skid;

use raypath_hdl::text::PAYLOAD;
use raypath_hdl::{Builder, Module, Wire};
use std::sync::Arc;

/// A buffer's module as the text has it: `build` adds the registers for its input `data_i` and gives `data_o`.
fn buffer(
    name: &str,
    doc: &[&str],
    build: impl for<'m> FnOnce(&'m Builder, Wire<'m>) -> Wire<'m>,
) -> Result<Arc<Module>, raypath_hdl::Error> {
    let m = Builder::new(name);
    doc.iter().for_each(|line| m.doc(*line));
    m.parameterise_width();
    let data = m.input("data_i", PAYLOAD);
    let shown = build(&m, data);
    m.output("data_o", shown);
    m.finish()
}
