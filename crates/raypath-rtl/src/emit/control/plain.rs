//! A register that never stalls.

use super::buffer::buffer;
use raypath_hdl::{Builder, Module, Register, Wire};
use std::sync::Arc;

/// The valid bit of registers that take a word in every cycle.
#[derive(Clone, Copy)]
pub struct Plain<'m> {
    pub valid: Register<'m>,
}

impl<'m> Plain<'m> {
    /// The control's register.
    pub fn new(m: &'m Builder, valid: Wire<'m>) -> Self {
        let register = m.register("valid_q", 1).reset_to(0);
        register.next(valid);
        Self { valid: register }
    }

    /// Control and data registers as a module, `raypath_register`, with the width as a parameter.
    pub fn buffer() -> Result<Arc<Module>, raypath_hdl::Error> {
        let doc = ["A register of Width bits and its valid bit. It never stalls."];
        buffer("raypath_register", &doc, |m, data| {
            let register = Plain::new(m, m.input("valid_i", 1));
            m.output("valid_o", register.valid.wire());
            register.store(m, "data", data).wire()
        })
    }

    /// The data register of a word.
    pub fn store(self, m: &'m Builder, name: &str, word: Wire<'m>) -> Register<'m> {
        let register = m.register(&format!("{name}_q"), word.width());
        register.next(word);
        register
    }
}
