//! The netlist as data, which the printer prints and the simulators execute.

use crate::formula::Formula;
use crate::text::Text;
use std::sync::Arc;

/// A signal of one module, by position in [`Module::signals`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SignalId(pub u32);

impl SignalId {
    /// The position in [`Module::signals`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A word of `width` bits (1 to 64) and what drives it.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// Its name in the output; a signal without one is an expression inside its reader, if it has one reader only.
    pub name: Option<String>,
    /// Its width in bits.
    pub width: u32,
    /// What drives it.
    pub driver: Driver,
    /// A comment that is printed beside the declaration.
    pub comment: Option<String>,
}

/// What drives a signal. Operands of `And` to `Sub`, of comparisons and of multiplexers have equal widths; nothing is
/// extended or truncated silently.
#[derive(Debug, Clone, PartialEq)]
pub enum Driver {
    /// An input port of the module.
    Input,
    /// A constant.
    Constant(u64),
    /// Bitwise not.
    Not(SignalId),
    /// Bitwise and.
    And(SignalId, SignalId),
    /// Bitwise or.
    Or(SignalId, SignalId),
    /// Bitwise exclusive or.
    Xor(SignalId, SignalId),
    /// Sum modulo 2^width.
    Add(SignalId, SignalId),
    /// Difference modulo 2^width.
    Sub(SignalId, SignalId),
    /// Unsigned product, as wide as both factors together.
    Mul(SignalId, SignalId),
    /// One bit: the operands are equal.
    Equal(SignalId, SignalId),
    /// One bit: the first operand is less than the second, unsigned.
    Less(SignalId, SignalId),
    /// One bit: any bit is set.
    Any(SignalId),
    /// One bit: every bit is set.
    All(SignalId),
    /// Shift left by a signal; zeros enter, and an amount of the width or more gives zero.
    ShiftLeft(SignalId, SignalId),
    /// Shift right by a signal; zeros enter, and an amount of the width or more gives zero.
    ShiftRight(SignalId, SignalId),
    /// `select ? if_true : if_false`.
    Mux {
        /// One bit.
        select: SignalId,
        /// Taken where `select` is 1.
        if_true: SignalId,
        /// Taken where `select` is 0.
        if_false: SignalId,
    },
    /// The value of the arm whose label equals the selector, else the default. Labels are distinct.
    Case {
        /// The word that is compared with the labels.
        selector: SignalId,
        /// Labels and values.
        arms: Vec<Arm>,
        /// The value where no label matches.
        default: SignalId,
    },
    /// Concatenation, most significant part first.
    Concat(Vec<SignalId>),
    /// Bits `low` to `low + width - 1` of a signal.
    Slice {
        /// The signal cut from.
        source: SignalId,
        /// The least significant bit taken.
        low: u32,
    },
    /// Another signal under a second name.
    Alias(SignalId),
    /// The register with this position in [`Module::registers`].
    Register(usize),
    /// An output port (by position among the instantiated module's outputs) of an instance.
    Instance {
        /// Position in [`Module::instances`].
        instance: usize,
        /// Position in the instantiated module's [`Module::outputs`].
        output: usize,
    },
}

/// One arm of a [`Driver::Case`].
#[derive(Debug, Clone, PartialEq)]
pub struct Arm {
    /// The value of the selector that selects the arm.
    pub label: Label,
    /// The value.
    pub value: SignalId,
}

/// A named constant, such as an opcode.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Label {
    /// An identifier, declared as a `localparam` where it is used.
    pub name: String,
    /// Its value.
    pub value: u64,
}

/// A port of a module. `clk_i` and `rst_ni` are implied ([`Module::is_clocked`], [`Module::has_reset`]).
#[derive(Debug, Clone, PartialEq)]
pub struct Port {
    /// Its name, direction suffix included.
    pub name: String,
    /// The signal that it is (input) or that drives it (output).
    pub signal: SignalId,
}

