//! Building modules: arithmetic on wires reads as arithmetic.
//!
//! The first thing that does not fit (a width, a name, a register without a next value) is kept and returned by
//! [`Builder::finish`]; until then building goes on, so that descriptions need no `?` at every operator.

use crate::Error;
use crate::names;
use crate::netlist::{Arm, Driver, Instance, Item, Label, Module, Port, RegisterInfo, Signal, SignalId};
use std::cell::RefCell;
use std::collections::HashSet;
use std::ops::{Add, BitAnd, BitOr, BitXor, Mul, Not, Sub};
use std::sync::Arc;

/// A module under construction.
pub struct Builder {
    state: RefCell<State>,
}

struct State {
    module: Module,
    names: HashSet<String>,
    /// Registers and forward wires that still lack a driver.
    undriven: Vec<SignalId>,
    error: Option<Error>,
}

/// A signal of the module that `Builder` builds: a small copyable handle with operators.
#[derive(Clone, Copy)]
pub struct Wire<'m> {
    builder: &'m Builder,
    id: SignalId,
}

/// A register whose next value is still to be given.
#[derive(Clone, Copy)]
pub struct Register<'m> {
    wire: Wire<'m>,
    index: usize,
}

/// A wire that is read before it is driven, for paths that run backwards.
#[derive(Clone, Copy)]
pub struct Forward<'m> {
    wire: Wire<'m>,
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
            instances: Vec::new(),
            items: Vec::new(),
        };
        let names = ["clk_i", "rst_ni"].map(String::from).into();
        let builder = Self { state: RefCell::new(State { module, names, undriven: Vec::new(), error: None }) };
        if let Some(problem) = names::problem(name) {
            builder.fail_name(name, problem);
        }
        builder
    }

    /// Adds a line to the module's head comment.
    pub fn doc(&self, line: impl Into<String>) {
        self.state.borrow_mut().module.doc.push(line.into());
    }

    /// Puts a comment over what is built next.
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
        self.state.borrow_mut().module.outputs.push(Port { name: name.to_string(), signal: wire.id });
    }

    /// A constant of `width` bits; an error where `value` needs more.
    pub fn constant(&self, width: u32, value: u64) -> Wire<'_> {
        let wire = self.push(width, Driver::Constant(value));
        if width < 64 && value >> width != 0 {
            self.fail_width(wire.id, format!("constant {value} does not fit {width} bits"));
        }
        wire
    }

    /// A register of this name; by convention it ends in `_q`. Give it a next value.
    pub fn register(&self, name: &str, width: u32) -> Register<'_> {
        let index = self.state.borrow().module.registers.len();
        let wire = self.declare(name, width, Driver::Register(index));
        let mut state = self.state.borrow_mut();
        state.module.registers.push(RegisterInfo { signal: wire.id, next: wire.id, enable: None, reset: None });
        state.module.items.push(Item::Register(index));
        state.undriven.push(wire.id);
        Register { wire, index }
    }

    /// A wire that is driven later.
    pub fn forward(&self, name: &str, width: u32) -> Forward<'_> {
        let wire = self.declare(name, width, Driver::Constant(0));
        let mut state = self.state.borrow_mut();
        state.undriven.push(wire.id);
        state.module.items.push(Item::Signal(wire.id));
        Forward { wire }
    }

    /// Concatenation, most significant part first.
    pub fn concat(&self, parts: &[Wire<'_>]) -> Wire<'_> {
        match parts {
            [one] => Wire { builder: self, id: one.id },
            _ => self.push(parts.iter().map(|p| p.width()).sum(), Driver::Concat(ids(parts))),
        }
    }

    /// The value of the arm whose label equals `selector`, else `default`.
    pub fn case(&self, selector: Wire<'_>, arms: &[(Label, Wire<'_>)], default: Wire<'_>) -> Wire<'_> {
        let driver = Driver::Case {
            selector: selector.id,
            arms: arms.iter().map(|(label, wire)| Arm { label: label.clone(), value: wire.id }).collect(),
            default: default.id,
        };
        let result = self.push(default.width(), driver);
        for (place, (label, wire)) in arms.iter().enumerate() {
            self.expect_width(result.id, wire.width(), default.width());
            if selector.width() < 64 && label.value >> selector.width() != 0 {
                self.fail_width(result.id, format!("label {} does not fit the selector", label.name));
            }
            if arms[..place].iter().any(|(other, _)| other.value == label.value) {
                self.fail_width(result.id, format!("label {} appears twice", label.name));
            }
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
                    connected.push(wire.id);
                }
                None => self.fail_drive(&format!("{name}.{}", port.name), "is never driven"),
            }
        }
        for (place, (given, _)) in inputs.iter().enumerate() {
            if inputs[..place].iter().any(|(other, _)| other == given) {
                self.fail_drive(&format!("{name}.{given}"), "is driven twice");
            }
            if module.inputs().iter().all(|p| p.name != *given) {
                self.fail_name(given, &format!("is no input of {}", module.name()));
            }
        }
        let instance = self.state.borrow().module.instances.len();
        let prefix = name.strip_prefix("u_").unwrap_or(name);
        let outputs: Vec<Wire<'_>> = module
            .outputs()
            .iter()
            .enumerate()
            .map(|(output, port)| {
                let stem = port.name.strip_suffix("_o").unwrap_or(&port.name);
                let width = module.signal(port.signal).width;
                self.declare(&format!("{prefix}_{stem}"), width, Driver::Instance { instance, output })
            })
            .collect();
        let mut state = self.state.borrow_mut();
        state.module.instances.push(Instance {
            name: name.to_string(),
            module: module.clone(),
            inputs: connected,
            outputs: ids(&outputs),
        });
        state.module.items.push(Item::Instance(instance));
        drop(state);
        outputs
    }

    /// Says that nobody reads these signals, on purpose. `name` must begin with `unused_`.
    pub fn unused(&self, name: &str, wires: &[Wire<'_>]) {
        self.claim(name);
        if !name.starts_with("unused_") {
            self.fail_name(name, "must begin with unused_");
        }
        self.item(Item::Unused(name.to_string(), ids(wires)));
    }

    /// Checks what is left to check and gives the module, or the first thing that was wrong.
    pub fn finish(self) -> Result<Arc<Module>, Error> {
        let state = self.state.into_inner();
        if let Some(error) = state.error {
            return Err(error);
        }
        if let Some(&id) = state.undriven.first() {
            return Err(Error::Drive {
                signal: describe(&state.module, id),
                module: state.module.name,
                problem: "is never driven".to_string(),
            });
        }
        Ok(Arc::new(state.module))
    }

    fn push(&self, width: u32, driver: Driver) -> Wire<'_> {
        let mut state = self.state.borrow_mut();
        let id = SignalId(state.module.signals.len() as u32);
        state.module.signals.push(Signal { name: None, width, driver, comment: None });
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
        self.state.borrow_mut().module.signals[wire.id.index()].name = Some(name.to_string());
        wire
    }

    fn claim(&self, name: &str) {
        if let Some(problem) = names::problem(name) {
            self.fail_name(name, problem);
        }
        if !self.state.borrow_mut().names.insert(name.to_string()) {
            self.fail_name(name, "is taken");
        }
    }

    fn item(&self, item: Item) {
        self.state.borrow_mut().module.items.push(item);
    }

    fn drive(&self, id: SignalId) {
        let mut state = self.state.borrow_mut();
        match state.undriven.iter().position(|&u| u == id) {
            Some(place) => {
                state.undriven.remove(place);
            }
            None => {
                let signal = describe(&state.module, id);
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

    fn expect_port(&self, instance: &str, port: &str, found: u32, expected: u32) {
        if found != expected {
            let module = self.state.borrow().module.name.clone();
            self.fail(Error::Width {
                module,
                signal: format!("{instance}.{port}"),
                problem: format!("connected to {found} bits, expected {expected}"),
            });
        }
    }

    fn fail_width(&self, id: SignalId, problem: String) {
        let (module, signal) = {
            let state = self.state.borrow();
            (state.module.name.clone(), describe(&state.module, id))
        };
        self.fail(Error::Width { module, signal, problem });
    }

    fn fail_name(&self, name: &str, problem: &str) {
        let module = self.state.borrow().module.name.clone();
        self.fail(Error::Name { module, name: name.to_string(), problem: problem.to_string() });
    }

    fn fail_drive(&self, signal: &str, problem: &str) {
        let module = self.state.borrow().module.name.clone();
        self.fail(Error::Drive { module, signal: signal.to_string(), problem: problem.to_string() });
    }

    fn fail(&self, error: Error) {
        self.state.borrow_mut().error.get_or_insert(error);
    }
}

impl<'m> Wire<'m> {
    /// The builder of the module that it belongs to.
    pub fn builder(self) -> &'m Builder {
        self.builder
    }

    /// Its width in bits.
    pub fn width(self) -> u32 {
        self.builder.state.borrow().module.signals[self.id.index()].width
    }

    /// The same value under a name that survives into the output.
    pub fn named(self, name: &str) -> Self {
        self.builder.claim(name);
        let taken = self.builder.state.borrow().module.signals[self.id.index()].name.is_some();
        let wire = if taken { self.builder.push(self.width(), Driver::Alias(self.id)) } else { self };
        let mut state = self.builder.state.borrow_mut();
        state.module.signals[wire.id.index()].name = Some(name.to_string());
        state.module.items.push(Item::Signal(wire.id));
        drop(state);
        wire
    }

    /// Adds a remark for the reader of the output.
    pub fn comment(self, remark: impl Into<String>) -> Self {
        self.builder.state.borrow_mut().module.signals[self.id.index()].comment = Some(remark.into());
        self
    }

    /// One bit of it.
    pub fn bit(self, index: u32) -> Self {
        self.bits(index, index)
    }

    /// Bits `high` down to `low`, both included.
    pub fn bits(self, high: u32, low: u32) -> Self {
        let width = self.width();
        if low == 0 && high + 1 == width {
            return self;
        }
        if high < low || high >= width {
            self.builder.fail_width(self.id, format!("bits [{high}:{low}] of {width}"));
            return self;
        }
        self.builder.push(high - low + 1, Driver::Slice { source: self.id, low })
    }

    /// Its most significant bit.
    pub fn top(self) -> Self {
        self.bit(self.width() - 1)
    }

    /// Its `n` most significant bits.
    pub fn upper(self, n: u32) -> Self {
        let width = self.width();
        if n == 0 || n > width {
            self.builder.fail_width(self.id, format!("{n} upper bits of {width}"));
            return self;
        }
        self.bits(width - 1, width - n)
    }

    /// Its `n` least significant bits.
    pub fn lower(self, n: u32) -> Self {
        if n == 0 {
            self.builder.fail_width(self.id, "no lower bits".to_string());
            return self;
        }
        self.bits(n - 1, 0)
    }

    /// Extended with zeros to `width` bits.
    pub fn extend(self, width: u32) -> Self {
        let own = self.width();
        if width < own {
            self.builder.fail_width(self.id, format!("{own} bits extended to {width}"));
        }
        if width <= own { self } else { self.builder.concat(&[self.builder.constant(width - own, 0), self]) }
    }

    /// One bit: equal to `other`.
    pub fn equals(self, other: Self) -> Self {
        self.compare(other, Driver::Equal(self.id, other.id))
    }

    /// One bit: equal to a constant.
    pub fn is(self, value: u64) -> Self {
        self.equals(self.builder.constant(self.width(), value))
    }

    /// One bit: less than `other`, unsigned.
    pub fn less(self, other: Self) -> Self {
        self.compare(other, Driver::Less(self.id, other.id))
    }

    /// One bit: any bit is set.
    pub fn any(self) -> Self {
        if self.width() == 1 { self } else { self.builder.push(1, Driver::Any(self.id)) }
    }

    /// One bit: every bit is set.
    pub fn all(self) -> Self {
        if self.width() == 1 { self } else { self.builder.push(1, Driver::All(self.id)) }
    }

    /// Shifted left by `amount`; zeros enter.
    pub fn shift_left(self, amount: Self) -> Self {
        self.builder.push(self.width(), Driver::ShiftLeft(self.id, amount.id))
    }

    /// Shifted right by `amount`; zeros enter.
    pub fn shift_right(self, amount: Self) -> Self {
        self.builder.push(self.width(), Driver::ShiftRight(self.id, amount.id))
    }

    /// `self ? if_true : if_false`; `self` has one bit.
    pub fn mux(self, if_true: Self, if_false: Self) -> Self {
        let driver = Driver::Mux { select: self.id, if_true: if_true.id, if_false: if_false.id };
        let wire = self.builder.push(if_true.width(), driver);
        self.builder.expect_width(wire.id, self.width(), 1);
        self.builder.expect_width(wire.id, if_false.width(), if_true.width());
        wire
    }

    /// `width` copies of this one bit.
    pub fn replicate(self, width: u32) -> Self {
        self.builder.expect_width(self.id, self.width(), 1);
        self.builder.concat(&vec![self; width as usize])
    }

    fn compare(self, other: Self, driver: Driver) -> Self {
        let wire = self.builder.push(1, driver);
        self.builder.expect_width(wire.id, other.width(), self.width());
        wire
    }

    fn same_width(self, other: Self, driver: Driver) -> Self {
        let wire = self.builder.push(self.width(), driver);
        self.builder.expect_width(wire.id, other.width(), self.width());
        wire
    }
}

impl<'m> Register<'m> {
    /// Its value.
    pub fn wire(self) -> Wire<'m> {
        self.wire
    }

    /// Gives it a value that it has while `rst_ni` is 0.
    pub fn reset_to(self, value: u64) -> Self {
        self.info(|info| info.reset = Some(value));
        if self.wire.width() < 64 && value >> self.wire.width() != 0 {
            self.wire.builder.fail_width(self.wire.id, format!("reset value {value} does not fit"));
        }
        self
    }

    /// Takes `next` at every edge.
    pub fn next(self, next: Wire<'m>) {
        self.wire.builder.drive(self.wire.id);
        self.wire.builder.expect_width(self.wire.id, next.width(), self.wire.width());
        self.info(|info| info.next = next.id);
    }

    /// Takes `next` at edges where `enable` is 1.
    pub fn next_when(self, enable: Wire<'m>, next: Wire<'m>) {
        self.next(next);
        self.wire.builder.expect_width(self.wire.id, enable.width(), 1);
        self.info(|info| info.enable = Some(enable.id));
    }

    fn info(self, change: impl FnOnce(&mut RegisterInfo)) {
        change(&mut self.wire.builder.state.borrow_mut().module.registers[self.index]);
    }
}

