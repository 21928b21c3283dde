use crate::engine::{Engine, PortEncoding, Shown, shape};
use raypath_hdl::{InputPort, Module, OutputPort, Simulator};
use raypath_model::{OperationId, Shape, WordModel, Words};
use raypath_ops::{Port, PortKind};
use raypath_rtl::{Config, DatapathNetlist};
use std::sync::Arc;

/// A simulated netlist as an engine.
pub struct NetlistEngine {
    model: WordModel,
    simulator: Simulator,
    encoding: PortEncoding,
    shape: Shape,
    /// The ports of each operation, indexed by opcode.
    operations: Vec<Option<OperationPorts>>,
    /// The output ports except those of the handshake, sorted by name.
    outputs: Vec<(String, OutputPort)>,
    ports: HandshakePorts,
    /// The seed of the initial state; zeros without one.
    initial: Option<u64>,
}

/// The values of the handshake ports in a cycle, before its clock edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Handshake {
    /// `input_ready_o`.
    pub input_ready: bool,
    /// `output_valid_o`.
    pub output_valid: bool,
}

/// A port of the netlist, `None` if the configuration lacks it, and the meaning of its bits.
type NetlistPort<P> = (Option<P>, PortKind);

struct OperationPorts {
    kind: OperationId,
    /// The ports of its jobs, in the order of their words.
    inputs: Vec<NetlistPort<InputPort>>,
    /// The ports of its outcomes, in the order of their words.
    outputs: Vec<NetlistPort<OutputPort>>,
    /// The output ports that belong to other operations only.
    foreign: Vec<OutputPort>,
}

struct HandshakePorts {
    input_valid: InputPort,
    output_ready: InputPort,
    opcode: InputPort,
    input_ready: OutputPort,
    output_valid: OutputPort,
    opcode_out: OutputPort,
}

impl NetlistEngine {
    /// Elaborates a configuration and compiles its netlist. `model` is a model of the configuration, which provides the
    /// ports of jobs and outcomes. `observed` selects the observable signals by hierarchical name.
    ///
    /// # Errors
    /// A configuration that cannot be elaborated.
    pub fn new(model: WordModel, config: Config, observed: impl Fn(&str) -> bool) -> Result<Self, raypath_rtl::Error> {
        Self::of(model, config, &DatapathNetlist::new(config)?, observed)
    }

    /// Compiles the netlist of an elaborated configuration.
    ///
    /// # Errors
    /// A datapath without the ports of the handshake.
    pub fn of(
        model: WordModel,
        config: Config,
        datapath: &DatapathNetlist,
        observed: impl Fn(&str) -> bool,
    ) -> Result<Self, raypath_rtl::Error> {
        Self::of_module(model, config, datapath.top(), shape(config, datapath), observed)
    }

    /// Compiles a module with the ports of a datapath, such as a mutated netlist. `shape` is the shape of its
    /// cycle-exact model.
    ///
    /// # Errors
    /// A module without the ports of the handshake.
    pub fn of_module(
        model: WordModel,
        config: Config,
        top: &Arc<Module>,
        shape: Shape,
        observed: impl Fn(&str) -> bool,
    ) -> Result<Self, raypath_rtl::Error> {
        let simulator = Simulator::observing(top, observed)?;
        let ports = HandshakePorts {
            input_valid: simulator.input("input_valid_i")?,
            output_ready: simulator.input("output_ready_i")?,
            opcode: simulator.input("opcode_i")?,
            input_ready: simulator.output("input_ready_o")?,
            output_valid: simulator.output("output_valid_o")?,
            opcode_out: simulator.output("opcode_o")?,
        };
        let not_handshake = |stem: &str| !["input_ready", "output_valid", "opcode"].contains(&stem);
        let mut all_outputs = Vec::new();
        for port in top.outputs().iter().filter(|port| not_handshake(port.stem())) {
            all_outputs.push((port.stem().to_string(), simulator.output(&port.name)?));
        }
        all_outputs.sort_by(|a, b| a.0.cmp(&b.0));
        let output = |port: &Port| all_outputs.iter().find(|(name, _)| *name == port.name).map(|(_, output)| *output);
        let input = |port: &Port| simulator.input(&format!("{}_i", port.name)).ok();
        let mut operations = Vec::new();
        for kind in model.kinds() {
            let (job, outcome) = (model.inputs(kind), model.outputs(kind));
            let inputs = job.iter().map(|port| (input(port), port.kind)).collect();
            let outputs: Vec<NetlistPort<OutputPort>> = outcome.iter().map(|port| (output(port), port.kind)).collect();
            let is_own = |output: &OutputPort| outputs.iter().any(|(own, _)| *own == Some(*output));
            let foreign = all_outputs.iter().map(|(_, output)| *output).filter(|output| !is_own(output)).collect();
            let opcode = kind.opcode() as usize;
            operations.resize_with(operations.len().max(opcode + 1), || None);
            operations[opcode] = Some(OperationPorts { kind, inputs, outputs, foreign });
        }
        let encoding = PortEncoding::of(config);
        let mut engine =
            Self { model, simulator, encoding, shape, operations, outputs: all_outputs, ports, initial: None };
        engine.reset();
        Ok(engine)
    }

