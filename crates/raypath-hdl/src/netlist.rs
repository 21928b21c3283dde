//! The netlist as data, which the printer prints and the simulators execute.

use crate::formula::Formula;
use crate::text::Text;
use std::collections::{BTreeSet, HashMap};
use std::convert::Infallible;
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
    /// What it holds: its name in the text, if it has no name and needs one.
    pub hint: Option<String>,
}

impl Signal {
    /// A signal without a name.
    pub(crate) fn unnamed(width: u32, driver: Driver) -> Self {
        Self { name: None, width, driver, comment: None, hint: None }
    }
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
    /// A column of the word that a memory has read last.
    Memory {
        /// Position in [`Module::memories`].
        memory: usize,
        /// Position in [`MemoryInfo::columns`].
        column: usize,
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
    /// Whether the text has a clock gate in place of the enable: an instance of
    /// [`CLOCK_GATE`](crate::verilog::CLOCK_GATE) for all such registers of the module with one enable. The register
    /// does the same.
    pub gated: bool,
}

/// A memory with one write port and one read port, both on the rising edge of `clk_i`. The text has an instance of
/// [`RAM`](crate::verilog::RAM).
///
/// At an edge where the read enable is 1, the columns take the word at the read address as it was before the edge: a
/// word that is written at the same edge shows its old value. Without the read enable the columns stay. With a latency
/// of 2, the columns are a register that shows all this a cycle later. No reset clears words or columns. Addresses of
/// `depth` or more must not occur; simulators read zero there and write nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct MemoryInfo {
    /// The name of its instance in the text.
    pub name: String,
    /// The number of words.
    pub depth: u32,
    /// The cycles of a read: 1, or 2 with an output register.
    pub latency: u32,
    /// One bit: a word is written.
    pub write_enable: SignalId,
    /// The address of the word that is written, of [`address_width`](Self::address_width) bits.
    pub write_address: SignalId,
    /// One bit: a word is read.
    pub read_enable: SignalId,
    /// The address of the word that is read.
    pub read_address: SignalId,
    /// The parts of a word, the most significant first.
    pub columns: Vec<Column>,
}

/// A part of the words of a memory, of 1 to 64 bits.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// The signal that is written.
    pub written: SignalId,
    /// The signal that holds what was read last.
    pub read: SignalId,
}

/// The fewest and the most words of a memory.
pub(crate) const DEPTHS: std::ops::RangeInclusive<u32> = 2..=1 << 16;

