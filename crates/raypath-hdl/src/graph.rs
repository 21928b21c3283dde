//! A hierarchy of modules as one graph of signals, and the order in which to evaluate it.

use crate::netlist::{Driver, MemoryInfo, Module, RegisterInfo, SignalId};
use std::collections::HashMap;
use std::sync::Arc;

/// Every signal of every scope. A [`SignalId`] in here is a position in [`Graph::nodes`].
pub struct Graph {
    pub scopes: Vec<Scope>,
    pub nodes: Vec<Node>,
    pub registers: Vec<RegisterInfo>,
    /// With hierarchical names.
    pub memories: Vec<MemoryInfo>,
    /// The registers that are columns of memories, and the memory and column of each. Such a register keeps its value
    /// until the simulator changes it.
    pub columns: HashMap<usize, (usize, usize)>,
    pub calls: Vec<Call>,
    /// The operands of node `n` are `operands[starts[n]..starts[n + 1]]`.
    operands: Vec<SignalId>,
    starts: Vec<u32>,
}

/// An instance in the hierarchy. The first scope is the top.
pub struct Scope {
    pub module: Arc<Module>,
    /// The prefix of a signal's name: empty, or instance names that each end in a dot.
    pub prefix: String,
    /// The node of the module's first signal.
    pub first: u32,
}

pub struct Node {
    pub width: u32,
    pub operation: Operation,
}

/// The source of a node's value.
pub enum Operation {
    /// An input port of the top.
    Input(usize),
    /// A register or a column of a memory, by position in [`Graph::registers`].
    Register(usize),
    /// An output of a call.
    Result { call: usize, output: usize },
    /// Any driver but `Input`, `Register`, `Memory` and `Instance`.
    Operator(Driver),
}

/// An instance that is evaluated as a whole instead of being expanded.
pub struct Call {
    pub module: Arc<Module>,
    pub inputs: Vec<SignalId>,
}

impl Graph {
    /// Expands `top`; an instance (its prefix and module) for which `called` holds becomes a [`Call`].
    pub fn new(top: &Arc<Module>, called: impl Fn(&str, &Arc<Module>) -> bool) -> Self {
        let mut graph = Self {
            scopes: Vec::new(),
            nodes: Vec::new(),
            registers: Vec::new(),
            memories: Vec::new(),
            columns: HashMap::new(),
            calls: Vec::new(),
            operands: Vec::new(),
            starts: vec![0],
        };
        graph.add_scope(top, String::new());
        let mut done = 0;
        while done < graph.scopes.len() {
            graph.expand_instances(done, &called);
            done += 1;
        }
        graph.collect_operands();
        graph
    }

    pub fn operands(&self, node: SignalId) -> &[SignalId] {
        &self.operands[self.starts[node.index()] as usize..self.starts[node.index() + 1] as usize]
    }

    /// All nodes, operands before readers, `roots` and what they need first; or the nodes of a loop, in the direction
    /// of the data.
    pub fn order(&self, roots: impl Iterator<Item = SignalId>) -> Result<Vec<SignalId>, Vec<SignalId>> {
        #[derive(Clone, Copy, PartialEq)]
        enum Mark {
            New,
            Open,
            Done,
        }
        let mut marks = vec![Mark::New; self.nodes.len()];
        let mut order = Vec::with_capacity(self.nodes.len());
        let mut path: Vec<(SignalId, usize)> = Vec::new();
        for root in roots.chain((0..self.nodes.len() as u32).map(SignalId)) {
            if marks[root.index()] == Mark::New {
                marks[root.index()] = Mark::Open;
                path.push((root, 0));
            }
            while let Some((node, visited)) = path.last_mut() {
                let Some(&operand) = self.operands(*node).get(*visited) else {
                    marks[node.index()] = Mark::Done;
                    order.push(*node);
                    path.pop();
                    continue;
                };
                *visited += 1;
                match marks[operand.index()] {
                    Mark::New => {
                        marks[operand.index()] = Mark::Open;
                        path.push((operand, 0));
                    }
                    Mark::Open => {
                        let readers = path.iter().rev().map(|&(node, _)| node);
                        let rest = readers.take_while(|&node| node != operand);
                        return Err(std::iter::once(operand).chain(rest.collect::<Vec<_>>()).collect());
                    }
                    Mark::Done => {}
                }
            }
        }
        Ok(order)
    }

