//! Mutation of netlists: small faults like those of a design error or a defective gate.
//!
//! A test that passes on a faulty module does not detect the fault. [`faults`] lists the faults of a module,
//! [`Fault::apply`] makes the faulty module, and [`replace`] replaces the original by it.

mod edit;
mod list;
mod well_formed;

use crate::Error;
use crate::builder::describe;
use crate::netlist::{Driver, Module, SignalId, remade};
use std::fmt;
use std::sync::Arc;

/// One change to one module. Its ports stay the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    module: String,
    /// A description of the change.
    place: String,
    /// How, in words.
    how: String,
    change: Change,
}

/// The change. Signals are those of the module without the fault.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Change {
    /// The signal has another driver, of the same width.
    Driver { signal: SignalId, was: Driver, becomes: Driver, how: &'static str },
    /// The signal has the complement of its value.
    Inverted { signal: SignalId },
    /// The signal reads something else instead of an operand: its complement, zero, ones, or another signal of the same
    /// width.
    Operand { signal: SignalId, operand: SignalId, becomes: Driver },
    /// The signal, a shift, is shifted by one more.
    ShiftedMore { signal: SignalId },
    /// The register takes its next value in every cycle.
    AlwaysLoads { register: usize },
    /// The register never takes a next value.
    NeverLoads { register: usize },
    /// The register has another value after reset.
    Reset { register: usize, was: u64, becomes: u64 },
    /// The register, which has a reset, keeps its value in it.
    NoReset { register: usize },
    /// An instance reads zero or ones at an input port.
    PortConstant { instance: usize, input: usize, value: u64 },
    /// Two inputs of an instance are exchanged.
    PortsExchanged { instance: usize, inputs: [usize; 2] },
    /// Two outputs of an instance are exchanged.
    OutputsExchanged { instance: usize, outputs: [usize; 2] },
    /// An input of a memory has these bits only.
    MemoryMasked { memory: usize, input: usize, mask: u64 },
    /// An enable of a memory is always 1.
    MemoryAlways { memory: usize, input: usize },
    /// Two inputs of a memory are exchanged.
    MemoryExchanged { memory: usize, inputs: [usize; 2] },
}

/// The faults of a module itself, not of those that it instantiates, in the order of its signals. Dead signals, and
/// changes that obviously keep the function, have no faults.
///
/// Faults are: `And` for `Or` and the reverse, `Or` for `Xor`, `Sub` for `Add` and the reverse; comparisons, `Any`,
/// `All` and names inverted, `Less` with its operands exchanged, `Any` for `All` and the reverse; multiplexers with an
/// inverted select, or stuck at one side; arms of a `Case` exchanged with the next, left out, or taken by default;
/// constants one more, one less, or with one bit flipped; slices one bit higher or lower; the other shift; neighbours
/// of a `Concat` exchanged where they are as wide as each other; `Not` left out; a shift by one more; any operand
/// replaced by zero, by ones, or by the nearest earlier signal of its width; registers that load always or never, or
/// have another reset value or none; ports of instances at zero or ones, and exchanged with the next of their width;
/// enables of memories stuck at 0 or 1, each bit of an address and each written column at zero, and addresses and
/// neighbouring columns of equal widths exchanged.
pub fn faults(module: &Module) -> Vec<Fault> {
    list::faults(module)
}

impl Fault {
    /// The name of the module that it changes.
    pub fn module(&self) -> &str {
        &self.module
    }

    /// The number of an instance and of two of its inputs, if the fault exchanges these.
    pub fn exchanged_inputs(&self) -> Option<(usize, [usize; 2])> {
        match self.change {
            Change::PortsExchanged { instance, inputs } => Some((instance, inputs)),
            _ => None,
        }
    }

