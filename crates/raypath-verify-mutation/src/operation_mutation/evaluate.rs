//! Evaluation of dataflows over software arithmetic, many jobs at a time. Of a dataflow with a fault, only the values
//! behind the fault are computed.

use super::graph::{Graph, Id, Kind, Node, Op};
use raypath_ops::{Binary32, Circuit, Relation, Single};
use std::collections::BTreeSet;

/// A value of each job of a step: the bits of a number, a truth value, a word, or an order (0 to 3: less, equal,
/// greater, unordered).
pub type Column = Vec<u32>;

/// Jobs in the order of their steps. The jobs of a step are independent of each other; a job has the state of the one
/// at its place in the step before. Each is the words of all ports in.
#[derive(Debug, Default)]
pub struct Jobs {
    pub steps: Vec<Vec<Vec<u64>>>,
}

/// The values of all nodes that have an effect, in each step.
pub struct Values {
    steps: Vec<Vec<Column>>,
}

const LESS: u32 = 0;
const EQUAL: u32 = 1;
const GREATER: u32 = 2;
const UNORDERED: u32 = 3;

impl Values {
    /// The values of a dataflow.
    pub fn of(graph: &Graph, jobs: &Jobs) -> Self {
        let live = graph.live();
        let mut steps: Vec<Vec<Column>> = Vec::new();
        for inputs in &jobs.steps {
            let mut values: Vec<Column> = Vec::with_capacity(graph.nodes.len());
            for (id, node) in graph.nodes.iter().enumerate() {
                let column = match node.op {
                    _ if !live[id] => Column::new(),
                    Op::State(_) => before(graph, id, steps.last(), inputs.len(), |values, id| &values[id]),
                    _ => computed(node, inputs, |operand| &values[operand]),
                };
                values.push(column);
            }
            steps.push(values);
        }
        Self { steps }
    }

    /// The computed numbers that are NaN in no job.
    pub fn never_nan(&self, graph: &Graph) -> BTreeSet<Id> {
        let live = graph.live();
        let is_number = |&id: &Id| {
            let op = graph.nodes[id].op;
            let is_source = matches!(op, Op::Input(..) | Op::State(_)) || op.is_constant();
            live[id] && op.kind() == Kind::Number && !is_source
        };
        let never = |id: &Id| self.steps.iter().flat_map(|step| &step[*id]).all(|&bits| !f32::from_bits(bits).is_nan());
        (0..graph.nodes.len()).filter(is_number).filter(never).collect()
    }

    /// The words at the ports out of a job.
    pub fn outcome(&self, graph: &Graph, step: usize, job: usize) -> Vec<u64> {
        let mut words = vec![0; graph.ports_out.len()];
        for leaf in &graph.outputs {
            let value = self.steps[step][leaf.node][job];
            words[leaf.port] |= u64::from(canonical(graph, leaf.node, value)) << leaf.bit;
        }
        words
    }

    /// Whether a dataflow with a fault has another outcome for a job.
    pub fn differ(&self, graph: &Graph, faulty: &Graph, jobs: &Jobs) -> bool {
        let is_behind = behind(graph, faulty);
        let outputs: Vec<usize> = (0..faulty.outputs.len())
            .filter(|&output| {
                let [right, wrong] = [graph, faulty].map(|graph| graph.outputs[output].node);
                right != wrong || is_behind[wrong]
            })
            .collect();
        let mut last: Option<Vec<Column>> = None;
        for (step, inputs) in jobs.steps.iter().enumerate() {
            let right = &self.steps[step];
            let mut values: Vec<Column> = vec![Column::new(); faulty.nodes.len()];
            for (id, node) in faulty.nodes.iter().enumerate().filter(|(id, _)| is_behind[*id]) {
                values[id] = match node.op {
                    Op::State(_) => before(faulty, id, last.as_ref(), inputs.len(), |values, id| {
                        if is_behind[id] { &values[id] } else { &self.steps[step - 1][id] }
                    }),
                    _ => computed(node, inputs, |id| if is_behind[id] { &values[id] } else { &right[id] }),
                };
            }
            let value = |id: Id| if is_behind[id] { &values[id] } else { &right[id] };
            let differs = |&output: &usize| {
                let [was, is] = [graph.outputs[output].node, faulty.outputs[output].node];
                let of_jobs = right[was].iter().zip(value(is));
                of_jobs.into_iter().any(|(&a, &b)| canonical(graph, was, a) != canonical(faulty, is, b))
            };
            if outputs.iter().any(differs) {
                return true;
            }
            last = Some(values);
        }
        false
    }
}

/// The nodes whose values can differ from those without the fault and have an effect.
pub fn behind(graph: &Graph, faulty: &Graph) -> Vec<bool> {
    let live = faulty.live();
    let was_live = graph.live();
    let mut is_behind = vec![false; faulty.nodes.len()];
    loop {
        for (id, node) in faulty.nodes.iter().enumerate() {
            let differs = *node != graph.nodes[id] || !was_live[id];
            is_behind[id] |= live[id] && (differs || node.operands.iter().any(|&operand| is_behind[operand]));
        }
        let states = faulty.states.iter().zip(&graph.states);
        let reads = states.filter(|((_, next), (_, was))| next != was || is_behind[*next]).map(|((read, _), _)| *read);
        let new: Vec<Id> = reads.filter(|&read| live[read] && !is_behind[read]).collect();
        if new.is_empty() {
            return is_behind;
        }
        new.into_iter().for_each(|read| is_behind[read] = true);
    }
}

