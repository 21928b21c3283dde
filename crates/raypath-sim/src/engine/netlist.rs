use crate::engine::{Engine, PortEncoding, Shown, shape};
use raypath_hdl::{InputPort, Module, OutputPort, Simulator};
use raypath_model::{OperationId, Shape, WordModel, Words};
use raypath_ops::{Port, PortKind};
use raypath_rtl::{Config, Datapath};
use std::sync::Arc;

/// The netlist, simulated, as an engine.
pub struct NetlistEngine {
    model: WordModel,
    simulator: Simulator,
    encoding: PortEncoding,
    shape: Shape,
    /// The ports of each operation, by opcode.
    operations: Vec<Option<OperationPorts>>,
    /// All of them, by name.
    names: Vec<(String, OutputPort)>,
    ports: HandshakePorts,
}

/// What the handshake's ports showed in the last cycle, before its clock edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Handshake {
    /// `input_ready_o`.
    pub input_ready: bool,
    /// `output_valid_o`.
    pub output_valid: bool,
}

/// A port, if there is one, and what its bits mean.
type Place<P> = (Option<P>, PortKind);

/// The ports of one operation.
struct OperationPorts {
    kind: OperationId,
    /// Those of its jobs, in the order of their words; those that the configuration lacks are `None`.
    inputs: Vec<Place<InputPort>>,
    /// The same of outcomes.
    outputs: Vec<Place<OutputPort>>,
    /// The output ports, but the handshake's, that its outcomes do not have.
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
    /// Elaborates a configuration and compiles its netlist. `model`, which is one for the configuration, only says what
    /// jobs and outcomes are. `observed` says by hierarchical name which of its signals will be looked at.
    ///
    /// # Errors
    /// A configuration that cannot be elaborated.
    pub fn new(model: WordModel, config: Config, observed: impl Fn(&str) -> bool) -> Result<Self, raypath_rtl::Error> {
        Self::of(model, config, &Datapath::new(config)?, observed)
    }

    /// Compiles the netlist of a configuration that was elaborated before.
    ///
    /// # Errors
    /// A datapath that lacks one of the ports that all have.
    pub fn of(
        model: WordModel,
        config: Config,
        datapath: &Datapath,
        observed: impl Fn(&str) -> bool,
    ) -> Result<Self, raypath_rtl::Error> {
        Self::of_module(model, config, datapath.top(), shape(config, datapath), observed)
    }

    /// Compiles a module that has a datapath's ports, and should behave as one of this shape does.
    ///
    /// # Errors
    /// A module that lacks one of the ports that all datapaths have.
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
        let mut names = Vec::new();
        let not_handshake = |stem: &str| !["input_ready", "output_valid", "opcode"].contains(&stem);
        for port in top.outputs().iter().filter(|port| not_handshake(port.stem())) {
            names.push((port.stem().to_string(), simulator.output(&port.name)?));
        }
        names.sort_by(|a, b| a.0.cmp(&b.0));
        let output = |port: &Port| names.iter().find(|(name, _)| *name == port.name).map(|(_, output)| *output);
        let input = |port: &Port| simulator.input(&format!("{}_i", port.name)).ok();
        let mut operations = Vec::new();
        for kind in model.kinds() {
            let (job, outcome) = (model.inputs(kind), model.outputs(kind));
            let inputs = job.iter().map(|port| (input(port), port.kind)).collect();
            let outputs: Vec<Place<OutputPort>> = outcome.iter().map(|port| (output(port), port.kind)).collect();
            let is_own = |output: &OutputPort| outputs.iter().any(|(own, _)| *own == Some(*output));
            let foreign = names.iter().map(|(_, output)| *output).filter(|output| !is_own(output)).collect();
            let opcode = kind.opcode() as usize;
            operations.resize_with(operations.len().max(opcode + 1), || None);
            operations[opcode] = Some(OperationPorts { kind, inputs, outputs, foreign });
        }
        let encoding = PortEncoding::of(config);
        let mut engine = Self { model, simulator, encoding, shape, operations, names, ports };
        engine.reset();
        Ok(engine)
    }

    /// The simulator inside, for waveforms.
    pub fn simulator(&self) -> &Simulator {
        &self.simulator
    }

    /// How its cycle-exact model is shaped.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Begins again as a new engine does: unlike [`reset`](Engine::reset) this forgets the data registers too.
    pub fn restart(&mut self) {
        self.simulator.restart();
        self.reset();
    }

    /// What [`Engine::cycle`] does, without a look at the outcome: what [`shows`](Self::shows) is for.
    pub fn clock(&mut self, input_valid: bool, output_ready: bool) -> Handshake {
        self.simulator.set(self.ports.input_valid, input_valid.into());
        self.simulator.set(self.ports.output_ready, output_ready.into());
        self.simulator.cycle();
        self.handshake()
    }

    /// What the handshake's ports showed in the last cycle, or in the last one of a reset.
    pub fn handshake(&self) -> Handshake {
        let is_set = |port| self.simulator.get(port) == 1;
        Handshake { input_ready: is_set(self.ports.input_ready), output_valid: is_set(self.ports.output_valid) }
    }

    /// Whether the output ports, all of them, showed this outcome in the last cycle, as they should: ports of other
    /// modes are zero, and a number has one encoding only.
    pub fn shows(&self, outcome: &Words) -> bool {
        let (opcode, simulator, encoding) = (outcome.kind().opcode(), &self.simulator, self.encoding);
        let Some(Some(operation)) = self.operations.get(opcode as usize) else { return false };
        let places = operation.outputs.iter().zip(outcome.as_words());
        simulator.get(self.ports.opcode_out) == opcode
            && places
                .into_iter()
                .all(|(&(port, of), &bits)| port.is_none_or(|port| simulator.get(port) == encoding.to_port(of, bits)))
            && operation.foreign.iter().all(|&port| simulator.get(port) == 0)
    }

    /// The output ports that do not show what they should if this was the outcome in the last cycle, in words: ports of
    /// other modes are zero, and a number has one encoding only. Whether the outcome is right it does not say.
    pub fn improper_outputs(&self, outcome: &Words) -> Vec<String> {
        let values = outcome.ports();
        let proper = |name: &str| {
            let value = values.iter().find(|value| value.name == name);
            value.map_or(0, |value| self.encoding.to_port(value.kind, value.bits))
        };
        let shown = self.names.iter().map(|(name, port)| (name, self.simulator.get(*port), proper(name)));
        let improper = shown.filter(|(_, bits, proper)| bits != proper);
        improper.map(|(name, bits, proper)| format!("{name}_o is {bits:x}, expected {proper:x}")).collect()
    }

    /// What the output ports showed in the last cycle; `None` where the opcode is none.
    pub fn outcome(&self) -> Option<Words> {
        let opcode = self.simulator.get(self.ports.opcode_out);
        let operation = self.operations.get(opcode as usize)?.as_ref()?;
        let word = |&(port, kind): &Place<OutputPort>| {
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
