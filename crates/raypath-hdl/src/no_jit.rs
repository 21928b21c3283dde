//! In place of `jit`, without Cranelift: nothing compiles.

use crate::Error;
use crate::flatten::Flat;

/// Never made.
pub enum Code {}

impl Code {
    pub fn new(_: &Flat, _: usize) -> Result<Self, Error> {
        Err(Error::Codegen("raypath-hdl was built without its feature `simulator`".to_string()))
    }

    pub fn memory(&self) -> usize {
        match *self {}
    }

    pub fn run(&self, _: &[u64], _: &mut [u64], _: &mut [u64], _: &mut [u64]) {
        match *self {}
    }
}
