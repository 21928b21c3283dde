//! Where cuts may be: the paths through a module, and the time that they take.

use super::cut::Network;
use super::{is_constant, needed};
use crate::depth::{Technology, loads_of};
use crate::netlist::{Driver, Module, Signal, SignalId};
use std::sync::Arc;

/// What limits the places of cuts.
pub struct Paths<'m> {
    module: &'m Module,
    /// In the unit of the technology; `None` is a product that takes a whole part.
    delays: Vec<Option<f64>>,
    /// Live signals that read each signal.
    readers: Vec<Vec<SignalId>>,
    /// Whether an output depends on the signal.
    is_live: Vec<bool>,
    /// Whether an output port shows the signal.
    is_output: Vec<bool>,
}

impl<'m> Paths<'m> {
    pub fn new(module: &'m Arc<Module>, technology: Technology) -> Self {
        let loads = loads_of(module);
        let width = |id: SignalId| module.signal(id).width;
        let delay = |(index, signal): (usize, &Signal)| match &signal.driver {
            Driver::Mul(..) if technology.has_multipliers() => None,
            Driver::ShiftLeft(_, amount) | Driver::ShiftRight(_, amount) if is_constant(module.signal(*amount)) => {
                Some(0.0)
            }
            // Each bit is a test of the amount.
            Driver::ShiftLeft(word, amount) | Driver::ShiftRight(word, amount) if is_constant(module.signal(*word)) => {
                Some(technology.delay(&Driver::All(*amount), &[width(*amount)], signal.width, loads[index]) + 1.0)
            }
            Driver::Input => Some(technology.arrival()),
            Driver::Constant(_) => Some(0.0),
            driver if driver.is_wiring() => Some(0.0),
            driver => {
                let operands: Vec<u32> = driver.operands().map(|id| significant(module, id)).collect();
                Some(technology.delay(driver, &operands, signal.width, loads[index]))
            }
        };
        let delays = module.signals.iter().enumerate().map(delay).collect();
        let outputs: Vec<SignalId> = module.outputs.iter().map(|port| port.signal).collect();
        let mut paths = Self {
            module,
            delays,
            readers: vec![Vec::new(); module.signals.len()],
            is_live: needed(module, outputs.iter().copied()),
            is_output: vec![false; module.signals.len()],
        };
        outputs.iter().for_each(|output| paths.is_output[output.index()] = true);
        for id in paths.ids().filter(|id| paths.is_live[id.index()]) {
            module.signal(id).driver.operands().for_each(|operand| paths.readers[operand.index()].push(id));
        }
        paths
    }

    fn ids(&self) -> impl DoubleEndedIterator<Item = SignalId> + use<> {
        (0..self.module.signals.len() as u32).map(SignalId)
    }

    /// The shortest period for which `count` parts suffice, within one part in a thousand.
    pub fn shortest_period(&self, count: usize) -> f64 {
        let delays = || self.delays.iter().flatten();
        let products = self.delays.iter().filter(|delay| delay.is_none()).count();
        // A delay is not divided; at the longest period, all but the products are in one part.
        let mut short = delays().copied().fold(0.0, f64::max);
        let mut period = (delays().sum::<f64>() + 1.0) * (1 + products) as f64;
        while period - short > period / 1000.0 {
            let middle = f64::midpoint(short, period);
            match self.parts_to_outputs(middle).into_iter().map(|(parts, _)| parts).max() <= Some(count) {
                true => period = middle,
                false => short = middle,
            }
        }
        period
    }

    /// The part of every signal, from 0. A signal is in no earlier part than its operands.
    pub fn place(&self, count: usize, period: f64) -> Vec<usize> {
        let to_outputs = self.parts_to_outputs(period);
        let mut placed = vec![0; self.module.signals.len()];
        for cut in 1..count {
            let after = self.after(cut, &placed, period, |id| to_outputs[id.index()].0 > count - cut);
            for id in self.ids().filter(|id| after[id.index()]) {
                placed[id.index()] = cut;
            }
        }
        placed
    }

    /// The delay of a signal's driver. A product takes the period, so that no gate is in its part before or behind it.
    /// What comes before an input takes no more than a part.
    fn delay(&self, id: SignalId, period: f64) -> f64 {
        match (self.delays[id.index()], &self.module.signal(id).driver) {
            (Some(arrival), Driver::Input) => arrival.min(period),
            (delay, _) => delay.unwrap_or(period),
        }
    }

    /// For each signal, the parts that are needed from its driver on, and the time of it in the first of them.
    fn parts_to_outputs(&self, period: f64) -> Vec<(usize, f64)> {
        let mut from: Vec<(usize, f64)> = vec![(1, 0.0); self.module.signals.len()];
        let later = |a: (usize, f64), b: (usize, f64)| if a < b { b } else { a };
        for id in self.ids().rev() {
            let readers = self.readers[id.index()].iter().map(|reader| from[reader.index()]);
            let (parts, time) = readers.fold((1, 0.0), later);
            let delay = self.delay(id, period);
            from[id.index()] = if time + delay <= period { (parts, time + delay) } else { (parts + 1, delay) };
        }
        from
    }

    /// Whether each signal is behind the cut of this number. What `is_before` names is not.
    fn after(&self, cut: usize, placed: &[usize], period: f64, is_before: impl Fn(SignalId) -> bool) -> Vec<bool> {
        // The time from the cut before.
        let mut times = vec![0.0; placed.len()];
        let mut network = Network::new(placed.len());
        for id in self.ids() {
            if placed[id.index()] + 1 < cut {
                network.fix_before(id.index());
                continue;
            }
            let driver = &self.module.signal(id).driver;
            let begin = driver.operands().map(|operand| times[operand.index()]).fold(0.0, f64::max);
            times[id.index()] = begin + self.delay(id, period);
            if matches!(driver, Driver::Input) || is_before(id) {
                network.fix_before(id.index());
            } else if times[id.index()] > period * (1.0 + ROUNDING) {
                network.fix_after(id.index());
            }
        }
        for id in self.ids().filter(|id| self.is_live[id.index()] && !is_constant(self.module.signal(*id))) {
            network.carries(id.index(), self.module.signal(id).width);
            self.readers[id.index()].iter().for_each(|reader| network.reads(reader.index(), id.index()));
            if self.is_output[id.index()] {
                network.read_after(id.index());
            }
        }
        // The products are in one part, so that the registers of their operands are those of multipliers alone.
        let products: Vec<usize> = (0..placed.len()).filter(|&index| self.delays[index].is_none()).collect();
        products.windows(2).for_each(|pair| network.joins(pair[0], pair[1]));
        let mut after = network.minimum_cut();
        // What no output needs stays with its operands.
        for id in self.ids().filter(|id| !self.is_live[id.index()]) {
            after[id.index()] = self.module.signal(id).driver.operands().any(|operand| after[operand.index()]);
        }
        after
    }
}

/// The width of a signal without its upper constant bits.
fn significant(module: &Module, id: SignalId) -> u32 {
    let signal = module.signal(id);
    match &signal.driver {
        Driver::Constant(value) => u64::BITS - value.leading_zeros(),
        Driver::Alias(source) => significant(module, *source),
        Driver::Concat(parts) => {
            let lower = parts.iter().skip_while(|part| is_constant(module.signal(**part)));
            lower.map(|part| module.signal(*part).width).sum()
        }
        _ => signal.width,
    }
}

/// The relative error of a sum of delays.
const ROUNDING: f64 = 1e-9;