/// A method that lists the signals at the inputs of a memory: write enable, write address, read enable, read address,
/// and the columns that are written.
macro_rules! memory_inputs {
    ($name:ident, $iterate:ident, $($reference:tt)+) => {
        pub(crate) fn $name($($reference)+ self) -> Vec<$($reference)+ SignalId> {
            let Self { write_enable, write_address, read_enable, read_address, columns, .. } = self;
            let written = columns.$iterate().map(|Column { written, .. }| written);
            [write_enable, write_address, read_enable, read_address].into_iter().chain(written).collect()
        }
    };
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
                Self::Input
                | Self::Constant(_)
                | Self::Register(_)
                | Self::Instance { .. }
                | Self::Memory { .. } => Vec::new(),
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
    pub fn operands(&self) -> impl Iterator<Item = SignalId> {
        self.operand_references().into_iter().copied()
    }

    /// Whether it is wires alone.
    pub(crate) fn is_wiring(&self) -> bool {
        matches!(self, Self::Alias(_) | Self::Concat(_) | Self::Slice { .. })
    }

    /// Whether another driver is the same operator with the same parameters, whatever the operands are.
    pub fn has_operator_of(&self, other: &Self) -> bool {
        let [a, b] = [self, other].map(|driver| {
            let mut driver = driver.clone();
            driver.renumber(|_| SignalId(0));
            driver
        });
        a == b
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

impl RegisterInfo {
    /// Its own signal and those that it reads.
    pub(crate) fn signals_mut(&mut self) -> impl Iterator<Item = &mut SignalId> {
        [&mut self.signal, &mut self.next].into_iter().chain(&mut self.enable)
    }
}

impl MemoryInfo {
    memory_inputs!(inputs, iter, &);
    memory_inputs!(inputs_mut, iter_mut, &mut);

    /// The signals that it reads, and those of what it has read.
    pub(crate) fn signals_mut(&mut self) -> impl Iterator<Item = &mut SignalId> {
        let Self { write_enable, write_address, read_enable, read_address, columns, .. } = self;
        let columns = columns.iter_mut().flat_map(|column| [&mut column.written, &mut column.read]);
        [write_enable, write_address, read_enable, read_address].into_iter().chain(columns)
    }

    /// The width of its addresses in bits.
    pub fn address_width(&self) -> u32 {
        address_width(self.depth)
    }

    /// Its name without the usual prefix `u_`.
    pub fn stem(&self) -> &str {
        self.name.strip_prefix("u_").unwrap_or(&self.name)
    }

    /// The name of an input, by its position in [`inputs`](Self::inputs).
    pub(crate) fn input_name(&self, input: usize) -> String {
        match input {
            0 => "write_enable".to_string(),
            1 => "write_address".to_string(),
            2 => "read_enable".to_string(),
            3 => "read_address".to_string(),
            _ => format!("write_{}", self.columns[input - 4].name),
        }
    }
}

/// The width in bits of an address of `depth` words, at least 2.
pub(crate) fn address_width(depth: u32) -> u32 {
    u32::BITS - (depth - 1).leading_zeros()
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

/// The clock that the text has behind the gate for an enable of this name.
pub(crate) fn gated_clock(enable: &str) -> String {
    format!("clk_{enable}")
}

/// The instance of that gate.
pub(crate) fn gate_instance(enable: &str) -> String {
    format!("u_gate_{enable}")
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
    /// A memory.
    Memory(usize),
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
    pub(crate) memories: Vec<MemoryInfo>,
    pub(crate) instances: Vec<Instance>,
    pub(crate) items: Vec<Item>,
    pub(crate) text: Text,
}

/// What `make` makes of `top`. It gets a copy of each module in it, after those of its instances, with their modules as
/// they were made. Instances of the same module keep sharing it.
pub(crate) fn remade<E>(
    top: &Arc<Module>,
    mut make: impl FnMut(&Arc<Module>, Module) -> Result<Arc<Module>, E>,
) -> Result<Arc<Module>, E> {
    fn of<E>(
        module: &Arc<Module>,
        make: &mut impl FnMut(&Arc<Module>, Module) -> Result<Arc<Module>, E>,
        made: &mut HashMap<*const Module, Arc<Module>>,
    ) -> Result<Arc<Module>, E> {
        if let Some(known) = made.get(&Arc::as_ptr(module)) {
            return Ok(known.clone());
        }
        let mut copy = Module::clone(module);
        for instance in &mut copy.instances {
            instance.module = of(&instance.module, make, made)?;
        }
        let new = make(module, copy)?;
        made.insert(Arc::as_ptr(module), new.clone());
        Ok(new)
    }
    of(top, &mut make, &mut HashMap::new())
}

/// `top` with a change to every module in it.
pub(crate) fn changed(top: &Arc<Module>, change: impl Fn(&mut Module)) -> Arc<Module> {
    let Ok(new) = remade(top, |_, mut module| {
        change(&mut module);
        Ok::<_, Infallible>(Arc::new(module))
    });
    new
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
    /// registers, memories, instances and aliases.
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

    /// Memories in order of declaration.
    pub fn memories(&self) -> &[MemoryInfo] {
        &self.memories
    }

    /// Instances in order of declaration.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// The elements of its text, in order.
    pub fn items(&self) -> &[Item] {
        &self.items
    }

    /// The names of its ports, signals, memories and instances.
    pub(crate) fn names(&self) -> impl Iterator<Item = String> {
        let implied = ["clk_i", "rst_ni"].map(String::from);
        let ports = self.inputs.iter().chain(&self.outputs).map(|port| port.name.clone());
        let signals = self.signals.iter().filter_map(|signal| signal.name.clone());
        let instances = self.instances.iter().map(|instance| instance.name.clone());
        let memories = self.memories.iter().map(|memory| memory.name.clone());
        let unused = self.items.iter().filter_map(|item| match item {
            Item::Unused(name, _) => Some(name.clone()),
            _ => None,
        });
        let gates = self.gates().flat_map(|enable| [gated_clock(enable), gate_instance(enable)]);
        implied.into_iter().chain(ports).chain(signals).chain(instances).chain(memories).chain(unused).chain(gates)
    }

    /// The names of the enables that the text has clock gates for.
    pub(crate) fn gates(&self) -> impl Iterator<Item = &str> {
        let gated = self.registers.iter().filter(|register| register.gated);
        let enables: BTreeSet<SignalId> = gated.filter_map(|register| register.enable).collect();
        enables.into_iter().filter_map(|enable| self.signal(enable).name.as_deref())
    }

    /// The width of an input or output port of this name.
    pub fn port_width(&self, name: &str) -> Option<u32> {
        let port = self.inputs.iter().chain(&self.outputs).find(|p| p.name == name)?;
        Some(self.signal(port.signal).width)
    }

    /// Whether it, or anything inside it, has a register or a memory, and so a port `clk_i`.
    pub fn is_clocked(&self) -> bool {
        let own = !self.registers.is_empty() || !self.memories.is_empty();
        own || self.instances.iter().any(|i| i.module.is_clocked())
    }

    /// Whether it, or anything inside it, has a register with a reset, and so a port `rst_ni`.
    pub fn has_reset(&self) -> bool {
        self.registers.iter().any(|r| r.reset.is_some()) || self.instances.iter().any(|i| i.module.has_reset())
    }

    /// Bits of the words of memories in it and everything inside it.
    pub fn memory_bits(&self) -> u64 {
        let width = |column: &Column| u64::from(self.signal(column.read).width);
        let bits = |memory: &MemoryInfo| u64::from(memory.depth) * memory.columns.iter().map(width).sum::<u64>();
        self.memories.iter().map(bits).sum::<u64>() + self.instances.iter().map(|i| i.module.memory_bits()).sum::<u64>()
    }

    /// Register bits in it and everything inside it, without memories.
    pub fn register_bits(&self) -> u64 {
        let own: u64 = self.registers.iter().map(|r| u64::from(self.signal(r.signal).width)).sum();
        own + self.instances.iter().map(|i| i.module.register_bits()).sum::<u64>()
    }
}