    /// The hierarchical name of a node, if its signal has a name.
    pub fn name(&self, node: SignalId) -> Option<String> {
        let scope = &self.scopes[self.scopes.partition_point(|s| s.first <= node.0) - 1];
        let name = scope.module.signals[node.index() - scope.first as usize].name.as_ref()?;
        Some(format!("{}{name}", scope.prefix))
    }

    /// Adds the signals of a module; those of its instances' outputs and, but in the top, of its inputs remain to be
    /// connected.
    fn add_scope(&mut self, module: &Arc<Module>, prefix: String) {
        let first = self.nodes.len() as u32;
        let (first_register, first_memory) = (self.registers.len(), self.memories.len());
        let shift = |id: SignalId| SignalId(id.0 + first);
        let mut columns: Vec<RegisterInfo> = Vec::new();
        for (place, signal) in (first..).zip(&module.signals) {
            let operation = match &signal.driver {
                Driver::Register(register) => Operation::Register(first_register + register),
                Driver::Memory { memory, column } => {
                    let register = first_register + module.registers.len() + columns.len();
                    self.columns.insert(register, (first_memory + memory, *column));
                    let signal = SignalId(place);
                    columns.push(RegisterInfo { signal, next: signal, enable: None, reset: None, gated: false });
                    Operation::Register(register)
                }
                driver => {
                    let mut driver = driver.clone();
                    driver.renumber(shift);
                    Operation::Operator(driver)
                }
            };
            self.nodes.push(Node { width: signal.width, operation });
        }
        if self.scopes.is_empty() {
            for (position, port) in module.inputs.iter().enumerate() {
                self.nodes[port.signal.index()].operation = Operation::Input(position);
            }
        }
        self.registers.extend(module.registers.iter().cloned().map(|mut register| {
            register.signals_mut().for_each(|id| *id = shift(*id));
            register
        }));
        self.registers.extend(columns);
        self.memories.extend(module.memories.iter().cloned().map(|mut memory| {
            memory.signals_mut().for_each(|id| *id = shift(*id));
            memory.name = format!("{prefix}{}", memory.name);
            memory
        }));
        self.scopes.push(Scope { module: module.clone(), prefix, first });
    }

    fn expand_instances(&mut self, scope: usize, called: &impl Fn(&str, &Arc<Module>) -> bool) {
        let parent = self.scopes[scope].module.clone();
        let first = self.scopes[scope].first;
        let shift = |id: SignalId| SignalId(id.0 + first);
        for instance in &parent.instances {
            let prefix = format!("{}{}.", self.scopes[scope].prefix, instance.name);
            if called(&prefix, &instance.module) {
                let call = self.calls.len();
                for (output, &id) in instance.outputs.iter().enumerate() {
                    self.nodes[shift(id).index()].operation = Operation::Result { call, output };
                }
                let inputs = instance.inputs.iter().map(|&id| shift(id)).collect();
                self.calls.push(Call { module: instance.module.clone(), inputs });
                continue;
            }
            let inside = self.nodes.len() as u32;
            self.add_scope(&instance.module, prefix);
            for (port, &id) in instance.module.inputs.iter().zip(&instance.inputs) {
                self.connect(SignalId(inside + port.signal.0), shift(id));
            }
            for (port, &id) in instance.module.outputs.iter().zip(&instance.outputs) {
                self.connect(shift(id), SignalId(inside + port.signal.0));
            }
        }
    }

    fn connect(&mut self, node: SignalId, source: SignalId) {
        self.nodes[node.index()].operation = Operation::Operator(Driver::Alias(source));
    }

    fn collect_operands(&mut self) {
        for node in &self.nodes {
            match &node.operation {
                Operation::Input(_) | Operation::Register(_) => {}
                Operation::Result { call, .. } => self.operands.extend(&self.calls[*call].inputs),
                Operation::Operator(driver) => self.operands.extend(driver.operands()),
            }
            self.starts.push(self.operands.len() as u32);
        }
    }
}
