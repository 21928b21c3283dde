//! The columns of transaction files (`docs/reference/transactions.md`). A line has one transaction: hexadecimal numbers
//! without `0x`, separated by spaces. The columns are the operation's ports in order. For the paper's operations, the
//! columns of the golden vectors come first, in the order in which they were recorded.

use raypath_float::Format;
use raypath_model::{OperationId, WordModel};
use raypath_ops::{JobKind, Port};

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
    let [inputs, outputs] = [model.inputs(kind), model.outputs(kind)].map(|ports| of_ports(ports, kind, format));
    let is_beat = matches!(kind.paper(), Some(JobKind::Euclidean | JobKind::Angular));
    let lanes = inputs.iter().filter(|column| column.port.starts_with("euclidean_a_")).count();
    Columns { inputs, outputs, lanes: is_beat.then_some(lanes) }
}

/// The columns of the inputs or the outputs of an operation.
fn of_ports(ports: &[Port], kind: OperationId, format: Format) -> Vec<Column> {
    let is_recorded = kind.paper().is_some();
    let mut ports: Vec<&Port> = ports.iter().collect();
    if is_recorded {
        ports.sort_by_key(|port| (recorded_position(&port.name), port.name.ends_with("_max")));
    }
    let mut columns = Vec::new();
    for port in ports {
        let width = port.width.unwrap_or(format.ieee_width());
        let by_bit = is_recorded && port.name == "is_intersect";
        let (bits, width) = if by_bit { ((0..width).map(Some).collect(), 1) } else { (vec![None], width) };
        columns.extend(bits.into_iter().map(|bit| Column { port: port.name.clone(), bit, width }));
    }
    columns
}

/// The beginnings of the ports' names in the order in which the golden vectors have them. The bounds of a box are
/// ordered min before max.
const RECORDED: &str = "ray_origin_ ray_dir_ ray_inv_ ray_extent ray_k ray_shear_ t_num t_denom triangle_ aabb_0_ \
                        aabb_1_ aabb_2_ aabb_3_ tmin_ is_intersect box_index_ euclidean_accumulator \
                        euclidean_reset_accum euclidean_mask euclidean_a_ euclidean_b_ angular_";

/// The position of a port in [`RECORDED`]; ports that were not recorded follow.
fn recorded_position(port: &str) -> usize {
    RECORDED.split(' ').position(|recorded| port.starts_with(recorded)).unwrap_or(usize::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Datapath;
    use raypath_rtl::{Config, Lanes};

    /// The columns of the golden vectors, by hand, with a tag that was not recorded.
    #[test]
    fn columns_are_in_the_recorded_order() {
        let model = Datapath::paper(Config::DEFAULT.lanes(Lanes::Two).tag(8)).model();
        let text = |kind: &str| {
            let columns = columns(&model, model.kind(kind).expect("an operation"), Format::BINARY32);
            let name = |column: &Column| match column.bit {
                Some(bit) => format!("{}.{bit}", column.port),
                None => format!("{}:{}", column.port, column.width),
            };
            [columns.inputs, columns.outputs].map(|columns| columns.iter().map(name).collect::<Vec<_>>().join(" "))
        };
        let vectors = |names: &[&str]| {
            let vector = |name: &&str| ["x", "y", "z"].map(|axis| format!("{name}_{axis}:32")).join(" ");
            names.iter().map(vector).collect::<Vec<_>>().join(" ")
        };
        let ray = vectors(&["ray_origin", "ray_dir", "ray_inv"])
            + " ray_extent:32 ray_kx:2 ray_ky:2 ray_kz:2 "
            + &vectors(&["ray_shear"]);
        let corners = vectors(&["triangle_a", "triangle_b", "triangle_c"]);
        let triangle = [format!("{ray} {corners} tag:8"), "t_num:32 t_denom:32 triangle_hit:1 tag:8".to_string()];
        assert_eq!(text("triangle"), triangle);
        let corner = |(place, bound)| ["x", "y", "z"].map(|axis| format!("aabb_{place}_{axis}_{bound}:32")).join(" ");
        let corners = (0..4).flat_map(|place| ["min", "max"].map(|bound| corner((place, bound))));
        let corners = corners.collect::<Vec<_>>().join(" ");
        let four = |name: &str, end: &str| [0, 1, 2, 3].map(|place| format!("{name}{place}{end}")).join(" ");
        let sorted = [four("tmin_", ":32"), four("is_intersect.", ""), four("box_index_", ":2")].join(" ");
        assert_eq!(text("quadbox"), [format!("{ray} {corners} tag:8"), format!("{sorted} tag:8")]);
        let beat = "euclidean_reset_accum:1 euclidean_mask:2 euclidean_a_0:32 euclidean_a_1:32 euclidean_b_0:32 \
                    euclidean_b_1:32 tag:8";
        assert_eq!(text("euclidean"), [beat, "euclidean_accumulator:32 euclidean_reset_accum:1 tag:8"]);
        let beat = "euclidean_reset_accum:1 euclidean_mask:1 euclidean_a_0:32 euclidean_b_0:32 tag:8";
        let sums = "angular_dot_product:32 angular_norm:32 angular_reset_accum:1 tag:8";
        assert_eq!(text("angular"), [beat, sums]);
    }
}
