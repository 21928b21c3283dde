//! Words that a reset clears, and that are read in the cycle.

use super::queue::{bits, template};
use raypath_hdl::{Builder, Error, Module, Wire};
use std::sync::Arc;

/// The module `name` of `depth` words with these columns. A reset clears all words. The word at `address_i` is shown in
/// the same cycle, `<column>_o`, and where `write_enable_i` is 1 it becomes `<column>_i` at the end of the cycle.
pub fn registers(name: &str, depth: u32, columns: &[(&str, u32)]) -> Result<Arc<Module>, Error> {
    let builder = Builder::new(name);
    let m = &builder;
    let enable = m.input("write_enable_i", 1);
    let address = m.input("address_i", bits(depth));
    for (column, width) in columns {
        let next = m.input(&format!("{column}_i"), *width);
        let word = |number: u32| {
            let register = m.register(&format!("{column}_{number}_q"), *width).reset_to(0);
            register.next_when(enable & address.is(number.into()), next);
            register.wire()
        };
        let words: Vec<Wire<'_>> = (0..depth).map(word).collect();
        m.output(&format!("{column}_o"), address.select(&words));
    }
    let text = include_str!("raypath_registers.sv");
    let doc = "Words that a reset clears. The word at the address is shown in the same cycle.";
    m.template(template("raypath_registers", doc, text, depth, columns, &["write_enable_i", "address_i"], &[]));
    builder.finish()
}