impl<'m> Forward<'m> {
    /// Its value.
    pub fn wire(self) -> Wire<'m> {
        self.wire
    }

    /// Drives it.
    pub fn drive(self, wire: Wire<'m>) {
        self.wire.builder.drive(self.wire.id);
        self.wire.builder.expect_width(self.wire.id, wire.width(), self.wire.width());
        self.wire.builder.state.borrow_mut().module.signals[self.wire.id.index()].driver = Driver::Alias(wire.id);
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl<'m> $trait for Wire<'m> {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                self.same_width(other, Driver::$trait(self.id, other.id))
            }
        }
    };
    ($trait:ident, $method:ident, $driver:ident) => {
        impl<'m> $trait for Wire<'m> {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                self.same_width(other, Driver::$driver(self.id, other.id))
            }
        }
    };
}

operator!(Add, add);
operator!(Sub, sub);
operator!(BitAnd, bitand, And);
operator!(BitOr, bitor, Or);
operator!(BitXor, bitxor, Xor);

/// Unsigned; the product is as wide as both factors together.
impl Mul for Wire<'_> {
    type Output = Self;
    #[expect(clippy::suspicious_arithmetic_impl, reason = "the widths add up")]
    fn mul(self, other: Self) -> Self {
        self.builder.push(self.width() + other.width(), Driver::Mul(self.id, other.id))
    }
}

impl Not for Wire<'_> {
    type Output = Self;
    fn not(self) -> Self {
        self.builder.push(self.width(), Driver::Not(self.id))
    }
}

fn ids(wires: &[Wire<'_>]) -> Vec<SignalId> {
    wires.iter().map(|w| w.id).collect()
}

fn describe(module: &Module, id: SignalId) -> String {
    let signal = &module.signals[id.index()];
    signal.name.clone().unwrap_or_else(|| {
        let driver = format!("{:?}", signal.driver);
        let operator = driver.split(['(', ' ']).next().unwrap_or_default();
        format!("{operator} {}", id.0)
    })
}
