//! Frames: how a job or an outcome is divided into the words of a stream.
//!
//! A frame is the opcode and then every port in the order of declaration. A port takes whole words, its least
//! significant word first. Bits of a word above the port are zero in outcomes, and ignored in jobs. A word of 32 bits
//! is four bytes, the least significant first.

use raypath_hdl::{Module, Port};
use std::fmt;

/// The width of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StreamWidth {
    /// A byte.
    Eight,
    /// A word of four bytes.
    ThirtyTwo,
}

/// A port of the datapath in a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    /// The port's name in the datapath.
    pub port: String,
    /// Its name without `_i` or `_o`.
    pub name: String,
    /// Its width in bits.
    pub bits: u32,
}

/// The ports of a job, or of an outcome, in the order of a stream.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frame {
    /// The ports; the first is the opcode.
    pub fields: Vec<Field>,
    /// The width of the stream.
    pub width: StreamWidth,
}

impl StreamWidth {
    /// Its bits.
    pub fn bits(self) -> u32 {
        [8, 32][self as usize]
    }
}

impl fmt::Display for StreamWidth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.bits().fmt(f)
    }
}

impl Frame {
    /// The frame of these ports of a module, without those of the handshake.
    pub(crate) fn new(module: &Module, ports: &[Port], handshake: [&str; 2], width: StreamWidth) -> Self {
        let field = |port: &Port| Field {
            port: port.name.clone(),
            name: port.stem().to_string(),
            bits: module.signal(port.signal).width,
        };
        let data = ports.iter().filter(|port| !handshake.contains(&port.name.as_str()));
        let mut fields: Vec<Field> = data.map(field).collect();
        fields.sort_by_key(|field| field.name != "opcode");
        Self { fields, width }
    }

    /// The number of words of the stream that a field takes.
    pub fn words_of(&self, field: &Field) -> u32 {
        field.bits.div_ceil(self.width.bits())
    }

    /// The number of words of the stream in a frame.
    pub fn words(&self) -> u32 {
        self.fields.iter().map(|field| self.words_of(field)).sum()
    }

    /// The number of bytes in a frame.
    pub fn bytes(&self) -> usize {
        (self.words() * self.width.bits() / 8) as usize
    }

    /// The bytes of a frame with these values of the fields.
    pub fn encode(&self, values: &[u64]) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.bytes());
        for (field, value) in self.fields.iter().zip(values) {
            let count = self.words_of(field) * self.width.bits() / 8;
            bytes.extend(&value.to_le_bytes()[..count as usize]);
        }
        bytes
    }

    /// The values of the fields in the bytes of a frame.
    pub fn decode(&self, bytes: &[u8]) -> Vec<u64> {
        let mut rest = bytes;
        let value = |field: &Field| {
            let count = (self.words_of(field) * self.width.bits() / 8) as usize;
            let (own, after) = rest.split_at(count.min(rest.len()));
            rest = after;
            own.iter().rev().fold(0, |value, &byte| value << 8 | u64::from(byte))
        };
        self.fields.iter().map(value).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ports_take_whole_words_least_significant_first() {
        let field = |name: &str, bits| Field { port: format!("{name}_i"), name: name.to_string(), bits };
        let fields = vec![field("opcode", 2), field("number", 33), field("flag", 1)];
        let values = [3, 0x1_2345_6789, 1];
        let narrow = Frame { fields: fields.clone(), width: StreamWidth::Eight };
        assert_eq!((narrow.words(), narrow.bytes()), (7, 7));
        assert_eq!(narrow.encode(&values), [3, 0x89, 0x67, 0x45, 0x23, 1, 1]);
        let wide = Frame { fields, width: StreamWidth::ThirtyTwo };
        assert_eq!((wide.words(), wide.bytes()), (4, 16));
        let bytes = wide.encode(&values);
        assert_eq!(bytes, [3, 0, 0, 0, 0x89, 0x67, 0x45, 0x23, 1, 0, 0, 0, 1, 0, 0, 0]);
        for frame in [&narrow, &wide] {
            assert_eq!(frame.decode(&frame.encode(&values)), values);
        }
    }
}
