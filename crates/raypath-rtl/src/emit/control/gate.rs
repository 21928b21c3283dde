//! The enable of registers behind a clock gate.

use raypath_hdl::{Builder, Register, Wire};

/// When a group of registers loads. The text has a clock gate for all of them.
#[derive(Clone, Copy)]
pub struct Gate<'m>(Wire<'m>);

impl<'m> Gate<'m> {
    /// A gate named after its enable.
    pub fn new(name: &str, enable: Wire<'m>) -> Self {
        Self(enable.named(name))
    }

    /// A register behind the gate.
    pub fn register(self, m: &'m Builder, name: &str, next: Wire<'m>) -> Register<'m> {
        let register = m.register(name, next.width());
        self.load(register, next);
        register
    }

    /// Puts a register behind the gate.
    pub fn load(self, register: Register<'m>, next: Wire<'m>) {
        register.next_gated(self.0, next);
    }
}
