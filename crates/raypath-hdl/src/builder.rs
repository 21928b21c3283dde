//! Building modules with operators on wires.
//!
//! The builder keeps the first error (a width, a name, a register without a next value), and [`Builder::finish`]
//! returns it. Descriptions therefore need no `?` at every operator.

pub(crate) mod memory;
mod simplify;
mod text;
mod wire;

use crate::Error;
use crate::formula::Formula;
use crate::names;
use crate::netlist::{Arm, Driver, Instance, Item, Label, Module, Port, RegisterInfo, Signal, SignalId, fits};
use crate::text::Text;
use simplify::Simplified;
use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;
pub use wire::{Forward, Register, Wire};

/// A module under construction.
pub struct Builder {
    state: RefCell<State>,
}

struct State {
    module: Module,
    names: HashSet<String>,
    /// Labels used so far: name, width of the selector, value.
    labels: HashMap<String, (u32, u64)>,
    /// What still lacks a driver.
    undriven: Vec<Undriven>,
    error: Option<Error>,
}

/// What must be driven once.
#[derive(PartialEq)]
enum Undriven {
    /// A register or a forward wire.
    Signal(SignalId),
    /// A port of a memory, by name.
    Port(String),
}

impl Builder {
    /// Begins a module. `name` must be an identifier.
    pub fn new(name: &str) -> Self {
        let module = Module {
            name: name.to_string(),
            doc: Vec::new(),
            signals: Vec::new(),
            inputs: Vec::new(),
            outputs: Vec::new(),
            registers: Vec::new(),
            memories: Vec::new(),
            instances: Vec::new(),
            items: Vec::new(),
            text: Text::default(),
        };
        let names = ["clk_i", "rst_ni"].map(String::from).into();
        let (labels, undriven) = (HashMap::new(), Vec::new());
        let builder = Self { state: RefCell::new(State { module, names, labels, undriven, error: None }) };
        if let Some(problem) = names::problem(name) {
            builder.fail_name(name, problem);
        }
        builder
    }

    /// Adds a line to the module's head comment.
    pub fn doc(&self, line: impl Into<String>) {
        self.state.borrow_mut().module.doc.push(line.into());
    }

    /// Adds a comment above the statements that follow.
    pub fn section(&self, title: impl Into<String>) {
        self.item(Item::Section(title.into()));
    }

