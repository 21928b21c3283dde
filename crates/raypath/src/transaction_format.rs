//! The columns of transaction files (`docs/transactions.md`): one transaction a line, fields separated by spaces,
//! hexadecimal without `0x`. Their order is that of the recorded golden vectors, not that of the ports.

use raypath_ops::JobKind;

/// A column, the port that it stands for, and how it is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// The port without its direction suffix; what it is called in messages.
    pub port: String,
    /// The bit of the port, where a column holds one bit of several.
    pub bit: Option<u32>,
    /// Bits of the value.
    pub width: u32,
}

/// The columns of one kind of file, `seq` and `cat` excluded.
#[derive(Debug, Clone)]
pub struct Columns {
    /// What the job brings.
    pub inputs: Vec<Column>,
    /// What was answered.
    pub outputs: Vec<Column>,
}

/// The columns for a kind of job.
pub fn columns(kind: JobKind) -> Columns {
    let mut inputs = List::default();
    let mut outputs = List::default();
    match kind {
        JobKind::Triangle | JobKind::Quadbox => {
            for vector in ["origin", "dir", "inv"] {
                inputs.vector(&format!("ray_{vector}"));
            }
            inputs.number("ray_extent");
            for axis in ["kx", "ky", "kz"] {
                inputs.word(&format!("ray_{axis}"), 2);
            }
            inputs.vector("ray_shear");
        }
        JobKind::Euclidean => beat(&mut inputs, 16),
        JobKind::Angular => beat(&mut inputs, 8),
    }
    match kind {
        JobKind::Triangle => {
            for vertex in ["a", "b", "c"] {
                inputs.vector(&format!("triangle_{vertex}"));
            }
            outputs.number("t_num");
            outputs.number("t_denom");
            outputs.word("triangle_hit", 1);
        }
        JobKind::Quadbox => {
            for place in 0..4 {
                for bound in ["min", "max"] {
                    for axis in ["x", "y", "z"] {
                        inputs.number(&format!("aabb_{place}_{axis}_{bound}"));
                    }
                }
            }
            (0..4).for_each(|place| outputs.number(&format!("tmin_{place}")));
            (0..4).for_each(|place| outputs.flag("is_intersect", place));
            (0..4).for_each(|place| outputs.word(&format!("box_index_{place}"), 2));
        }
        JobKind::Euclidean => {
            outputs.number("euclidean_accumulator");
            outputs.word("euclidean_reset_accum", 1);
        }
        JobKind::Angular => {
            outputs.number("angular_dot_product");
            outputs.number("angular_norm");
            outputs.word("angular_reset_accum", 1);
        }
    }
    Columns { inputs: inputs.0, outputs: outputs.0 }
}

fn beat(inputs: &mut List, lanes: u32) {
    inputs.word("euclidean_reset_accum", 1);
    inputs.word("euclidean_mask", lanes);
    for vector in ["a", "b"] {
        (0..lanes).for_each(|lane| inputs.number(&format!("euclidean_{vector}_{lane}")));
    }
}

#[derive(Default)]
struct List(Vec<Column>);

impl List {
    fn number(&mut self, port: &str) {
        self.word(port, 32);
    }

    fn vector(&mut self, port: &str) {
        ["x", "y", "z"].iter().for_each(|axis| self.number(&format!("{port}_{axis}")));
    }

    fn word(&mut self, port: &str, width: u32) {
        self.0.push(Column { port: port.to_string(), bit: None, width });
    }

    fn flag(&mut self, port: &str, bit: u32) {
        self.0.push(Column { port: port.to_string(), bit: Some(bit), width: 1 });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raypath_ops::{Job, Outcome, PortKind, PortValue};
    use std::collections::BTreeMap;

    /// Bits that columns give each port.
    fn widths(columns: &[Column]) -> BTreeMap<String, u32> {
        let mut widths = BTreeMap::new();
        for column in columns {
            *widths.entry(column.port.clone()).or_insert(0) += column.width;
        }
        widths
    }

    /// Every port of an operation has its columns, and no column stands for anything else: the one list of ports that
    /// is written by hand cannot drift.
    #[test]
    fn columns_are_the_ports() {
        for kind in JobKind::ALL {
            let Columns { inputs, outputs } = columns(kind);
            let ones = Job::<16, 8>::from_ports(kind, |_| u64::MAX).ports();
            let outcome = Outcome::from_ports(kind, |_| u64::MAX).ports();
            for (columns, ports) in [(inputs, ones), (outputs, outcome)] {
                // A port that is all ones has as many bits as it is wide; a number has 32, whatever NaN became.
                let width = |port: &PortValue| match port.kind {
                    PortKind::Number => 32,
                    PortKind::Flags | PortKind::Word => port.bits.count_ones(),
                };
                let expected: BTreeMap<String, u32> =
                    ports.iter().map(|port| (port.name.clone(), width(port))).collect();
                assert_eq!(widths(&columns), expected, "{kind}");
            }
        }
    }
}
