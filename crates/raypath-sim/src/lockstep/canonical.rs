use crate::engine::{Engine, NetlistEngine, Shown};
use raypath_float::Format;
use raypath_hdl::Probe;
use raypath_model::Words;

/// A netlist as an engine that checks its number registers in every cycle: their recoded words must be canonical. The
/// ports do not show this, because units accept every encoding of a number.
pub struct WatchedNetlist<'n> {
    /// The first word that is not canonical, as a message.
    pub found: Option<String>,
    netlist: &'n mut NetlistEngine,
    format: Format,
    registers: Vec<Register>,
}

struct Register {
    name: String,
    probe: Probe,
    /// The last word, which was canonical.
    held: u64,
}

/// Whether the signal of this hierarchical name is a number register or an accumulator.
pub fn is_number_register(name: &str) -> bool {
    let name = name.rsplit('.').next().unwrap_or(name);
    name.starts_with("num_") && name.ends_with("_q") || name.ends_with("_state_q")
}

impl<'n> WatchedNetlist<'n> {
    /// Watches a netlist that was compiled with observable number registers. Registers of the recoded width of this
    /// format hold recoded words.
    pub fn new(netlist: &'n mut NetlistEngine, format: Format) -> Self {
        let probes = netlist.simulator().probes();
        let recoded = probes.filter(|(name, width, _)| is_number_register(name) && *width == format.recoded_width());
        let zero = format.encode(0);
        let registers =
            recoded.map(|(name, _, probe)| Register { name: name.to_string(), probe, held: zero }).collect();
        Self { found: None, netlist, format, registers }
    }

    /// The number of watched registers.
    pub fn registers(&self) -> usize {
        self.registers.len()
    }

    fn check_registers(&mut self) {
        for register in &mut self.registers {
            let word = self.netlist.simulator().peek(register.probe);
            if word == register.held {
                continue;
            }
            let canonical = self.format.encode(self.format.decode(word));
            if word != canonical {
                let name = &register.name;
                self.found = Some(format!("{name} holds {word:#x}, which is not canonical, expected {canonical:#x}"));
                return;
            }
            register.held = word;
        }
    }
}

impl Engine for WatchedNetlist<'_> {
    fn present(&mut self, job: &Words) {
        self.netlist.present(job);
    }

    fn cycle(&mut self, input_valid: bool, output_ready: bool) -> Shown {
        let shown = self.netlist.cycle(input_valid, output_ready);
        if self.found.is_none() {
            self.check_registers();
        }
        shown
    }

    fn reset(&mut self) {
        self.netlist.reset();
    }
}
