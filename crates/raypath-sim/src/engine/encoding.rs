use raypath_float::Format;
use raypath_ops::PortKind;
use raypath_rtl::{Config, Encoding};

/// How numbers stand at a datapath's ports, while jobs and outcomes have them in IEEE 754's layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PortEncoding {
    format: Format,
    io: Encoding,
}

impl PortEncoding {
    /// That of a configuration.
    pub fn of(config: Config) -> Self {
        Self { format: config.semantics.format, io: config.microarchitecture.io }
    }

    /// The bits that stand at the port for a value. For a number of an outcome there are no others.
    #[inline]
    pub fn to_port(self, kind: PortKind, bits: u64) -> u64 {
        match (kind, self.io) {
            (PortKind::Number, Encoding::Recoded) => self.format.encode(bits),
            (PortKind::Number, Encoding::Ieee) | (PortKind::Flags | PortKind::Word, _) => bits,
        }
    }

    /// The value for which these bits stand at a port.
    #[inline]
    pub fn from_port(self, kind: PortKind, bits: u64) -> u64 {
        match (kind, self.io) {
            (PortKind::Number, Encoding::Recoded) => self.format.decode(bits),
            (PortKind::Number, Encoding::Ieee) | (PortKind::Flags | PortKind::Word, _) => bits,
        }
    }
}