    /// An input port.
    pub fn input(&self, name: &str, width: u32) -> Wire<'_> {
        let wire = self.declare(name, width, Driver::Input);
        self.state.borrow_mut().module.inputs.push(Port { name: name.to_string(), signal: wire.id });
        wire
    }

    /// An output port that shows `wire`.
    pub fn output(&self, name: &str, wire: Wire<'_>) {
        self.claim(name);
        let signal = self.own(wire);
        self.state.borrow_mut().module.outputs.push(Port { name: name.to_string(), signal });
    }

    /// A constant of `width` bits; an error where `value` needs more.
    pub fn constant(&self, width: u32, value: u64) -> Wire<'_> {
        let wire = self.push(width, Driver::Constant(value));
        self.expect_fits(wire, width, value);
        wire
    }

    /// A register of this name; by convention it ends in `_q`. Give it a next value.
    pub fn register(&self, name: &str, width: u32) -> Register<'_> {
        let index = self.state.borrow().module.registers.len();
        let wire = self.declare(name, width, Driver::Register(index));
        let mut state = self.state.borrow_mut();
        state.module.registers.push(RegisterInfo {
            signal: wire.id,
            next: wire.id,
            enable: None,
            reset: None,
            gated: false,
        });
        state.module.items.push(Item::Register(index));
        state.undriven.push(Undriven::Signal(wire.id));
        Register { wire, index }
    }

    /// A wire that is driven later.
    pub fn forward(&self, name: &str, width: u32) -> Forward<'_> {
        let Forward { wire } = self.forward_unnamed(width);
        self.claim(name);
        self.name(wire, name);
        self.item(Item::Signal(wire.id));
        Forward { wire }
    }

    /// A wire that is driven later. It takes the name of its driver.
    pub fn forward_unnamed(&self, width: u32) -> Forward<'_> {
        let wire = self.push(width, Driver::Constant(0));
        let mut state = self.state.borrow_mut();
        // An alias of itself until it is driven: a constant would be simplified.
        state.module.signals[wire.id.index()].driver = Driver::Alias(wire.id);
        state.undriven.push(Undriven::Signal(wire.id));
        Forward { wire }
    }

    /// A named constant of `width` bits, which the text declares with its formula. A second call with the same name and
    /// value returns the same constant.
    pub fn parameter(&self, name: &str, width: u32, formula: impl Into<Formula>) -> Wire<'_> {
        let formula = formula.into();
        if let Some(known) = self.named_constant(name, formula.value()) {
            return known;
        }
        let wire = self.declare(name, width, Driver::Constant(formula.value()));
        self.expect_fits(wire, width, formula.value());
        self.item(Item::Parameter(wire.id, formula));
        wire
    }

    /// Concatenation, most significant part first.
    pub fn concat(&self, parts: &[Wire<'_>]) -> Wire<'_> {
        match parts {
            [one] => Wire { builder: self, id: self.own(*one) },
            _ => {
                let width = parts.iter().fold(0, |sum: u32, part| sum.saturating_add(part.width()));
                self.push_simplified(width, Driver::Concat(self.own_all(parts)))
            }
        }
    }

    /// The value of the arm whose label equals `selector`, else `default`.
    pub fn case(&self, selector: Wire<'_>, arms: &[(Label, Wire<'_>)], default: Wire<'_>) -> Wire<'_> {
        let driver = Driver::Case {
            selector: self.own(selector),
            arms: arms.iter().map(|(label, wire)| Arm { label: label.clone(), value: self.own(*wire) }).collect(),
            default: self.own(default),
        };
        let result = self.push(default.width(), driver);
        for (place, (label, wire)) in arms.iter().enumerate() {
            self.expect_width(result.id, wire.width(), default.width());
            if !fits(selector.width(), label.value) {
                self.fail_width(result.id, format!("label {} does not fit the selector", label.name));
            }
            if arms[..place].iter().any(|(other, _)| other.value == label.value) {
                self.fail_width(result.id, format!("label {} appears twice", label.name));
            }
            self.claim_label(label, selector.width());
        }
        result
    }

    /// An instance of `module` with its inputs by port name; returns its outputs in order of declaration, named
    /// `<instance without u_>_<port without _o>`.
    pub fn instance(&self, name: &str, module: &Arc<Module>, inputs: &[(&str, Wire<'_>)]) -> Vec<Wire<'_>> {
        self.claim(name);
        let mut connected = Vec::new();
        for port in module.inputs() {
            match inputs.iter().find(|(given, _)| *given == port.name) {
                Some((_, wire)) => {
                    self.expect_port(name, &port.name, wire.width(), module.signal(port.signal).width);
                    connected.push(self.own(*wire));
                }
                None => self.fail_drive(&format!("{name}.{}", port.name), "is never driven"),
            }
        }
        for (place, (given, _)) in inputs.iter().enumerate() {
            if inputs[..place].iter().any(|(other, _)| other == given) {
                self.fail_drive(&format!("{name}.{given}"), "is driven twice");
            }
            if module.inputs().iter().all(|p| p.name != *given) {
                self.fail_name(given, &format!("is not an input of {}", module.name()));
            }
        }
        let index = self.state.borrow().module.instances.len();
        let mut instance =
            Instance { name: name.to_string(), module: module.clone(), inputs: connected, outputs: Vec::new() };
        let declare = |(output, port): (usize, &Port)| {
            let driver = Driver::Instance { instance: index, output };
            self.declare(&instance.output_name(output), module.signal(port.signal).width, driver)
        };
        let outputs: Vec<Wire<'_>> = module.outputs().iter().enumerate().map(declare).collect();
        instance.outputs = self.own_all(&outputs);
        self.state.borrow_mut().module.instances.push(instance);
        self.item(Item::Instance(index));
        outputs
    }

    /// Marks signals that have no reader by intention. `name` must begin with `unused_`.
    pub fn unused(&self, name: &str, wires: &[Wire<'_>]) {
        self.claim(name);
        if !name.starts_with("unused_") {
            self.fail_name(name, "must begin with unused_");
        }
        self.item(Item::Unused(name.to_string(), self.own_all(wires)));
    }

    /// Makes the final checks and returns the module, or the first error.
    pub fn finish(self) -> Result<Arc<Module>, Error> {
        let state = self.state.into_inner();
        if let Some(error) = state.error {
            return Err(error);
        }
        if let Some(undriven) = state.undriven.first() {
            return Err(Error::Drive {
                signal: undriven.describe(&state.module),
                module: state.module.name,
                problem: "is never driven".to_string(),
            });
        }
        state.module.expect_payload_only()?;
        Ok(Arc::new(state.module))
    }

    /// A signal with this driver or a simpler one of the same value.
    fn push_simplified(&self, width: u32, driver: Driver) -> Wire<'_> {
        match self.simplify(width, driver) {
            Simplified::Signal(id) => Wire { builder: self, id },
            Simplified::Driver(driver) => self.push(width, driver),
        }
    }

    fn push(&self, width: u32, driver: Driver) -> Wire<'_> {
        let mut state = self.state.borrow_mut();
        let id = SignalId(state.module.signals.len() as u32);
        state.module.signals.push(Signal::unnamed(width, driver));
        drop(state);
        if !(1..=64).contains(&width) {
            self.fail_width(id, format!("width {width}, expected 1 to 64"));
            self.state.borrow_mut().module.signals[id.index()].width = width.clamp(1, 64);
        }
        Wire { builder: self, id }
    }

    /// A named signal that no expression drives.
    fn declare(&self, name: &str, width: u32, driver: Driver) -> Wire<'_> {
        self.claim(name);
        let wire = self.push(width, driver);
        self.name(wire, name);
        wire
    }

    fn name(&self, wire: Wire<'_>, name: &str) {
        self.state.borrow_mut().module.signals[wire.id.index()].name = Some(name.to_string());
    }

    /// The constant that already has this name and value.
    fn named_constant(&self, name: &str, value: u64) -> Option<Wire<'_>> {
        let signals = &self.state.borrow().module.signals;
        let is_same =
            |signal: &Signal| signal.name.as_deref() == Some(name) && signal.driver == Driver::Constant(value);
        let id = SignalId(signals.iter().position(is_same)? as u32);
        Some(Wire { builder: self, id })
    }

    fn claim(&self, name: &str) {
        if let Some(problem) = names::problem(name) {
            self.fail_name(name, problem);
        }
        if !self.state.borrow_mut().names.insert(name.to_string()) {
            self.fail_name(name, "is taken");
        }
    }

    /// A label may be used again with the same value and width.
    fn claim_label(&self, label: &Label, width: u32) {
        let known = self.state.borrow().labels.get(&label.name).copied();
        match known {
            None => {
                self.claim(&label.name);
                self.state.borrow_mut().labels.insert(label.name.clone(), (width, label.value));
            }
            Some(known) if known == (width, label.value) => {}
            Some((w, v)) => {
                self.fail_name(&label.name, &format!("labels both {w}'d{v} and {width}'d{}", label.value));
            }
        }
    }

    /// The id of an operand. All operands are checked here, because the id of a signal of another module would refer to
    /// some signal of this module.
    fn own(&self, wire: Wire<'_>) -> SignalId {
        if std::ptr::eq(self, wire.builder) {
            return wire.id;
        }
        let signal = describe(&wire.builder.state.borrow().module, wire.id);
        self.fail_drive(&signal, "belongs to another module");
        SignalId(0)
    }

    fn own_all(&self, wires: &[Wire<'_>]) -> Vec<SignalId> {
        wires.iter().map(|&wire| self.own(wire)).collect()
    }

    fn item(&self, item: Item) {
        self.state.borrow_mut().module.items.push(item);
    }

    fn drive(&self, driven: Undriven) {
        let mut state = self.state.borrow_mut();
        match state.undriven.iter().position(|undriven| *undriven == driven) {
            Some(place) => {
                state.undriven.remove(place);
            }
            None => {
                let signal = driven.describe(&state.module);
                drop(state);
                self.fail_drive(&signal, "is driven twice");
            }
        }
    }

    fn expect_width(&self, id: SignalId, found: u32, expected: u32) {
        if found != expected {
            self.fail_width(id, format!("operand of {found} bits, expected {expected}"));
        }
    }

    fn expect_fits(&self, constant: Wire<'_>, width: u32, value: u64) {
        if !fits(constant.width(), value) {
            self.fail_width(constant.id, format!("constant {value} does not fit {width} bits"));
        }
    }

    fn expect_port(&self, instance: &str, port: &str, found: u32, expected: u32) {
        if found != expected {
            let problem = format!("connected to {found} bits, expected {expected}");
            self.fail_width_of(format!("{instance}.{port}"), problem);
        }
    }

    fn fail_width(&self, id: SignalId, problem: String) {
        let signal = describe(&self.state.borrow().module, id);
        self.fail_width_of(signal, problem);
    }

    fn fail_width_of(&self, signal: String, problem: String) {
        self.fail(|module| Error::Width { module, signal, problem });
    }

    fn fail_name(&self, name: &str, problem: &str) {
        self.fail(|module| Error::Name { module, name: name.to_string(), problem: problem.to_string() });
    }

    fn fail_drive(&self, signal: &str, problem: &str) {
        self.fail(|module| Error::Drive { module, signal: signal.to_string(), problem: problem.to_string() });
    }

    /// Keeps the error in the module of this name, if it is the first.
    fn fail(&self, error: impl FnOnce(String) -> Error) {
        let mut state = self.state.borrow_mut();
        let error = error(state.module.name.clone());
        state.error.get_or_insert(error);
    }
}

impl Undriven {
    fn describe(&self, module: &Module) -> String {
        match self {
            Self::Signal(id) => describe(module, *id),
            Self::Port(name) => name.clone(),
        }
    }
}

/// A signal's name, or its operator and number where it has none.
pub(crate) fn describe(module: &Module, id: SignalId) -> String {
    let signal = &module.signals[id.index()];
    signal.name.clone().unwrap_or_else(|| {
        let driver = format!("{:?}", signal.driver);
        let operator = driver.split(['(', ' ']).next().unwrap_or_default();
        format!("{operator} {}", id.0)
    })
}
