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
