//! A buffer with the width as a parameter.

use raypath_hdl::text::PAYLOAD;
use raypath_hdl::{Builder, Module, Wire};
use std::sync::Arc;

/// A buffer's module as the text has it: `build` adds the registers for its input `data_i` and gives `data_o`.
pub(super) fn buffer(
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
