//! A hierarchy of modules as one list of the operations that outputs depend on, in the order of evaluation.

use crate::Error;
use crate::graph::{Call, Graph, Node, Operation};
use crate::netlist::{Column, Driver, MemoryInfo, Module, RegisterInfo, SignalId};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Whether output port `output` of `module` depends on input port `input` within one cycle.
///
/// # Errors
/// No such port, or signals that depend on themselves.
pub fn depends_combinationally(module: &Arc<Module>, output: &str, input: &str) -> Result<bool, Error> {
    module.input_position(input)?;
    Ok(combinational_inputs(module, &[output])?.contains(&input))
}

/// The names of the inputs that outputs depend on within one cycle.
///
/// # Errors
/// No output of one of these names; a combinational loop.
pub fn combinational_inputs<'m>(module: &'m Arc<Module>, outputs: &[&str]) -> Result<Vec<&'m str>, Error> {
    let positions = outputs.iter().map(|output| module.output_position(output)).collect::<Result<Vec<_>, _>>()?;
    let mut open: Vec<SignalId> = positions.into_iter().map(|position| module.outputs[position].signal).collect();
    let graph = loop_free(module)?;
    let mut seen = vec![false; graph.nodes.len()];
    while let Some(node) = open.pop() {
        if !std::mem::replace(&mut seen[node.index()], true) {
            open.extend(graph.operands(node));
        }
    }
    Ok(module.inputs.iter().filter(|port| seen[port.signal.index()]).map(|port| port.name.as_str()).collect())
}

/// The names of the inputs that outputs depend on, in the same cycle or through registers and memories.
///
/// # Errors
/// No output of one of these names; a combinational loop.
pub fn influences<'m>(module: &'m Arc<Module>, outputs: &[&str]) -> Result<Vec<&'m str>, Error> {
    let positions = outputs.iter().map(|output| module.output_position(output)).collect::<Result<Vec<_>, _>>()?;
    let roots = positions.into_iter().map(|position| module.outputs[position].signal);
    let live = live(&loop_free(module)?, roots);
    Ok(module.inputs.iter().filter(|port| live[port.signal.index()]).map(|port| port.name.as_str()).collect())
}

/// The operations that a simulator executes. A [`SignalId`] in here is a position in [`Flat::nodes`].
pub struct Flat {
    /// Operands before readers; no aliases.
    pub nodes: Vec<Node>,
    /// The registers that are needed; their `signal` is a node.
    pub registers: Vec<RegisterInfo>,
    /// The memories that are needed, with the needed columns. A column that was read is a register that keeps its
    /// value, until the simulator changes it.
    pub memories: Vec<MemoryInfo>,
    /// The nodes at the top's outputs.
    pub outputs: Vec<SignalId>,
    /// Observed signals and the inputs of memories, each value once.
    pub observed: Vec<SignalId>,
    /// Observed names: hierarchical name, width, position in `observed`.
    pub names: Vec<(String, u32, usize)>,
    /// Instances that are evaluated as functions, and the function of each.
    pub calls: Vec<(usize, Call)>,
    /// Register-free, instance-free modules, flattened once.
    pub functions: Vec<Flat>,
}

impl Flat {
    /// Flattens `top`, keeping the named signals for whose hierarchical name `observed` holds.
    pub fn new(top: &Arc<Module>, observed: &dyn Fn(&str) -> bool) -> Result<Self, Error> {
        loop_free(top)?;
        // All outputs of a call depend on all its inputs. If that closes a loop, the modules on the loop are expanded.
        let mut expanded: HashSet<*const Module> = HashSet::new();
        loop {
            let called = |prefix: &str, module: &Arc<Module>| {
                worth_a_call(module)
                    && !expanded.contains(&Arc::as_ptr(module))
                    && !names_in(module, prefix).any(|(name, _)| observed(&name))
            };
            let graph = Graph::new(top, called);
            let nodes = match graph.order(roots(&graph, top)) {
                Ok(order) => return Self::assemble(top, graph, order, observed),
                Err(nodes) => nodes,
            };
            for node in &nodes {
                if let Operation::Result { call, .. } = graph.nodes[node.index()].operation {
                    expanded.insert(Arc::as_ptr(&graph.calls[call].module));
                }
            }
        }
    }