/// A register on the rising edge of `clk_i`.
#[derive(Debug, Clone, PartialEq)]
pub struct RegisterInfo {
    /// The signal that holds its value.
    pub signal: SignalId,
    /// The signal that it loads at the edge.
    pub next: SignalId,
    /// If present, it loads `next` only in cycles in which this one-bit signal is 1.
    pub enable: Option<SignalId>,
    /// Its value while `rst_ni` is 0 (asynchronous). Data registers have no reset value.
    pub reset: Option<u64>,
}

/// A module inside another.
#[derive(Debug, Clone)]
pub struct Instance {
    /// Its name, unique in the parent.
    pub name: String,
    /// The instantiated module.
    pub module: Arc<Module>,
    /// The parent's signals at the module's inputs, in the order of [`Module::inputs`].
    pub inputs: Vec<SignalId>,
    /// The parent's signals at the module's outputs, in the order of [`Module::outputs`].
    pub outputs: Vec<SignalId>,
}

/// A method that lists the operands of a driver, by reference or by mutable reference.
macro_rules! operands {
    ($name:ident, $iterate:ident, $($reference:tt)+) => {
        fn $name($($reference)+ self) -> Vec<$($reference)+ SignalId> {
            match self {
                Self::Input | Self::Constant(_) | Self::Register(_) | Self::Instance { .. } => Vec::new(),
                Self::Not(a) | Self::Any(a) | Self::All(a) | Self::Alias(a) | Self::Slice { source: a, .. } => vec![a],
                Self::And(a, b)
                | Self::Or(a, b)
                | Self::Xor(a, b)
                | Self::Add(a, b)
                | Self::Sub(a, b)
                | Self::Mul(a, b)
                | Self::Equal(a, b)
                | Self::Less(a, b)
                | Self::ShiftLeft(a, b)
                | Self::ShiftRight(a, b) => vec![a, b],
                Self::Mux { select, if_true, if_false } => vec![select, if_true, if_false],
                Self::Case { selector, arms, default } => {
                    let values = arms.$iterate().map(|Arm { value, .. }| value);
                    [selector].into_iter().chain(values).chain([default]).collect()
                }
                Self::Concat(parts) => parts.$iterate().collect(),
            }
        }
    };
}

impl Driver {
    operands!(operand_references, iter, &);
    operands!(operands_mut, iter_mut, &mut);

    /// The signals that it reads within the cycle and within the module.
    pub(crate) fn operands(&self) -> impl Iterator<Item = SignalId> {
        self.operand_references().into_iter().copied()
    }

    /// Replaces every operand.
    pub(crate) fn renumber(&mut self, new: impl Fn(SignalId) -> SignalId) {
        self.operands_mut().into_iter().for_each(|operand| *operand = new(*operand));
    }
}

impl Port {
    /// Its name without the usual suffix of its direction, `_i` or `_o`.
    pub fn stem(&self) -> &str {
        self.name.strip_suffix("_i").or_else(|| self.name.strip_suffix("_o")).unwrap_or(&self.name)
    }
}

impl Instance {
    /// Its name without the usual prefix `u_`. Names of signals at its ports begin with it.
    pub fn stem(&self) -> &str {
        self.name.strip_prefix("u_").unwrap_or(&self.name)
    }

    /// The name for an unnamed signal at this input, by position.
    pub(crate) fn input_name(&self, input: usize) -> String {
        let port = &self.module.inputs[input].name;
        format!("{}_{}", self.stem(), port.strip_suffix("_i").unwrap_or(port))
    }

    /// The name of the signal at this output, by position.
    pub(crate) fn output_name(&self, output: usize) -> String {
        let port = &self.module.outputs[output].name;
        format!("{}_{}", self.stem(), port.strip_suffix("_o").unwrap_or(port))
    }
}

/// The largest word of `width` bits, 1 to 64.
pub(crate) fn mask(width: u32) -> u64 {
    u64::MAX >> (64 - width)
}