    /// The module with this fault.
    ///
    /// # Errors
    /// The module has another name, or has changed since the fault was listed.
    pub fn apply(&self, module: &Module) -> Result<Module, Error> {
        if module.name() != self.module {
            let problem = format!("is not the module of the fault '{self}'");
            return Err(Error::Name { module: self.module.clone(), name: module.name().to_string(), problem });
        }
        let changed = edit::changed(module, &self.change).ok_or_else(|| Error::Drive {
            module: self.module.clone(),
            signal: self.place.clone(),
            problem: "is not what it was when the fault was listed".to_string(),
        })?;
        well_formed::check(&changed)?;
        Ok(changed)
    }
}

/// The module, the place in it, and the change: `raypath_skid, spare_valid_q: resets to 1 instead of 0`.
impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {}: {}", self.module, self.place, self.how)
    }
}

impl Change {
    /// The change in words, operands by the names that they have in `module`.
    fn words(&self, module: &Module) -> String {
        match self {
            Self::Driver { how, .. } => how.to_string(),
            Self::Inverted { .. } => "inverted".to_string(),
            Self::Operand { operand, becomes, .. } => {
                let operand = describe(module, *operand);
                match becomes {
                    Driver::Not(_) => format!("{operand} inverted"),
                    Driver::Constant(0) => format!("{operand} replaced by zero"),
                    Driver::Alias(with) => format!("reads {} instead of {operand}", describe(module, *with)),
                    _ => format!("{operand} stuck at 1"),
                }
            }
            Self::ShiftedMore { .. } => "shifts by one more".to_string(),
            Self::NoReset { .. } => "does not reset".to_string(),
            Self::PortsExchanged { instance, inputs: [_, other] } => {
                format!("exchanged with {}", module.instances[*instance].module.inputs[*other].name)
            }
            Self::OutputsExchanged { instance, outputs: [_, other] } => {
                format!("exchanged with {}", module.instances[*instance].module.outputs[*other].name)
            }
            Self::AlwaysLoads { .. } => "loads in every cycle".to_string(),
            Self::NeverLoads { .. } => "never loads".to_string(),
            Self::Reset { was, becomes, .. } => format!("resets to {becomes} instead of {was}"),
            Self::PortConstant { value: 0, .. } | Self::MemoryMasked { mask: 0, .. } => "replaced by zero".to_string(),
            Self::MemoryMasked { mask, .. } => format!("bit {} stuck at 0", mask.trailing_ones()),
            Self::PortConstant { .. } | Self::MemoryAlways { .. } => "stuck at 1".to_string(),
            Self::MemoryExchanged { memory, inputs: [_, other] } => {
                format!("exchanged with {}", module.memories[*memory].input_name(*other))
            }
        }
    }
}

/// `top` with `new` instead of every module of its name. Modules that contain none of them stay shared.
///
/// # Errors
/// Ports that are not those of the module that is replaced, or no module of this name.
pub fn replace(top: &Arc<Module>, new: &Arc<Module>) -> Result<Arc<Module>, Error> {
    let mut is_found = false;
    let replaced = remade(top, |old, module| {
        if old.name() == new.name() {
            is_found = true;
            return same_ports(old, new).map(|()| new.clone());
        }
        let mut instances = old.instances.iter().zip(&module.instances);
        let is_same = instances.all(|(before, after)| Arc::ptr_eq(&before.module, &after.module));
        Ok(if is_same { old.clone() } else { Arc::new(module) })
    })?;
    if is_found {
        Ok(replaced)
    } else {
        let problem = "is the name of no module in it".to_string();
        Err(Error::Name { module: top.name().to_string(), name: new.name().to_string(), problem })
    }
}

fn same_ports(old: &Module, new: &Module) -> Result<(), Error> {
    let ports = |module: &Module| {
        let ports = module.inputs.iter().chain(&module.outputs);
        ports.map(|port| (port.name.clone(), module.signal(port.signal).width)).collect::<Vec<_>>()
    };
    let clocks = |module: &Module| (module.is_clocked(), module.has_reset(), module.inputs.len());
    if ports(old) == ports(new) && clocks(old) == clocks(new) {
        return Ok(());
    }
    let problem = "has other ports than the module that it replaces".to_string();
    Err(Error::Name { module: old.name().to_string(), name: new.name().to_string(), problem })
}