    fn assemble(
        top: &Arc<Module>,
        graph: Graph,
        order: Vec<SignalId>,
        observed: &dyn Fn(&str) -> bool,
    ) -> Result<Self, Error> {
        let mut named = Vec::new();
        for scope in &graph.scopes {
            let here = names_in(&scope.module, &scope.prefix).filter(|(name, _)| observed(name));
            named.extend(here.map(|(name, id)| (name, SignalId(scope.first + id.0))));
        }
        let outputs: Vec<SignalId> = top.outputs.iter().map(|port| port.signal).collect();
        let words = graph.memories.iter().flat_map(words_in).filter(|(name, ..)| observed(name));
        let words = words.map(|(_, column, _)| column.read);
        let live = live(&graph, outputs.iter().copied().chain(named.iter().map(|&(_, id)| id)).chain(words));

        let mut flat = Self {
            nodes: Vec::new(),
            registers: Vec::new(),
            memories: Vec::new(),
            outputs,
            observed: Vec::new(),
            names: Vec::new(),
            calls: Vec::new(),
            functions: Vec::new(),
        };
        let Graph { nodes, registers, memories, calls, .. } = graph;
        let mut nodes: Vec<Option<Node>> = nodes.into_iter().map(Some).collect();
        let mut places = vec![SignalId(u32::MAX); nodes.len()];
        let mut call_places = HashMap::new();
        for id in order {
            let Some(mut node) = nodes[id.index()].take().filter(|_| live[id.index()]) else { continue };
            match &mut node.operation {
                Operation::Input(_) => {}
                Operation::Register(register) => {
                    flat.registers.push(registers[*register].clone());
                    *register = flat.registers.len() - 1;
                }
                Operation::Result { call, .. } => {
                    let next = call_places.len();
                    *call = *call_places.entry(*call).or_insert(next);
                }
                Operation::Operator(Driver::Alias(source)) => {
                    places[id.index()] = places[source.index()];
                    continue;
                }
                Operation::Operator(driver) => driver.renumber(|id| places[id.index()]),
            }
            places[id.index()] = SignalId(flat.nodes.len() as u32);
            flat.nodes.push(node);
        }
        flat.add_calls(calls, &call_places)?;
        for mut memory in memories {
            memory.columns.retain(|column| live[column.read.index()]);
            flat.memories.extend((!memory.columns.is_empty()).then_some(memory));
        }
        flat.place(&places, named);
        Ok(flat)
    }

    /// The position of the register that a node shows.
    pub fn register(&self, node: SignalId) -> Option<usize> {
        match self.nodes[node.index()].operation {
            Operation::Register(register) => Some(register),
            _ => None,
        }
    }

    /// Keeps the needed calls, in the order of `places`, and flattens each called module once.
    fn add_calls(&mut self, calls: Vec<Call>, places: &HashMap<usize, usize>) -> Result<(), Error> {
        let mut needed: Vec<(usize, Call)> =
            calls.into_iter().enumerate().filter_map(|(call, it)| Some((*places.get(&call)?, it))).collect();
        needed.sort_by_key(|&(place, _)| place);
        let mut functions = HashMap::new();
        for (_, call) in needed {
            let next = self.functions.len();
            let function = *functions.entry(Arc::as_ptr(&call.module)).or_insert(next);
            if function == next {
                self.functions.push(Flat::new(&call.module, &|_| false)?);
            }
            self.calls.push((function, call));
        }
        Ok(())
    }

    /// Replaces positions in the graph by positions in the list.
    fn place(&mut self, places: &[SignalId], named: Vec<(String, SignalId)>) {
        let place = |id: &mut SignalId| *id = places[id.index()];
        self.outputs.iter_mut().for_each(place);
        for (_, call) in &mut self.calls {
            call.inputs.iter_mut().for_each(place);
        }
        self.registers.iter_mut().flat_map(RegisterInfo::signals_mut).for_each(place);
        self.memories.iter_mut().flat_map(MemoryInfo::signals_mut).for_each(place);
        let mut slots = HashMap::new();
        let observed = &mut self.observed;
        let mut observe = |id: SignalId| {
            *slots.entry(id).or_insert_with(|| {
                observed.push(id);
                observed.len() - 1
            })
        };
        for (name, mut id) in named {
            place(&mut id);
            self.names.push((name, self.nodes[id.index()].width, observe(id)));
        }
        self.memories.iter().flat_map(MemoryInfo::inputs).for_each(|&id| {
            observe(id);
        });
    }
}

/// The most words of a memory that can be observed.
const MAX_OBSERVED_WORDS: u32 = 64;

