//! The significands of numbers: how many of its bits each value may use.

use crate::ir::graph::{NodeId, Op, OperationGraph};
use crate::ir::position::Position;
use crate::ir::units::UnitWidth;
use raypath_float::Format;
use raypath_ops::Narrowing;

/// The significands of all numbers of a datapath, by operation and value.
#[derive(Debug)]
pub struct Widths {
    /// The significand of an operand of narrow units; `None` if there are no such units.
    narrow: Option<u32>,
    bits: Vec<Vec<u32>>,
}

impl Widths {
    /// The significands of these operations. Operations whose exceptions are counted have no narrow units, because
    /// these do not report exceptions.
    pub fn of<P: Position>(operations: &[OperationGraph<P>], format: Format) -> Self {
        let bits = operations.iter().map(|graph| significands(graph, format.significand())).collect();
        let counts_exceptions = operations.iter().any(|graph| graph.counts_exceptions);
        let narrowings = operations.iter().flat_map(|graph| &graph.nodes).filter_map(|node| node.op.narrowing());
        let narrow = narrowings.map(|to| to.bits).max();
        Self { narrow: narrow.filter(|&bits| bits < format.significand() && !counts_exceptions), bits }
    }

    /// The significand of an operand of a narrow unit; `None` if the datapath has no such units.
    pub fn narrow(&self) -> Option<u32> {
        self.narrow
    }

    /// The width of the unit that a value needs: a narrow one for a comparison of short numbers, and for a product of
    /// short numbers that is only rounded to a short one.
    pub fn of_unit<P: Position>(&self, op: usize, graph: &OperationGraph<P>, id: NodeId) -> UnitWidth {
        let operands = graph.operands(id);
        let is_short = |narrow: u32| operands.iter().all(|operand| self.bits[op][operand.index()] <= narrow);
        match (&graph.node(id).op, self.narrow) {
            (Op::Compare(..), Some(narrow)) if is_short(narrow) => UnitWidth::Short,
            (Op::Multiply(..), Some(narrow)) if is_short(narrow) => {
                let rounding = rounding_of(graph, id).filter(|to| to.margin == 0);
                rounding.map_or(UnitWidth::Full, UnitWidth::Rounding)
            }
            (Op::Sum(terms), _) => UnitWidth::Terms(terms.len() as u32),
            _ => UnitWidth::Full,
        }
    }
}

/// The rounding that is the only use of a value, or of the value that its next parts compute.
fn rounding_of<P: Position>(graph: &OperationGraph<P>, id: NodeId) -> Option<Narrowing> {
    if graph.outputs.iter().any(|output| output.node == id) {
        return None;
    }
    let mut readers = graph.ids().filter(|&reader| graph.operands(reader).contains(&id));
    let (reader, None) = (readers.next()?, readers.next()) else { return None };
    match graph.node(reader).op {
        Op::Continue(_) => rounding_of(graph, reader),
        Op::Narrow(_, to) => Some(to),
        _ => None,
    }
}

/// The significand of each number; the value has no meaning for others.
fn significands<P: Position>(graph: &OperationGraph<P>, full: u32) -> Vec<u32> {
    let mut bits = vec![full; graph.nodes.len()];
    for id in graph.ids() {
        bits[id.index()] = match graph.node(id).op {
            Op::Narrow(_, to) => to.bits,
            Op::Negate(a) => bits[a.index()],
            Op::Select(_, a, b) => bits[a.index()].max(bits[b.index()]),
            Op::Number(constant) if constant << (u32::BITS - 23) == 0 => 1,
            _ => full,
        };
    }
    bits
}
