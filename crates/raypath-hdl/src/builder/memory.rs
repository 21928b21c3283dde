//! Memories with one write port and one read port.

use super::{Builder, Undriven, Wire};
use crate::netlist::{Column, DEPTHS, Driver, Item, MemoryInfo, SignalId, address_width};

/// A memory whose ports are still to be connected. [`MemoryInfo`] defines what it does.
#[derive(Clone, Copy)]
pub struct Memory<'m> {
    builder: &'m Builder,
    index: usize,
}

impl Builder {
    /// A memory of `depth` words, 2 to 65,536, as an instance `name`. A word consists of `columns`, by name and width,
    /// the most significant first. Connect both ports with [`Memory::write`] and [`Memory::read`].
    pub fn memory(&self, name: &str, depth: u32, columns: &[(&str, u32)]) -> Memory<'_> {
        self.claim(name);
        if !DEPTHS.contains(&depth) {
            self.fail_width_of(
                name.to_string(),
                format!("depth {depth}, expected {} to {}", DEPTHS.start(), DEPTHS.end()),
            );
        }
        if columns.is_empty() {
            self.fail_width_of(name.to_string(), "no columns, expected at least one".to_string());
        }
        let index = self.state.borrow().module.memories.len();
        let none = SignalId(0);
        let mut memory = MemoryInfo {
            name: name.to_string(),
            depth: depth.clamp(*DEPTHS.start(), *DEPTHS.end()),
            latency: 1,
            write_enable: none,
            write_address: none,
            read_enable: none,
            read_address: none,
            columns: Vec::new(),
        };
        for (column, (title, width)) in columns.iter().enumerate() {
            let driver = Driver::Memory { memory: index, column };
            let read = self.declare(&format!("{}_{title}", memory.stem()), *width, driver).id;
            memory.columns.push(Column { name: title.to_string(), written: none, read });
        }
        let mut state = self.state.borrow_mut();
        state.undriven.extend(["write", "read"].map(|port| Undriven::Port(format!("{name}.{port}"))));
        state.module.memories.push(memory);
        Memory { builder: self, index }
    }
}

impl<'m> Memory<'m> {
    /// The same memory with a read of 1 or 2 cycles; with 2, it has an output register. Without this, a read takes 1.
    #[must_use]
    pub fn latency(self, cycles: u32) -> Self {
        if !(1..=2).contains(&cycles) {
            let name = self.info(|info| info.name.clone());
            self.builder.fail_width_of(name, format!("read latency {cycles}, expected 1 or 2"));
        }
        self.info(|info| info.latency = cycles.clamp(1, 2));
        self
    }

    /// The columns of the word that was read last, named `<memory without u_>_<column>`.
    pub fn columns(self) -> Vec<Wire<'m>> {
        let columns = self.info(|info| info.columns.iter().map(|column| column.read).collect::<Vec<_>>());
        columns.into_iter().map(|id| Wire { builder: self.builder, id }).collect()
    }

    /// Writes a word, a wire for each column, at edges where `enable` is 1.
    pub fn write(self, enable: Wire<'m>, address: Wire<'m>, word: &[Wire<'m>]) {
        self.connect("write", enable, address);
        let (name, columns) = self.info(|info| (info.name.clone(), info.columns.clone()));
        if word.len() != columns.len() {
            let problem = format!("{} columns written, expected {}", word.len(), columns.len());
            return self.builder.fail_width_of(format!("{name}.write"), problem);
        }
        for (column, wire) in columns.iter().zip(word) {
            let expected = Wire { builder: self.builder, id: column.read }.width();
            self.builder.expect_port(&name, &format!("write.{}", column.name), wire.width(), expected);
        }
        let [enable, address] = [enable, address].map(|wire| self.builder.own(wire));
        let word = self.builder.own_all(word);
        self.info(|info| {
            (info.write_enable, info.write_address) = (enable, address);
            info.columns.iter_mut().zip(word).for_each(|(column, written)| column.written = written);
        });
    }

    /// Reads a word at edges where `enable` is 1. Returns its columns, which show the word in the next cycle, or with a
    /// [`latency`](Self::latency) of 2 in the one after.
    pub fn read(self, enable: Wire<'m>, address: Wire<'m>) -> Vec<Wire<'m>> {
        self.connect("read", enable, address);
        let [enable, address] = [enable, address].map(|wire| self.builder.own(wire));
        self.info(|info| (info.read_enable, info.read_address) = (enable, address));
        self.columns()
    }

    /// Checks a port. The text has the memory where its second port is connected.
    fn connect(self, port: &str, enable: Wire<'m>, address: Wire<'m>) {
        let (name, depth) = self.info(|info| (info.name.clone(), info.depth));
        self.builder.drive(Undriven::Port(format!("{name}.{port}")));
        self.builder.expect_port(&name, &format!("{port} enable"), enable.width(), 1);
        self.builder.expect_port(&name, &format!("{port} address"), address.width(), address_width(depth));
        let is_open = |undriven: &Undriven| {
            ["write", "read"].iter().any(|port| *undriven == Undriven::Port(format!("{name}.{port}")))
        };
        if !self.builder.state.borrow().undriven.iter().any(is_open) {
            self.builder.item(Item::Memory(self.index));
        }
    }

    fn info<R>(self, change: impl FnOnce(&mut MemoryInfo) -> R) -> R {
        change(&mut self.builder.state.borrow_mut().module.memories[self.index])
    }
}
