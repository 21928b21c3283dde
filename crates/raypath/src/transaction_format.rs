//! The columns of transaction files (`docs/transactions.md`): one transaction a line, fields separated by spaces,
//! hexadecimal without `0x`. Their order is that of the recorded golden vectors, not that of the ports.

use raypath_format::Format;
use raypath_ops::JobKind;
use raypath_rtl::Config;

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
    /// Lanes of a beat, where the job is one.
    pub lanes: Option<usize>,
}

/// The columns for a kind of job: as many lanes as the configuration has, numbers as wide as its format.
pub fn columns(kind: JobKind, config: Config) -> Columns {
    let (mut inputs, mut outputs) = (List::new(config.format), List::new(config.format));
    let lanes = match kind {
        JobKind::Triangle | JobKind::Quadbox => None,
        JobKind::Euclidean => Some(config.lanes.count()),
        JobKind::Angular => Some(config.lanes.count() / 2),
    };
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
        JobKind::Euclidean | JobKind::Angular => beat(&mut inputs, lanes.unwrap_or(0)),
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
    Columns { inputs: inputs.columns, outputs: outputs.columns, lanes }
}

fn beat(inputs: &mut List, lanes: usize) {
    inputs.word("euclidean_reset_accum", 1);
    inputs.word("euclidean_mask", lanes as u32);
    for vector in ["a", "b"] {
        (0..lanes).for_each(|lane| inputs.number(&format!("euclidean_{vector}_{lane}")));
    }
}

struct List {
    format: Format,
    columns: Vec<Column>,
}

impl List {
    fn new(format: Format) -> Self {
        Self { format, columns: Vec::new() }
    }

    fn number(&mut self, port: &str) {
        self.word(port, self.format.ieee_width());
    }

    fn vector(&mut self, port: &str) {
        ["x", "y", "z"].iter().for_each(|axis| self.number(&format!("{port}_{axis}")));
    }

    fn word(&mut self, port: &str, width: u32) {
        self.columns.push(Column { port: port.to_string(), bit: None, width });
    }

    fn flag(&mut self, port: &str, bit: u32) {
        self.columns.push(Column { port: port.to_string(), bit: Some(bit), width: 1 });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::{PaperModel, Visitor, with_model};
    use raypath_model::OnPorts;
    use raypath_ops::{PortKind, PortValue};
    use raypath_rtl::Lanes;
    use std::collections::BTreeMap;

    /// Bits that columns give each port.
    fn widths(columns: &[Column]) -> BTreeMap<String, u32> {
        let mut widths = BTreeMap::new();
        for column in columns {
            *widths.entry(column.port.clone()).or_insert(0) += column.width;
        }
        widths
    }

    struct ColumnsArePorts(Config);

    impl Visitor for ColumnsArePorts {
        type Answer = ();
        fn visit<M: PaperModel>(self, model: M) {
            for &kind in self.0.kinds() {
                let Columns { inputs, outputs, .. } = columns(kind, self.0);
                let ones = model.job(kind, |_| u64::MAX).ports();
                let outcome = model.outcome(kind, |_| u64::MAX).ports();
                for (columns, ports) in [(inputs, ones), (outputs, outcome)] {
                    // A port that is all ones has as many bits as it is wide; a number is a NaN then.
                    let width = |port: &PortValue| match port.kind {
                        PortKind::Number => self.0.format.ieee_width(),
                        PortKind::Flags | PortKind::Word => port.bits.count_ones(),
                    };
                    let expected: BTreeMap<String, u32> =
                        ports.iter().map(|port| (port.name.clone(), width(port))).collect();
                    assert_eq!(widths(&columns), expected, "{kind}, {}", self.0);
                }
            }
        }
    }

    /// Every port of an operation has its columns, and no column stands for anything else: the one list of ports that
    /// is written by hand cannot drift.
    #[test]
    fn columns_are_the_ports() {
        for &lanes in Lanes::ALL {
            for format in [Format::BINARY32, Format::BINARY16] {
                let config = Config { lanes, format, ..Config::DEFAULT };
                with_model(config, ColumnsArePorts(config));
            }
        }
    }
}
