use crate::engine::{Engine, PortEncoding, Shown, shape};
use raypath_hdl::{InputPort, Module, OutputPort, Simulator};
use raypath_model::{Functional, Model, OnPorts, Shape};
use raypath_ops::{JobKind, PortKind};
use raypath_rtl::{Config, Datapath};
use std::collections::HashMap;
use std::sync::Arc;

/// The netlist, simulated, as an engine.
pub struct NetlistEngine<M: Model = Functional> {
    model: M,
    simulator: Simulator,
    encoding: PortEncoding,
    shape: Shape,
    inputs: HashMap<String, InputPort>,
    /// All output ports but the handshake's.
    outputs: HashMap<String, OutputPort>,
    handshake: Handshake,
    /// The ports that each kind of outcome has.
    owned: [HashMap<String, PortKind>; JobKind::ALL.len()],
}

struct Handshake {
    input_valid: InputPort,
    output_ready: InputPort,
    opcode: InputPort,
    input_ready: OutputPort,
    output_valid: OutputPort,
    opcode_out: OutputPort,
}

impl<M: Model> NetlistEngine<M> {
    /// Elaborates a configuration and compiles its netlist. `model`, which is one for the configuration, only says what
    /// jobs and outcomes are. `observed` says by hierarchical name which of its signals will be looked at.
    ///
    /// # Errors
    /// A configuration that cannot be elaborated.
    pub fn new(model: M, config: Config, observed: impl Fn(&str) -> bool) -> Result<Self, raypath_rtl::Error> {
        Self::of(model, config, &Datapath::new(config)?, observed)
    }

    /// Compiles the netlist of a configuration that was elaborated before.
    ///
    /// # Errors
    /// A datapath that lacks one of the ports that all have.
    pub fn of(
        model: M,
        config: Config,
        datapath: &Datapath,
        observed: impl Fn(&str) -> bool,
    ) -> Result<Self, raypath_rtl::Error> {
        Self::over(model, config, shape(config, datapath), datapath.top(), observed)
    }

    /// Compiles any module that has the ports of a configuration's datapath and should behave as its cycle-exact model of
    /// this shape: the datapath with a fault, for one.
    ///
    /// # Errors
    /// A module that lacks one of the ports that all datapaths have.
    pub fn over(
        model: M,
        config: Config,
        shape: Shape,
        top: &Arc<Module>,
        observed: impl Fn(&str) -> bool,
    ) -> Result<Self, raypath_rtl::Error> {
        let simulator = Simulator::observing(top, observed)?;
        let mut inputs = HashMap::new();
        for port in top.inputs() {
            inputs.insert(port.stem().to_string(), simulator.input(&port.name)?);
        }
        let mut outputs = HashMap::new();
        let not_handshake = |stem: &str| !["input_ready", "output_valid", "opcode"].contains(&stem);
        for port in top.outputs().iter().filter(|port| not_handshake(port.stem())) {
            outputs.insert(port.stem().to_string(), simulator.output(&port.name)?);
        }
        let handshake = Handshake {
            input_valid: simulator.input("input_valid_i")?,
            output_ready: simulator.input("output_ready_i")?,
            opcode: simulator.input("opcode_i")?,
            input_ready: simulator.output("input_ready_o")?,
            output_valid: simulator.output("output_valid_o")?,
            opcode_out: simulator.output("opcode_o")?,
        };
        let owned = JobKind::ALL.map(|kind| {
            let ports = model.outcome(kind, |_| 0).ports().into_iter();
            ports.map(|port| (port.name, port.kind)).collect::<HashMap<_, _>>()
        });
        let encoding = PortEncoding::of(config);
        let mut engine = Self { model, simulator, encoding, shape, inputs, outputs, handshake, owned };
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

    /// The output ports that do not show what they should if this was the outcome in the last cycle, in words: ports of
    /// other modes are zero, and a number has one encoding only. Whether the outcome is right it does not say.
    pub fn improper_outputs(&self, outcome: &M::Outcome) -> Vec<String> {
        let values = outcome.ports().into_iter();
        let proper: HashMap<String, u64> =
            values.map(|value| (value.name.clone(), self.encoding.to_port(&value))).collect();
        let shown = self.outputs.iter().map(|(name, &port)| (name, self.simulator.get(port)));
        let mut improper: Vec<String> = shown
            .map(|(name, bits)| (name, bits, proper.get(name).copied().unwrap_or(0)))
            .filter(|(_, bits, proper)| bits != proper)
            .map(|(name, bits, proper)| format!("{name}_o is {bits:x}, expected {proper:x}"))
            .collect();
        improper.sort();
        improper
    }

    /// What the output ports show.
    fn outcome(&self) -> Option<M::Outcome> {
        let opcode = self.simulator.get(self.handshake.opcode_out);
        let kind = JobKind::ALL.into_iter().find(|kind| kind.opcode() == opcode)?;
        let owned = &self.owned[kind as usize];
        Some(self.model.outcome(kind, |name| match (self.outputs.get(name), owned.get(name)) {
            (Some(&port), Some(&kind)) => self.encoding.from_port(kind, self.simulator.get(port)),
            _ => 0,
        }))
    }
}

impl<M: Model> Engine<M> for NetlistEngine<M> {
    fn present(&mut self, job: &M::Job) {
        self.simulator.set(self.handshake.opcode, job.kind().opcode());
        for value in job.ports() {
            if let Some(&input) = self.inputs.get(&value.name) {
                self.simulator.set(input, self.encoding.to_port(&value));
            }
        }
    }

    fn cycle(&mut self, input_valid: bool, output_ready: bool) -> Shown<M::Outcome> {
        self.simulator.set(self.handshake.input_valid, input_valid.into());
        self.simulator.set(self.handshake.output_ready, output_ready.into());
        self.simulator.cycle();
        let valid = self.simulator.get(self.handshake.output_valid) == 1;
        let input_ready = self.simulator.get(self.handshake.input_ready) == 1;
        Shown { input_ready, output: if valid { self.outcome() } else { None } }
    }

    fn reset(&mut self) {
        self.simulator.set_reset(true);
        self.simulator.cycle();
        self.simulator.set_reset(false);
    }
}
