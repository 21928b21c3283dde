//! The words of memories during simulation.

use crate::flatten::Flat;
use crate::netlist::{MemoryInfo, SignalId, mask};
use std::collections::HashMap;

/// A memory of a [`Simulator`](crate::Simulator). Its state is only changed at clock edges.
pub struct SimulatedMemory {
    depth: u64,
    /// With a latency of 2: the word before the output register.
    before_output: Option<Vec<u64>>,
    /// The slots of write enable, write address, read enable and read address.
    ports: [usize; 4],
    columns: Vec<Column>,
    /// By address, then by column.
    pub words: Vec<u64>,
}

struct Column {
    /// The slot of what is written.
    written: usize,
    /// The register that shows what was read, and its node and width.
    register: usize,
    read: SignalId,
    width: u32,
}

impl SimulatedMemory {
    /// The memory with these ports, all words 0; the signals at its inputs have these slots.
    pub fn new(flat: &Flat, info: &MemoryInfo, slots: &HashMap<SignalId, usize>) -> Self {
        let column = |column: &crate::Column| {
            let (read, width) = (column.read, flat.nodes[column.read.index()].width);
            Some(Column { written: slots[&column.written], register: flat.register(read)?, read, width })
        };
        let columns: Vec<Column> = info.columns.iter().filter_map(column).collect();
        let ports = [info.write_enable, info.write_address, info.read_enable, info.read_address];
        let words = vec![0; info.depth as usize * columns.len()];
        let before_output = (info.latency == 2).then(|| vec![0; columns.len()]);
        Self { depth: info.depth.into(), before_output, ports: ports.map(|id| slots[&id]), columns, words }
    }

    /// The position in `words` of the column that is read at this node.
    pub fn place(&self, read: SignalId, address: u32) -> usize {
        let column = self.columns.iter().position(|column| column.read == read);
        address as usize * self.columns.len() + column.unwrap_or(0)
    }

    /// A clock edge: reads into the next values of registers, then writes.
    pub fn edge(&mut self, io: &[u64], next: &mut [u64]) {
        let [write_enable, write_address, read_enable, read_address] = self.ports.map(|slot| io[slot]);
        let size = self.columns.len();
        let first = read_address as usize * size;
        let word = (0..size).map(|place| self.words.get(first + place).copied().unwrap_or(0));
        let registers = self.columns.iter().map(|column| column.register);
        if let Some(before) = &mut self.before_output {
            registers.zip(&*before).for_each(|(register, word)| next[register] = *word);
            if read_enable == 1 {
                before.clear();
                before.extend(word);
            }
        } else if read_enable == 1 {
            registers.zip(word).for_each(|(register, word)| next[register] = word);
        }
        if write_enable == 1 && write_address < self.depth {
            let first = write_address as usize * size;
            for (word, column) in self.words[first..first + size].iter_mut().zip(&self.columns) {
                *word = io[column.written];
            }
        }
    }

    /// Sets all words to 0.
    pub fn clear(&mut self) {
        self.words.fill(0);
        self.before_output.iter_mut().for_each(|word| word.fill(0));
    }

    /// Fills all words with random values.
    pub fn fill(&mut self, random: &mut Random) {
        let widths = self.columns.iter().map(|column| column.width).cycle();
        let words = self.words.iter_mut().chain(self.before_output.iter_mut().flatten());
        for (word, width) in words.zip(widths) {
            *word = random.word() & mask(width);
        }
    }
}

/// A generator of random initial values: SplitMix64 (Steele, Lea and Flood 2014).
pub struct Random(pub u64);

impl Random {
    /// 64 random bits.
    pub fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }
}
