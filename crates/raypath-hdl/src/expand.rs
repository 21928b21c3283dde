//! Memories as registers, for proofs about all reachable states.

use crate::Error;
use crate::expose::Open;
use crate::netlist::{Driver, Item, MemoryInfo, Module, RegisterInfo, SignalId, remade};
use std::mem::replace;
use std::sync::Arc;

/// The most words of a memory that [`expand_memories`] accepts.
pub const MAX_EXPANDED_WORDS: u32 = 64;

/// `module` with a register for every word of every memory, in it and inside its instances, and multiplexers that read
/// them. It behaves the same in every cycle. The column `node` of a memory `u_stack` has the registers
/// `stack_node_0_q`, `stack_node_1_q` and so on.
///
/// # Errors
/// A memory of more than [`MAX_EXPANDED_WORDS`] words.
pub fn expand_memories(module: &Arc<Module>) -> Result<Arc<Module>, Error> {
    remade(module, |module, copy| {
        if module.memory_bits() == 0 {
            return Ok(module.clone());
        }
        let mut open = Open::new(copy);
        let items = std::mem::take(&mut open.module.items);
        (open.module.text.template, open.module.text.verbatim) = (None, None);
        let memories = std::mem::take(&mut open.module.memories);
        for item in items {
            match item {
                Item::Memory(memory) => open.expand(&memories[memory])?,
                other => open.module.items.push(other),
            }
        }
        Ok(Arc::new(open.module))
    })
}

impl Open {
    fn expand(&mut self, memory: &MemoryInfo) -> Result<(), Error> {
        if memory.depth > MAX_EXPANDED_WORDS {
            let problem = format!("depth {}, expected at most {MAX_EXPANDED_WORDS} for registers", memory.depth);
            return Err(Error::Width { module: self.module.name.clone(), signal: memory.name.clone(), problem });
        }
        let width = memory.address_width();
        let enables: Vec<SignalId> = (0..memory.depth)
            .map(|address| {
                let address = self.add(width, Driver::Constant(address.into()));
                let is_it = self.add(1, Driver::Equal(memory.write_address, address));
                self.add(1, Driver::And(memory.write_enable, is_it))
            })
            .collect();
        let bits: Vec<SignalId> =
            (0..width).map(|low| self.add(1, Driver::Slice { source: memory.read_address, low })).collect();
        for column in &memory.columns {
            let width = self.module.signal(column.read).width;
            let mut words = Vec::new();
            for (address, &enable) in enables.iter().enumerate() {
                let word = self.register(width, format!("{}_{}_{address}_q", memory.stem(), column.name));
                self.hold(word, Some(enable), column.written);
                words.push(word);
            }
            let zero = self.add(width, Driver::Constant(0));
            words.resize(1 << bits.len(), zero);
            for &select in &bits {
                let pairs = words.as_chunks::<2>().0.iter();
                words = pairs
                    .map(|&[if_false, if_true]| self.add(width, Driver::Mux { select, if_true, if_false }))
                    .collect();
            }
            let mut read = column.read;
            if memory.latency == 2 {
                let before = self.register(width, format!("{}_{}_before_output_q", memory.stem(), column.name));
                self.hold(replace(&mut read, before), None, before);
            }
            self.hold(read, Some(memory.read_enable), words[0]);
        }
        Ok(())
    }

    /// A signal of a register, which [`hold`](Self::hold) makes.
    fn register(&mut self, width: u32, name: String) -> SignalId {
        let signal = self.add(width, Driver::Input);
        self.module.signals[signal.index()].name = Some(self.fresh(name));
        signal
    }

    /// Drives `signal` by a new register.
    fn hold(&mut self, signal: SignalId, enable: Option<SignalId>, next: SignalId) {
        let register = self.module.registers.len();
        self.module.signals[signal.index()].driver = Driver::Register(register);
        self.module.registers.push(RegisterInfo { signal, next, enable, reset: None, gated: false });
        self.module.items.push(Item::Register(register));
    }
}
