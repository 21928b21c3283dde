//! Logic that is the same in several rounds of a stage, because it reads the same registers and units.

use crate::allocate::binding::Bindings;
use crate::allocate::layout::{Layout, Origin};
use crate::ir::graph::{NodeId, Op, OperationGraph};
use crate::ir::position::Step;
use std::collections::BTreeMap;

/// The first of the values that are the same net, for each value that is not the first.
pub type Alike = BTreeMap<NodeId, NodeId>;

/// What an operator reads.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum Operand {
    Net(Origin),
    Constant(String),
}

/// The values of an operation in a stage that are the same net. Units without a binding differ from each other.
pub fn alike(graph: &OperationGraph<Step>, op: usize, made: &[NodeId], before: &Layout, bindings: &Bindings) -> Alike {
    let mut alike = Alike::new();
    let mut first: BTreeMap<(String, Vec<Operand>), NodeId> = BTreeMap::new();
    for &id in made {
        let own = &graph.node(id).op;
        let operands = graph.operands(id);
        let key = match bindings.get(&id) {
            Some(binding) => (binding.unit.stem(), Vec::new()),
            None if graph.unit_part(id).is_some() || matches!(own, Op::Flags(_) | Op::Residue(..)) => continue,
            None => {
                let operand = |&id: &NodeId| match before.slot(op, id) {
                    Some(slot) => Operand::Net(Origin::Register(slot)),
                    None if graph.is_everywhere(id) => Operand::Constant(format!("{:?}", graph.node(id).op)),
                    None => Operand::Net(Origin::Logic(op, *alike.get(&id).unwrap_or(&id))),
                };
                (operator(own), operands.iter().map(operand).collect())
            }
        };
        let known = *first.entry(key).or_insert(id);
        if known != id {
            alike.insert(id, known);
        }
    }
    alike
}

/// An operator without its operands.
fn operator(op: &Op) -> String {
    match op {
        Op::Test(test, _) => format!("{test:?}"),
        Op::Relation(_, relation) => format!("{relation:?}"),
        _ => format!("{op:?}").split('(').next().unwrap_or_default().to_string(),
    }
}
