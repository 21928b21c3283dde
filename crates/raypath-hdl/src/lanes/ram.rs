//! The words of memories in lanes. Each lane has its own addresses, so a clock edge takes one lane after the other.

use super::transpose::{LANES, Slice, from_slices, to_slices};
use crate::netlist::mask;
use crate::ram::Random;
use std::ops::Range;

/// A memory of all lanes.
pub struct LaneMemory {
    depth: usize,
    /// The places of the bits at each input, in the order of [`MemoryInfo::inputs`](crate::MemoryInfo).
    inputs: Vec<Vec<u32>>,
    /// The places of the registers that show what was read.
    columns: Vec<Range<u32>>,
    /// By lane, then address, then column.
    words: Vec<u64>,
}

impl LaneMemory {
    /// A memory with all words 0.
    pub fn new(depth: u32, inputs: Vec<Vec<u32>>, columns: Vec<Range<u32>>) -> Self {
        let depth = depth as usize;
        let words = vec![0; LANES * depth * columns.len()];
        Self { depth, inputs, columns, words }
    }

    /// A clock edge in every lane: reads into registers, then writes. The places of the inputs still have the values
    /// from before the edge.
    #[inline(always)]
    pub fn edge(&mut self, memory: &mut [Slice]) {
        let [write_enable, write_address, read_enable, read_address] =
            std::array::from_fn(|input| self.input(memory, input));
        let size = self.columns.len();
        let first = |lane: usize, address: u64| (lane * self.depth + address as usize) * size;
        if read_enable != [0; LANES] {
            let enable = memory[self.inputs[2][0] as usize];
            for (place, column) in self.columns.iter().enumerate() {
                let is_word = |lane: usize| (read_address[lane] as usize) < self.depth;
                let read = |lane: usize| self.words[first(lane, read_address[lane]) + place];
                let values = std::array::from_fn(|lane| if is_word(lane) { read(lane) } else { 0 });
                let mut slices = [Slice::ZEROS; u64::BITS as usize];
                let slices = &mut slices[..column.len()];
                to_slices(&values, slices);
                for (shown, read) in memory[column.start as usize..column.end as usize].iter_mut().zip(slices) {
                    let words = std::array::from_fn(|word| {
                        let enable = enable.0[word];
                        enable & read.0[word] | !enable & shown.0[word]
                    });
                    *shown = Slice(words);
                }
            }
        }
        if write_enable != [0; LANES] {
            let is_written: [bool; LANES] =
                std::array::from_fn(|lane| write_enable[lane] == 1 && (write_address[lane] as usize) < self.depth);
            for place in 0..size {
                let values = self.input(memory, 4 + place);
                for lane in (0..LANES).filter(|&lane| is_written[lane]) {
                    self.words[(lane * self.depth + write_address[lane] as usize) * size + place] = values[lane];
                }
            }
        }
    }

    /// Sets all words to 0.
    pub fn clear(&mut self) {
        self.words.fill(0);
    }

    /// Fills all words of each lane with random values.
    pub fn fill(&mut self, random: &mut [Random; LANES]) {
        let lanes = self.words.chunks_mut(self.depth * self.columns.len());
        for (words, random) in lanes.zip(random) {
            for (word, column) in words.iter_mut().zip(self.columns.iter().cycle()) {
                *word = random.word() & mask(column.len() as u32);
            }
        }
    }

    #[inline(always)]
    fn input(&self, memory: &[Slice], input: usize) -> [u64; LANES] {
        let places = &self.inputs[input];
        let mut slices = [Slice::ZEROS; u64::BITS as usize];
        for (slice, &place) in slices.iter_mut().zip(places) {
            *slice = memory[place as usize];
        }
        from_slices(&slices[..places.len()])
    }
}
