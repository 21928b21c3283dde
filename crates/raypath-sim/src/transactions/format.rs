//! The columns of transaction files (`docs/reference/transactions.md`). A line has one transaction: hexadecimal numbers
//! without `0x`, separated by spaces. The columns are the operation's ports in order. For the paper's operations, the
//! columns of the golden vectors come first, in the order in which they were recorded.

use raypath_float::Format;
use raypath_model::{OperationId, WordModel};
use raypath_ops::{JobKind, PortKind, PortValue};

/// A column: a port, or one bit of a port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// The name of the port without direction suffix.
    pub port: String,
    /// The bit of the port; `None` for the whole port.
    pub bit: Option<u32>,
    /// The width of the value in bits.
    pub width: u32,
}

/// The columns of the files of one operation, except `seq` and `cat`.
#[derive(Debug, Clone)]
pub struct Columns {
    /// The columns of the job.
    pub inputs: Vec<Column>,
    /// The columns of the outcome.
    pub outputs: Vec<Column>,
    /// The lanes of a beat; `None` for operations other than distances.
    pub lanes: Option<usize>,
}

/// The columns for an operation of a model with numbers of `format`.
pub fn columns(model: &WordModel, kind: OperationId, format: Format) -> Columns {
    // The width of a port is the number of its ones when all bits are set.
    let inputs = of_ports(&model.job(kind, |_| u64::MAX).ports(), format);
    let outputs = of_ports(&model.outcome(kind, |_| u64::MAX).ports(), format);
    let Ok(kind) = kind.to_string().parse() else { return Columns { inputs, outputs, lanes: None } };
    let lanes = inputs.iter().filter(|column| column.port.starts_with("euclidean_a_")).count();
    let recorded = recorded(kind, lanes);
    let lanes = matches!(kind, JobKind::Euclidean | JobKind::Angular).then_some(lanes);
    Columns { inputs: arranged(&recorded.inputs.0, inputs), outputs: arranged(&recorded.outputs.0, outputs), lanes }
}

fn of_ports(ports: &[PortValue], format: Format) -> Vec<Column> {
    let width = |port: &PortValue| match port.kind {
        PortKind::Number => format.ieee_width(),
        PortKind::Flags | PortKind::Word => port.bits.count_ones(),
    };
    ports.iter().map(|port| Column { port: port.name.clone(), bit: None, width: width(port) }).collect()
}

/// The columns in the recorded order, followed by those that were not recorded.
fn arranged(recorded: &[RecordedColumn], mut columns: Vec<Column>) -> Vec<Column> {
    let present = |RecordedColumn { port, bit }: &RecordedColumn| {
        let column = columns.iter().find(|column| column.port == *port)?;
        let width = if bit.is_some() { 1 } else { column.width };
        Some(Column { port: port.clone(), bit: *bit, width })
    };
    let mut arranged: Vec<Column> = recorded.iter().filter_map(present).collect();
    columns.retain(|column| recorded.iter().all(|known| known.port != column.port));
    arranged.append(&mut columns);
    arranged
}

/// A column of the golden vectors: a port, or one bit of it.
#[derive(Debug)]
struct RecordedColumn {
    port: String,
    bit: Option<u32>,
}

/// The columns of the golden vectors for one operation.
#[derive(Default)]
struct Recorded {
    inputs: List,
    outputs: List,
}

