//! The significands of numbers: how many of its bits each value may use.

use crate::ir::graph::{Kind, NodeId, Op, OperationGraph};
use crate::ir::position::Position;
use crate::ir::units::UnitWidth;
use raypath_float::Format;
use raypath_ops::Narrowing;

/// The significands of all numbers of a datapath, by operation and value.
#[derive(Debug)]
pub struct Widths {
    /// The significand of an operand of narrow units; `None` if there are no such units.
    narrow: Option<u32>,
    /// The greatest significand of a short factor; `None` if the datapath has no words that become short numbers.
    factor: Option<u32>,
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
        let narrow = narrow.filter(|&bits| bits < format.significand() && !counts_exceptions);
        let of_words =
            |graph: &OperationGraph<P>| -> Option<u32> { graph.ids().filter_map(|id| of_word(graph, id)).max() };
        let factor = operations.iter().filter_map(of_words).max();
        // A factor of more than half of the bits saves few rows of a multiplier.
        let factor = factor.filter(|&bits| 2 * bits <= format.significand() && !counts_exceptions);
        Self { narrow, factor, bits }
    }

    /// The significand of the second operand of multipliers by a short factor; `None` if the datapath has none.
    pub fn factor(&self) -> Option<u32> {
        self.factor
    }

    /// Whether a unit of this width can have the operands of a value in their order, or exchanged.
    pub fn fits<P: Position>(
        &self,
        width: UnitWidth,
        op: usize,
        graph: &OperationGraph<P>,
        id: NodeId,
        swapped: bool,
    ) -> bool {
        let UnitWidth::ShortFactor(bits) = width else { return true };
        let second = graph.operands(id).get(usize::from(!swapped)).copied();
        second.is_some_and(|second| self.bits[op][second.index()] <= bits)
    }

    /// The significand of an operand of a narrow unit; `None` if the datapath has no such units.
    pub fn narrow(&self) -> Option<u32> {
        self.narrow
    }

    /// Whether a number is as short as the operands of narrow units.
    pub fn is_short(&self, op: usize, id: NodeId) -> bool {
        self.narrow.is_some_and(|narrow| self.bits[op][id.index()] <= narrow)
    }

    /// The width of the unit that a value needs: a narrow one for a comparison of short numbers, and for a product of
    /// short numbers that is only rounded to a short one; one with a short factor for a product with a short word.
    pub fn of_unit<P: Position>(&self, op: usize, graph: &OperationGraph<P>, id: NodeId) -> UnitWidth {
        let operands = graph.operands(id);
        let is_short = |narrow: u32| operands.iter().all(|operand| self.bits[op][operand.index()] <= narrow);
        let is_factor = |operand: NodeId| self.factor.is_some_and(|bits| self.bits[op][operand.index()] <= bits);
        match (&graph.node(id).op, self.narrow) {
            (Op::Compare(..), Some(narrow)) if is_short(narrow) => UnitWidth::Short,
            (Op::Multiply(..), Some(narrow)) if is_short(narrow) => {
                let rounding = rounding_of(graph, id).filter(|to| to.margin == 0);
                rounding.map_or(UnitWidth::Full, UnitWidth::Rounding)
            }
            (Op::Multiply(a, b), _) if is_factor(*a) || is_factor(*b) => {
                self.factor.map_or(UnitWidth::Full, UnitWidth::ShortFactor)
            }
            (Op::Sum(terms), _) => UnitWidth::Terms(terms.len() as u32),
            _ => UnitWidth::Full,
        }
    }
}

/// The significand of a number that a word becomes, at least the least of a format.
fn of_word<P: Position>(graph: &OperationGraph<P>, id: NodeId) -> Option<u32> {
    let Op::NumberOf(word) = graph.node(id).op else { return None };
    let Kind::Word(width) = graph.node(word).kind else { return None };
    Some(width.max(LEAST_SIGNIFICAND))
}

/// The least significand of a format.
const LEAST_SIGNIFICAND: u32 = 3;

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
            Op::NumberOf(_) => of_word(graph, id).map_or(full, |bits| bits.min(full)),
            Op::Number(constant) if constant << (u32::BITS - 23) == 0 => 1,
            _ => full,
        };
    }
    bits
}