/// A value of the state: what the step before left, zeros in the first.
fn before<'v>(
    graph: &Graph,
    id: Id,
    last: Option<&'v Vec<Column>>,
    jobs: usize,
    value: impl Fn(&'v Vec<Column>, Id) -> &'v Column,
) -> Column {
    let next = graph.states.iter().find(|(read, _)| *read == id).map(|(_, next)| *next);
    match last.zip(next) {
        Some((last, next)) => value(last, next).clone(),
        None => vec![0; jobs],
    }
}

/// A NaN at a port is the canonical one.
fn canonical(graph: &Graph, id: Id, value: u32) -> u32 {
    match graph.nodes[id].op.kind() {
        Kind::Number if f32::from_bits(value).is_nan() => 0x7fc0_0000,
        _ => value,
    }
}

fn computed<'v>(node: &Node, inputs: &[Vec<u64>], value: impl Fn(Id) -> &'v Column) -> Column {
    let c = Binary32;
    let number = |bits: &u32| Single(f32::from_bits(*bits));
    let one = |f: &dyn Fn(u32) -> u32| -> Column { value(node.operands[0]).iter().map(|a| f(*a)).collect() };
    let two = |f: fn(u32, u32) -> u32| -> Column {
        let [a, b] = [0, 1].map(|place| value(node.operands[place]));
        a.iter().zip(b).map(|(a, b)| f(*a, *b)).collect()
    };
    let numbers = |f: fn(f32, f32) -> f32| -> Column {
        let [a, b] = [0, 1].map(|place| value(node.operands[place]));
        a.iter().zip(b).map(|(a, b)| f(f32::from_bits(*a), f32::from_bits(*b)).to_bits()).collect()
    };
    let same = |bits: u32| vec![bits; inputs.len()];
    let mut column = match node.op {
        Op::Input(port, bit, kind) => {
            let mask = match kind {
                Kind::Bit => 1,
                Kind::Word(width) => u32::MAX >> (32 - width),
                Kind::Number | Kind::Order => u32::MAX,
            };
            inputs.iter().map(|job| (job[port] >> bit) as u32 & mask).collect()
        }
        Op::State(_) => Column::new(),
        Op::Constant(value) => same(value.to_bits()),
        Op::OnePlusUlps(ulps) => same(c.one_plus_ulps(ulps).0.to_bits()),
        Op::Add => numbers(|a, b| a + b),
        Op::Subtract => numbers(|a, b| a - b),
        Op::Multiply => numbers(|a, b| a * b),
        Op::Sum => {
            let terms: Vec<&Column> = node.operands.iter().map(|&id| value(id)).collect();
            let sum = |job: usize| {
                let terms: Vec<Single> = terms.iter().map(|term| number(&term[job])).collect();
                c.sum(&terms).0.to_bits()
            };
            (0..inputs.len()).map(sum).collect()
        }
        Op::Negate => one(&|a| a ^ 1 << 31),
        Op::Narrow(to) => one(&|a| c.narrow(number(&a), to).0.to_bits()),
        Op::Compare => {
            let [a, b] = [0, 1].map(|place| value(node.operands[place]));
            let order = |(a, b): (&u32, &u32)| match number(a).0.partial_cmp(&number(b).0) {
                None => UNORDERED,
                Some(order) => (order as i8 + 1) as u32,
            };
            a.iter().zip(b).map(order).collect()
        }
        Op::Relation(relation) => one(&|order| {
            u32::from(match relation {
                Relation::Less => order == LESS,
                Relation::LessOrEqual => order <= EQUAL,
                Relation::Equal => order == EQUAL,
                Relation::GreaterOrEqual => order == EQUAL || order == GREATER,
                Relation::Greater => order == GREATER,
            })
        }),
        Op::NumberOf(width) => one(&|word| c.number_of(width, word).0.to_bits()),
        Op::Test(test) => one(&|a| c.test(test, number(&a)).into()),
        Op::Bit(value) => same(value.into()),
        Op::Word(_, value) => same(value),
        Op::And => two(|a, b| a & b),
        Op::Or => two(|a, b| a | b),
        Op::Not => one(&|a| a ^ 1),
        Op::WordEqual => two(|a, b| (a == b).into()),
        Op::WordLess => two(|a, b| (a < b).into()),
        Op::Select(_) => {
            let [condition, a, b] = [0, 1, 2].map(|place| value(node.operands[place]));
            condition
                .iter()
                .zip(a.iter().zip(b))
                .map(|(condition, (a, b))| if *condition == 1 { *a } else { *b })
                .collect()
        }
        Op::Same(_) => one(&|a| a),
    };
    if node.inverted {
        column.iter_mut().for_each(|bit| *bit ^= 1);
    }
    column
}