    /// The simulator, for waveforms.
    pub fn simulator(&self) -> &Simulator {
        &self.simulator
    }

    /// The shape of its cycle-exact model.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Returns to the initial state, that of a new engine or of the last [`restart_randomly`](Self::restart_randomly).
    /// Unlike [`reset`](Engine::reset), this restores the data registers too.
    pub fn restart(&mut self) {
        match self.initial {
            Some(seed) => self.simulator.restart_randomly(seed),
            None => self.simulator.restart(),
        }
        self.reset();
    }

    /// Begins again with random values, which follow from the seed, in memories and in registers without a reset. What
    /// the ports show must not depend on them.
    pub fn restart_randomly(&mut self, seed: u64) {
        self.initial = Some(seed);
        self.restart();
    }

    /// Begins again with zeros in memories and in registers without a reset, as a new engine.
    pub fn restart_with_zeros(&mut self) {
        self.initial = None;
        self.restart();
    }

    /// As [`Engine::cycle`], but does not read the outcome. [`shows`](Self::shows) compares it faster.
    pub fn clock(&mut self, input_valid: bool, output_ready: bool) -> Handshake {
        self.simulator.set(self.ports.input_valid, input_valid.into());
        self.simulator.set(self.ports.output_ready, output_ready.into());
        self.simulator.cycle();
        self.handshake()
    }

    /// The values of the handshake ports in the last cycle, which may be one of a reset.
    pub fn handshake(&self) -> Handshake {
        let is_set = |port| self.simulator.get(port) == 1;
        Handshake { input_ready: is_set(self.ports.input_ready), output_valid: is_set(self.ports.output_valid) }
    }

    /// Whether all output ports showed exactly this outcome in the last cycle, with zeros at ports of other operations.
    pub fn shows(&self, outcome: &Words) -> bool {
        let (opcode, simulator, encoding) = (outcome.kind().opcode(), &self.simulator, self.encoding);
        let Some(Some(operation)) = self.operations.get(opcode as usize) else { return false };
        let mut values = operation.outputs.iter().zip(outcome.as_words());
        simulator.get(self.ports.opcode_out) == opcode
            && values
                .all(|(&(port, of), &bits)| port.is_none_or(|port| simulator.get(port) == encoding.to_port(of, bits)))
            && operation.foreign.iter().all(|&port| simulator.get(port) == 0)
    }

    /// Messages about output ports that did not show exactly this outcome in the last cycle: ports of other operations
    /// that are not zero, and numbers in another encoding.
    pub fn improper_outputs(&self, outcome: &Words) -> Vec<String> {
        let values = outcome.ports();
        let proper = |name: &str| {
            let value = values.iter().find(|value| value.name == name);
            value.map_or(0, |value| self.encoding.to_port(value.kind, value.bits))
        };
        let shown = self.outputs.iter().map(|(name, port)| (name, self.simulator.get(*port), proper(name)));
        let improper = shown.filter(|(_, bits, proper)| bits != proper);
        improper.map(|(name, bits, proper)| format!("{name}_o is {bits:x}, expected {proper:x}")).collect()
    }

    /// The outcome at the output ports in the last cycle; `None` if the opcode is unknown.
    pub fn outcome(&self) -> Option<Words> {
        let opcode = self.simulator.get(self.ports.opcode_out);
        let operation = self.operations.get(opcode as usize)?.as_ref()?;
        let word = |&(port, kind): &NetlistPort<OutputPort>| {
            port.map_or(0, |port| self.encoding.from_port(kind, self.simulator.get(port)))
        };
        let words: Vec<u64> = operation.outputs.iter().map(word).collect();
        Some(self.model.outcome_of_words(operation.kind, &words))
    }
}

impl Engine for NetlistEngine {
    fn present(&mut self, job: &Words) {
        let opcode = job.kind().opcode();
        self.simulator.set(self.ports.opcode, opcode);
        let Some(Some(operation)) = self.operations.get(opcode as usize) else { return };
        for (&(port, kind), &bits) in operation.inputs.iter().zip(job.as_words()) {
            if let Some(port) = port {
                self.simulator.set(port, self.encoding.to_port(kind, bits));
            }
        }
    }

    fn cycle(&mut self, input_valid: bool, output_ready: bool) -> Shown {
        let Handshake { input_ready, output_valid } = self.clock(input_valid, output_ready);
        Shown { input_ready, output: if output_valid { self.outcome() } else { None } }
    }

    fn reset(&mut self) {
        self.simulator.set_reset(true);
        self.simulator.cycle();
        self.simulator.set_reset(false);
    }
}
