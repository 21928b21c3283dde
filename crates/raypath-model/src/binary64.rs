use crate::kernels::ModelCircuit;
use raypath_ops::{Layout, Portable, native_circuit};

/// IEEE 754 binary64, computed by the machine: the reference for the accuracy of other formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Binary64;

/// A binary64 number. Two are equal if their bits are; all NaNs are equal.
#[derive(Debug, Clone, Copy, Default)]
pub struct Double(pub f64);

native_circuit!(Binary64, Double(f64), u64, Layout::BINARY64, 0x7ff8_0000_0000_0000);

impl ModelCircuit for Binary64 {
    type Kernels = Portable;
    const KERNELS: Portable = Portable;
}