/// The words of a memory that can be observed, with their columns and addresses.
pub fn words_in(memory: &MemoryInfo) -> Vec<(String, &Column, u32)> {
    let depth = Some(memory.depth).filter(|&depth| depth <= MAX_OBSERVED_WORDS).unwrap_or(0);
    let word = |column: &'_ Column, address: u32| format!("{}.{}_{address}", memory.name, column.name);
    let of_column = |column| (0..depth).map(move |address| (word(column, address), column, address));
    memory.columns.iter().flat_map(of_column).collect()
}

impl Module {
    /// The position of an input port; an error where there is none of this name.
    pub(crate) fn input_position(&self, name: &str) -> Result<usize, Error> {
        self.inputs.iter().position(|port| port.name == name).ok_or_else(|| self.no_port(name, "input"))
    }

    /// The position of an output port; an error where there is none of this name.
    pub(crate) fn output_position(&self, name: &str) -> Result<usize, Error> {
        self.outputs.iter().position(|port| port.name == name).ok_or_else(|| self.no_port(name, "output"))
    }

    fn no_port(&self, name: &str, direction: &str) -> Error {
        let problem = format!("is not an {direction} of it");
        Error::Name { module: self.name.clone(), name: name.to_string(), problem }
    }
}

/// The fewest signals for which calling a module as a function is faster than expanding it.
const MIN_CALL_SIGNALS: usize = 24;

fn worth_a_call(module: &Module) -> bool {
    !module.is_clocked() && module.instances.is_empty() && module.signals.len() >= MIN_CALL_SIGNALS
}

/// Hierarchical names of the output ports, named signals and ports of memories of a module, and what they are in it.
fn names_in(module: &Module, prefix: &str) -> impl Iterator<Item = (String, SignalId)> {
    let outputs = module.outputs.iter().map(|port| (&port.name, port.signal));
    let signals = module.signals.iter().enumerate();
    let signals = signals.filter_map(|(place, signal)| Some((signal.name.as_ref()?, SignalId(place as u32))));
    let memories = module.memories.iter().flat_map(move |memory| {
        let inputs = memory.inputs().into_iter().enumerate();
        inputs.map(move |(input, id)| (format!("{prefix}{}.{}", memory.name, memory.input_name(input)), *id))
    });
    outputs.chain(signals).map(move |(name, id)| (format!("{prefix}{name}"), id)).chain(memories)
}

/// The nodes to compute, register by register, so that a value is stored soon after it is computed.
fn roots(graph: &Graph, top: &Module) -> impl Iterator<Item = SignalId> {
    let registers = graph.registers.iter().flat_map(|r| [Some(r.signal), Some(r.next), r.enable]).flatten();
    let memories = graph.memories.iter().flat_map(|memory| memory.inputs().into_iter().copied());
    registers.chain(memories).chain(top.outputs.iter().map(|port| port.signal))
}

/// Which nodes `roots` depend on, in this cycle or through registers.
fn live(graph: &Graph, roots: impl Iterator<Item = SignalId>) -> Vec<bool> {
    let mut live = vec![false; graph.nodes.len()];
    let mut open: Vec<SignalId> = roots.collect();
    while let Some(node) = open.pop() {
        if std::mem::replace(&mut live[node.index()], true) {
            continue;
        }
        open.extend(graph.operands(node));
        if let Operation::Register(register) = graph.nodes[node.index()].operation {
            let info = &graph.registers[register];
            open.push(info.next);
            open.extend(info.enable);
            if let Some(&(memory, column)) = graph.columns.get(&register) {
                let memory = &graph.memories[memory];
                open.extend([memory.write_enable, memory.write_address, memory.read_enable, memory.read_address]);
                open.push(memory.columns[column].written);
            }
        }
    }
    live
}

/// The graph of every signal. Signals that depend on themselves are an error, even if no output needs them.
pub fn loop_free(top: &Arc<Module>) -> Result<Graph, Error> {
    let graph = Graph::new(top, |_, _| false);
    match graph.order(std::iter::empty()) {
        Ok(_) => Ok(graph),
        // In the direction of the data, the first again at the end. Only forward wires and instances close loops, and
        // they have names; the expressions between them do not matter.
        Err(nodes) => {
            let mut names: Vec<String> = nodes.iter().filter_map(|&node| graph.name(node)).collect();
            names.extend(names.first().cloned());
            Err(Error::Loop(names))
        }
    }
}
