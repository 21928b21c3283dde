//! The columns of transaction files (`docs/reference/transactions.md`): one transaction a line, fields separated by
//! spaces,
//! hexadecimal without `0x`. They follow from an operation's ports, in the ports' order; of the paper's operations
//! those that the golden vectors have come first, as they were recorded.

use raypath_float::Format;
use raypath_model::{OperationId, WordModel};
use raypath_ops::{JobKind, PortKind, PortValue};

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

/// The columns for a kind of job of a model, whose numbers have this format.
pub fn columns(model: &WordModel, kind: OperationId, format: Format) -> Columns {
    // A port that is all ones has as many bits as it is wide.
    let inputs = of_ports(&model.job(kind, |_| u64::MAX).ports(), format);
    let outputs = of_ports(&model.outcome(kind, |_| u64::MAX).ports(), format);
    let Ok(kind) = kind.to_string().parse() else { return Columns { inputs, outputs, lanes: None } };
    let lanes = inputs.iter().filter(|column| column.port.starts_with("euclidean_a_")).count();
    let recorded = recorded(kind, lanes);
    let lanes = matches!(kind, JobKind::Euclidean | JobKind::Angular).then_some(lanes);
    Columns { inputs: arranged(&recorded.inputs, inputs), outputs: arranged(&recorded.outputs, outputs), lanes }
}

fn of_ports(ports: &[PortValue], format: Format) -> Vec<Column> {
    let width = |port: &PortValue| match port.kind {
        PortKind::Number => format.ieee_width(),
        PortKind::Flags | PortKind::Word => port.bits.count_ones(),
    };
    ports.iter().map(|port| Column { port: port.name.clone(), bit: None, width: width(port) }).collect()
}

/// Columns in the recorded order, then those that were not recorded.
fn arranged(recorded: &[Place], mut columns: Vec<Column>) -> Vec<Column> {
    let of_place = |place: &Place| {
        let column = columns.iter().find(|column| column.port == place.port)?;
        let width = if place.bit.is_some() { 1 } else { column.width };
        Some(Column { port: place.port.clone(), bit: place.bit, width })
    };
    let mut arranged: Vec<Column> = recorded.iter().filter_map(of_place).collect();
    columns.retain(|column| recorded.iter().all(|place| place.port != column.port));
    arranged.append(&mut columns);
    arranged
}

/// What a column of the golden vectors holds: a port, or one of its bits.
#[derive(Debug)]
struct Place {
    port: String,
    bit: Option<u32>,
}

/// The columns of the golden vectors.
struct Recorded {
    inputs: Vec<Place>,
    outputs: Vec<Place>,
}

fn recorded(kind: JobKind, lanes: usize) -> Recorded {
    let (mut inputs, mut outputs) = (List::default(), List::default());
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
    Recorded { inputs: inputs.0, outputs: outputs.0 }
}

#[derive(Default)]
struct List(Vec<Place>);

impl List {
    fn vector(&mut self, port: &str) {
        ["x", "y", "z"].iter().for_each(|axis| self.port(&format!("{port}_{axis}")));
    }

    fn port(&mut self, port: &str) {
        self.0.push(Place { port: port.to_string(), bit: None });
    }

    fn flag(&mut self, port: &str, bit: u32) {
        self.0.push(Place { port: port.to_string(), bit: Some(bit) });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Datapath;
    use raypath_rtl::{Config, Lanes};

    /// Of the paper's operations all ports were recorded, each bit once, and no column stands for anything else: the
    /// one list of ports that is written by hand cannot drift.
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
                for (places, ports) in [(expected.inputs, model.inputs(kind)), (expected.outputs, model.outputs(kind))]
                {
                    let mut found: Vec<(&str, u32)> = Vec::new();
                    for place in &places {
                        let bits = place.bit.map_or(u32::MAX, |bit| 1 << bit);
                        match found.iter_mut().find(|(port, _)| *port == place.port) {
                            Some((_, others)) => *others += bits,
                            None => found.push((&place.port, bits)),
                        }
                    }
                    let bits = |name: &str| if name == "is_intersect" { 0xf } else { u32::MAX };
                    let mut wanted: Vec<(&str, u32)> =
                        ports.iter().map(|port| (port.name.as_str(), bits(&port.name))).collect();
                    found.sort_unstable();
                    wanted.sort_unstable();
                    assert_eq!(found, wanted, "{kind}, {lanes} lanes");
                }
            }
        }
    }

    /// What was not recorded follows, and what is not there has no column.
    #[test]
    fn further_ports_follow_the_recorded_ones() {
        let place = |port: &str, bit| Place { port: port.to_string(), bit };
        let column = |port: &str, bit, width| Column { port: port.to_string(), bit, width };
        let recorded = [place("b", None), place("gone", None), place("a", Some(0)), place("a", Some(1))];
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