/// Whether a word of `width` bits, 1 to 64, can hold `value`.
pub(crate) fn fits(width: u32, value: u64) -> bool {
    value <= mask(width)
}

/// An element of the printed text. They are in the order of building.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// A comment above the elements that follow.
    Section(String),
    /// A named signal that an expression drives.
    Signal(SignalId),
    /// An instance.
    Instance(usize),
    /// A register.
    Register(usize),
    /// Signals without a reader, under one name that begins with `unused_`.
    Unused(String, Vec<SignalId>),
    /// A named constant, and the formula of its value.
    Parameter(SignalId, Formula),
}

/// A finished module: widths are checked, every signal is driven, and names are unique. Only [`crate::Builder`] makes
/// one.
#[derive(Debug, Clone)]
pub struct Module {
    pub(crate) name: String,
    pub(crate) doc: Vec<String>,
    pub(crate) signals: Vec<Signal>,
    pub(crate) inputs: Vec<Port>,
    pub(crate) outputs: Vec<Port>,
    pub(crate) registers: Vec<RegisterInfo>,
    pub(crate) instances: Vec<Instance>,
    pub(crate) items: Vec<Item>,
    pub(crate) text: Text,
}

impl Module {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The lines of its head comment.
    pub fn doc(&self) -> &[String] {
        &self.doc
    }

    /// All signals; a [`SignalId`] is a position in here. Operands come before what they drive, except through
    /// registers, instances and aliases.
    pub fn signals(&self) -> &[Signal] {
        &self.signals
    }

    /// One signal.
    pub fn signal(&self, id: SignalId) -> &Signal {
        &self.signals[id.index()]
    }

    /// Input ports in order of declaration.
    pub fn inputs(&self) -> &[Port] {
        &self.inputs
    }

    /// Output ports in order of declaration.
    pub fn outputs(&self) -> &[Port] {
        &self.outputs
    }

    /// Registers in order of declaration.
    pub fn registers(&self) -> &[RegisterInfo] {
        &self.registers
    }

    /// Instances in order of declaration.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// The elements of its text, in order.
    pub fn items(&self) -> &[Item] {
        &self.items
    }

    /// The names of its ports, signals and instances.
    pub(crate) fn names(&self) -> impl Iterator<Item = String> {
        let implied = ["clk_i", "rst_ni"].map(String::from);
        let ports = self.inputs.iter().chain(&self.outputs).map(|port| port.name.clone());
        let signals = self.signals.iter().filter_map(|signal| signal.name.clone());
        let instances = self.instances.iter().map(|instance| instance.name.clone());
        let unused = self.items.iter().filter_map(|item| match item {
            Item::Unused(name, _) => Some(name.clone()),
            _ => None,
        });
        implied.into_iter().chain(ports).chain(signals).chain(instances).chain(unused)
    }

    /// The width of an input or output port of this name.
    pub fn port_width(&self, name: &str) -> Option<u32> {
        let port = self.inputs.iter().chain(&self.outputs).find(|p| p.name == name)?;
        Some(self.signal(port.signal).width)
    }

    /// Whether it, or anything inside it, has a register, and so a port `clk_i`.
    pub fn is_clocked(&self) -> bool {
        !self.registers.is_empty() || self.instances.iter().any(|i| i.module.is_clocked())
    }

    /// Whether it, or anything inside it, has a register with a reset, and so a port `rst_ni`.
    pub fn has_reset(&self) -> bool {
        self.registers.iter().any(|r| r.reset.is_some()) || self.instances.iter().any(|i| i.module.has_reset())
    }

    /// Register bits in it and everything inside it.
    pub fn register_bits(&self) -> u64 {
        let own: u64 = self.registers.iter().map(|r| u64::from(self.signal(r.signal).width)).sum();
        own + self.instances.iter().map(|i| i.module.register_bits()).sum::<u64>()
    }
}