fn recorded(kind: JobKind, lanes: usize) -> Recorded {
    let mut recorded = Recorded::default();
    let Recorded { inputs, outputs } = &mut recorded;
    match kind {
        JobKind::Triangle | JobKind::Quadbox => {
            for vector in ["origin", "dir", "inv"] {
                inputs.vector(&format!("ray_{vector}"));
            }
            for port in ["ray_extent", "ray_kx", "ray_ky", "ray_kz"] {
                inputs.port(port);
            }
            inputs.vector("ray_shear");
        }
        JobKind::Euclidean | JobKind::Angular => {
            inputs.port("euclidean_reset_accum");
            inputs.port("euclidean_mask");
            for vector in ["a", "b"] {
                (0..lanes).for_each(|lane| inputs.port(&format!("euclidean_{vector}_{lane}")));
            }
        }
    }
    match kind {
        JobKind::Triangle => {
            for vertex in ["a", "b", "c"] {
                inputs.vector(&format!("triangle_{vertex}"));
            }
            ["t_num", "t_denom", "triangle_hit"].iter().for_each(|port| outputs.port(port));
        }
        JobKind::Quadbox => {
            for place in 0..4 {
                for bound in ["min", "max"] {
                    for axis in ["x", "y", "z"] {
                        inputs.port(&format!("aabb_{place}_{axis}_{bound}"));
                    }
                }
            }
            (0..4).for_each(|place| outputs.port(&format!("tmin_{place}")));
            (0..4).for_each(|place| outputs.flag("is_intersect", place));
            (0..4).for_each(|place| outputs.port(&format!("box_index_{place}")));
        }
        JobKind::Euclidean => {
            outputs.port("euclidean_accumulator");
            outputs.port("euclidean_reset_accum");
        }
        JobKind::Angular => {
            ["dot_product", "norm", "reset_accum"].iter().for_each(|port| outputs.port(&format!("angular_{port}")));
        }
    }
    recorded
}

#[derive(Default)]
struct List(Vec<RecordedColumn>);

impl List {
    fn vector(&mut self, port: &str) {
        ["x", "y", "z"].iter().for_each(|axis| self.port(&format!("{port}_{axis}")));
    }

    fn port(&mut self, port: &str) {
        self.0.push(RecordedColumn { port: port.to_string(), bit: None });
    }

    fn flag(&mut self, port: &str, bit: u32) {
        self.0.push(RecordedColumn { port: port.to_string(), bit: Some(bit) });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Datapath;
    use raypath_rtl::{Config, Lanes};
    use std::collections::BTreeMap;

    /// The recorded columns of the paper's operations are all ports, each bit once, and nothing else. This keeps the
    /// list above, which is written by hand, in agreement with the operations.
    #[test]
    fn recorded_columns_are_the_ports() {
        for &lanes in Lanes::ALL {
            let model = Datapath::paper(Config::DEFAULT.lanes(lanes)).model();
            for kind in model.kinds() {
                let lanes = match kind.name() {
                    "euclidean" => lanes.count(),
                    "angular" => lanes.count() / 2,
                    _ => 0,
                };
                let expected = recorded(kind.name().parse().expect("one of the paper's"), lanes);
                for (columns, ports) in [(expected.inputs, model.inputs(kind)), (expected.outputs, model.outputs(kind))]
                {
                    let mut found: BTreeMap<&str, u32> = BTreeMap::new();
                    for column in &columns.0 {
                        *found.entry(&column.port).or_default() += column.bit.map_or(u32::MAX, |bit| 1 << bit);
                    }
                    let bits = |name: &str| if name == "is_intersect" { 0xf } else { u32::MAX };
                    let expected = ports.iter().map(|port| (port.name.as_str(), bits(&port.name))).collect();
                    assert_eq!(found, expected, "{kind}, {lanes} lanes");
                }
            }
        }
    }

    /// Ports that were not recorded follow the recorded ones; a recorded port that the model lacks has no column.
    #[test]
    fn further_ports_follow_the_recorded_ones() {
        let known = |port: &str, bit| RecordedColumn { port: port.to_string(), bit };
        let column = |port: &str, bit, width| Column { port: port.to_string(), bit, width };
        let recorded = [known("b", None), known("gone", None), known("a", Some(0)), known("a", Some(1))];
        let ports = vec![column("tag", None, 8), column("a", None, 2), column("b", None, 32), column("u", None, 32)];
        let expected = [
            column("b", None, 32),
            column("a", Some(0), 1),
            column("a", Some(1), 1),
            column("tag", None, 8),
            column("u", None, 32),
        ];
        assert_eq!(arranged(&recorded, ports), expected);
    }
}
