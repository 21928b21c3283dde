use raypath_float::Format;
use raypath_ops::PortKind;
use raypath_rtl::{Config, Encoding};

/// The encoding of numbers at the ports of a datapath. Jobs and outcomes have numbers in the IEEE 754 layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PortEncoding {
    format: Format,
    io: Encoding,
}

impl PortEncoding {
    /// The encoding of a configuration.
    pub fn of(config: Config) -> Self {
        Self { format: config.semantics.format, io: config.microarchitecture.io }
    }

    /// The bits at a port for a value. The encoding of each number of an outcome is unique.
    #[inline]
    pub fn to_port(self, kind: PortKind, bits: u64) -> u64 {
        if self.is_recoded(kind) { self.format.encode(bits) } else { bits }
    }

    /// The value of the bits at a port.
    #[inline]
    pub fn from_port(self, kind: PortKind, bits: u64) -> u64 {
        if self.is_recoded(kind) { self.format.decode(bits) } else { bits }
    }

    #[inline]
    fn is_recoded(self, kind: PortKind) -> bool {
        kind == PortKind::Number && self.io == Encoding::Recoded
    }
}
