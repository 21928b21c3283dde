//! Divides a combinational module into parts with registers to come between them.
//!
//! By a model of delays, a period has as many parts as the longest path needs. Where each cut may be follows from the
//! period and the paths to and from a signal; of all places, a minimum cut finds the one with the fewest bits.

use crate::Error;
use crate::depth::{Technology, loads_of};
use crate::netlist::{Driver, Item, Module, Port, Signal, SignalId};
use crate::text::Text;
use std::collections::{BTreeMap, HashSet, VecDeque};
use std::sync::Arc;

/// The parts of `module`, in the order of computation. Connected, they compute the same: output port `x_o` of a part
/// drives input port `x_i` of the next. The modules are `<module>_part_1_of_<count>` and so on; with a `count` of 1, the
/// module itself. A product (`*`) has a part without other gates before or after it, for the registers of an FPGA's
/// multipliers, if the technology has them.
///
/// A longer period has fewer bits between the parts: the period is that for which the period, times the gates of the
/// module and of the bits, is least. `bit_gates` are those of a bit; with 0 the period is the shortest.
///
/// # Errors
/// No part; registers, memories or instances in the module.
pub fn divide(
    module: &Arc<Module>,
    count: u32,
    technology: Technology,
    bit_gates: f64,
) -> Result<Vec<Arc<Module>>, Error> {
    let refused = |problem: &str| Error::Name {
        module: module.name.clone(),
        name: format!("part_1_of_{count}"),
        problem: problem.to_string(),
    };
    if count == 0 {
        return Err(refused("does not exist: a module has one part or more"));
    }
    if module.is_clocked() || !module.instances.is_empty() {
        return Err(refused("does not exist: a module with registers or instances is not divided"));
    }
    if count == 1 {
        return Ok(vec![module.clone()]);
    }
    let paths = Paths::new(module, technology);
    let gates = module.gates_of_two_inputs();
    let shortest = paths.shortest_period(count as usize);
    let longer = LONGER.iter().take(if bit_gates > 0.0 { LONGER.len() } else { 1 });
    let divisions = longer.map(|longer| {
        let division = Division::new(module, paths.place(count as usize, shortest * longer), count as usize);
        let bits: u32 = division.crossing.iter().flat_map(BTreeMap::values).map(|(_, bits)| bits).sum();
        (shortest * longer * (gates + f64::from(bits) * bit_gates), division)
    });
    let best = divisions.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, division)| division);
    Ok((0..count as usize).filter_map(|part| Some(Arc::new(best.as_ref()?.part(part)))).collect())
}

/// The periods that are tried, in shortest ones.
const LONGER: [f64; 6] = [1.0, 1.1, 1.2, 1.3, 1.4, 1.5];

/// What limits the places of cuts.
struct Paths<'m> {
    module: &'m Module,
    /// Nanoseconds or another unit for each signal; `None` is a product that wants a part of its own.
    delays: Vec<Option<f64>>,
    readers: Vec<Vec<SignalId>>,
    /// Signals that an output or another live signal depends on.
    is_live: Vec<bool>,
    /// Whether an output port shows the signal.
    is_output: Vec<bool>,
}

impl<'m> Paths<'m> {
    fn new(module: &'m Arc<Module>, technology: Technology) -> Self {
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
            driver if is_wiring(driver) => Some(0.0),
            driver => {
                let operands: Vec<u32> = driver.operands().map(width).collect();
                Some(technology.delay(driver, &operands, signal.width, loads[index]))
            }
        };
        let delays = module.signals.iter().enumerate().map(delay).collect();
        let mut paths = Self {
            module,
            delays,
            readers: vec![Vec::new(); module.signals.len()],
            is_live: vec![false; module.signals.len()],
            is_output: vec![false; module.signals.len()],
        };
        for port in &module.outputs {
            paths.is_output[port.signal.index()] = true;
            paths.is_live[port.signal.index()] = true;
        }
        for (index, signal) in module.signals.iter().enumerate().rev() {
            for operand in signal.driver.operands() {
                paths.is_live[operand.index()] |= paths.is_live[index];
                paths.readers[operand.index()].push(SignalId(index as u32));
            }
        }
        paths
    }

    fn ids(&self) -> impl DoubleEndedIterator<Item = SignalId> + use<> {
        (0..self.module.signals.len() as u32).map(SignalId)
    }

    fn signal(&self, id: SignalId) -> &'m Signal {
        self.module.signal(id)
    }

    /// Within one part in a thousand.
    fn shortest_period(&self, count: usize) -> f64 {
        let products = self.delays.iter().filter(|delay| delay.is_none()).count();
        let whole: f64 = self.delays.iter().flatten().sum::<f64>() + 1.0;
        let (mut short, mut period) = (0.0, whole * (1 + products) as f64);
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
    fn place(&self, count: usize, period: f64) -> Vec<usize> {
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

    /// For each signal, the parts that are needed from its driver on, and the time of it in the first of them. A delay
    /// longer than the period makes the parts infinitely many.
    fn parts_to_outputs(&self, period: f64) -> Vec<(usize, f64)> {
        let mut from: Vec<(usize, f64)> = vec![(1, 0.0); self.module.signals.len()];
        for id in self.ids().rev() {
            let latest = |a: (usize, f64), b: (usize, f64)| if a.0 > b.0 || (a.0 == b.0 && a.1 > b.1) { a } else { b };
            let readers = self.readers[id.index()].iter().filter(|reader| self.is_live[reader.index()]);
            let (parts, time) = readers.map(|reader| from[reader.index()]).fold((1, 0.0), latest);
            from[id.index()] = match self.delays[id.index()] {
                Some(delay) if delay > period => (usize::MAX / 2, period),
                Some(delay) if time + delay <= period => (parts, time + delay),
                Some(delay) => (parts.saturating_add(1), delay),
                None if time == 0.0 => (parts, period),
                None => (parts.saturating_add(1), period),
            };
        }
        from
    }

    /// Whether each signal is behind the cut of this number. What `is_before` names is not.
    fn after(&self, cut: usize, placed: &[usize], period: f64, is_before: impl Fn(SignalId) -> bool) -> Vec<bool> {
        // The time from the cut before, and what is too late.
        let mut times = vec![0.0; placed.len()];
        let mut network = Network::new(placed.len());
        for id in self.ids() {
            if placed[id.index()] + 1 < cut {
                continue;
            }
            let driver = &self.signal(id).driver;
            let begin = driver.operands().map(|operand| times[operand.index()]).fold(0.0, f64::max);
            times[id.index()] = match self.delays[id.index()] {
                Some(delay) => begin + delay,
                None if begin == 0.0 => period,
                None => begin + period,
            };
            if matches!(driver, Driver::Input) || is_before(id) {
                network.fix_before(id.index());
            } else if times[id.index()] > period * (1.0 + ROUNDING) {
                network.fix_after(id.index());
            }
        }
        for id in self.ids().filter(|id| self.is_live[id.index()] && !is_constant(self.signal(*id))) {
            network.carries(id.index(), self.signal(id).width);
            self.readers[id.index()].iter().filter(|r| self.is_live[r.index()]).for_each(|reader| {
                network.reads(reader.index(), id.index());
            });
            if self.is_output[id.index()] {
                network.read_after(id.index());
            }
            if placed[id.index()] + 1 < cut {
                network.fix_before(id.index());
            }
        }
        let after = network.minimum_cut();
        // What nothing live reads stays with its operands; a constant is where it is read.
        let mut all = after;
        for id in self.ids().filter(|id| !self.is_live[id.index()]) {
            all[id.index()] = self.signal(id).driver.operands().any(|operand| all[operand.index()]);
        }
        all
    }
}

/// The relative error of a sum of delays.
const ROUNDING: f64 = 1e-9;

fn is_constant(signal: &Signal) -> bool {
    matches!(signal.driver, Driver::Constant(_))
}

/// Wires alone.
fn is_wiring(driver: &Driver) -> bool {
    matches!(driver, Driver::Input | Driver::Constant(_) | Driver::Alias(_) | Driver::Concat(_) | Driver::Slice { .. })
}

/// A minimum cut between what is before and what is after, with the bits of a signal that is read behind the cut as its
/// costs.
struct Network {
    /// For each vertex its edges: target, capacity, and the position of the reverse edge. Signal `i` has the vertices
    /// `2 i`, before the bits that it carries, and `2 i + 1` behind them.
    edges: Vec<Vec<(usize, u64, usize)>>,
}

/// More than any number of bits.
const UNLIMITED: u64 = 1 << 40;

impl Network {
    fn new(signals: usize) -> Self {
        Self { edges: vec![Vec::new(); 2 * signals + 2] }
    }

    fn source(&self) -> usize {
        self.edges.len() - 2
    }

    fn edge(&mut self, from: usize, to: usize, capacity: u64) {
        let (forward, backward) = (self.edges[from].len(), self.edges[to].len());
        self.edges[from].push((to, capacity, backward));
        self.edges[to].push((from, 0, forward));
    }

    fn carries(&mut self, signal: usize, bits: u32) {
        self.edge(2 * signal, 2 * signal + 1, bits.into());
    }

    /// A reader behind the cut needs the bits; a signal behind the cut has no reader before it.
    fn reads(&mut self, reader: usize, signal: usize) {
        self.edge(2 * signal + 1, 2 * reader, UNLIMITED);
        self.edge(2 * reader, 2 * signal, UNLIMITED);
    }

    fn fix_before(&mut self, signal: usize) {
        self.edge(self.source(), 2 * signal, UNLIMITED);
    }

    fn fix_after(&mut self, signal: usize) {
        self.edge(2 * signal, self.source() + 1, UNLIMITED);
    }

    fn read_after(&mut self, signal: usize) {
        self.edge(2 * signal + 1, self.source() + 1, UNLIMITED);
    }

    /// Whether each signal is behind the minimum cut that is nearest to the source (Edmonds and Karp).
    fn minimum_cut(mut self) -> Vec<bool> {
        let (source, sink) = (self.source(), self.source() + 1);
        loop {
            let mut reached: Vec<Option<(usize, usize)>> = vec![None; self.edges.len()];
            let mut open = VecDeque::from([source]);
            while let Some(vertex) = open.pop_front() {
                for (place, &(to, capacity, _)) in self.edges[vertex].iter().enumerate() {
                    if capacity > 0 && to != source && reached[to].is_none() {
                        reached[to] = Some((vertex, place));
                        open.push_back(to);
                    }
                }
            }
            if reached[sink].is_none() {
                return (0..source / 2).map(|signal| reached[2 * signal].is_none()).collect();
            }
            let path: Vec<(usize, usize)> = std::iter::successors(reached[sink], |&(from, _)| reached[from]).collect();
            let flow = path.iter().map(|&(from, place)| self.edges[from][place].1).min().unwrap_or(0);
            for (from, place) in path {
                let (to, _, back) = self.edges[from][place];
                self.edges[from][place].1 -= flow;
                self.edges[to][back].1 += flow;
            }
        }
    }
}

/// A module whose signals are placed in parts.
struct Division<'m> {
    module: &'m Module,
    placed: Vec<usize>,
    /// Whether an output needs a signal, or it is marked as unused by intention. The others are in no part.
    is_kept: Vec<bool>,
    /// The signals that cross each cut, with the bits that are read behind it.
    crossing: Vec<BTreeMap<SignalId, Bits>>,
    /// The stems of the ports of crossing signals.
    stems: BTreeMap<SignalId, String>,
}

/// Bits of a signal: the lowest, and their number.
type Bits = (u32, u32);

impl<'m> Division<'m> {
    fn new(module: &'m Module, placed: Vec<usize>, count: usize) -> Self {
        let mut reads: Vec<BTreeMap<SignalId, Bits>> = vec![BTreeMap::new(); count];
        let mut read = |id: SignalId, bits: Bits, reader: usize| {
            if matches!(module.signal(id).driver, Driver::Constant(_)) {
                return;
            }
            for reads in reads.iter_mut().take(reader).skip(placed[id.index()]) {
                let known = reads.entry(id).or_insert(bits);
                let low = known.0.min(bits.0);
                *known = (low, (known.0 + known.1).max(bits.0 + bits.1) - low);
            }
        };
        let is_kept = kept(module);
        for (index, signal) in module.signals.iter().enumerate().filter(|(index, _)| is_kept[*index]) {
            signal
                .driver
                .operands()
                .for_each(|operand| read(operand, bits_read(module, signal, operand), placed[index]));
        }
        module.outputs.iter().for_each(|port| read(port.signal, (0, module.signal(port.signal).width), count - 1));
        let mut division = Self { module, placed, is_kept, crossing: reads, stems: BTreeMap::new() };
        let ids: Vec<SignalId> = division.crossing.iter().flat_map(BTreeMap::keys).copied().collect();
        let mut taken = HashSet::new();
        for id in ids {
            if !division.stems.contains_key(&id) {
                let stem = division.stem(id);
                let numbered = (2..).map(|number| format!("{stem}_v{number}"));
                let free = std::iter::once(stem.clone()).chain(numbered).find(|stem| taken.insert(stem.clone()));
                division.stems.insert(id, free.unwrap_or(stem));
            }
        }
        division
    }

    /// The name of a signal, or one that says what it is.
    fn stem(&self, id: SignalId) -> String {
        let Signal { name, hint, driver, width, .. } = self.module.signal(id);
        match (name.as_ref().or(hint.as_ref()), driver) {
            (Some(name), Driver::Input) => format!("passed_{}", name.strip_suffix("_i").unwrap_or(name)),
            (Some(name), _) => name.clone(),
            (None, Driver::Slice { .. }) => {
                let (source, low) = self.whole(id);
                let stem = self.stem(source);
                if *width == 1 { format!("{stem}_{low}") } else { format!("{stem}_{}_{low}", low + width - 1) }
            }
            (None, Driver::Not(source)) => format!("not_{}", self.stem(*source)),
            (None, Driver::Any(source)) => format!("any_{}", self.stem(*source)),
            (None, Driver::All(source)) => format!("all_{}", self.stem(*source)),
            (None, Driver::Alias(source)) => self.stem(*source),
            (None, _) => format!("value_{}", id.0),
        }
    }

    /// The signal that unnamed slices are cut from, and the lowest bit.
    fn whole(&self, id: SignalId) -> (SignalId, u32) {
        match self.module.signal(id) {
            Signal { name: None, driver: Driver::Slice { source, low }, .. } => {
                let (whole, below) = self.whole(*source);
                (whole, below + low)
            }
            _ => (id, 0),
        }
    }

    /// The port of a signal at a cut, without the suffix of its direction.
    fn port(&self, id: SignalId, (low, bits): Bits) -> String {
        let stem = &self.stems[&id];
        if bits == self.module.signal(id).width { stem.clone() } else { format!("{stem}_from_{low}") }
    }

    fn part(&self, number: usize) -> Module {
        let count = self.crossing.len();
        let name = format!("{}_part_{}_of_{count}", self.module.name, number + 1);
        let doc = self.module.doc.iter().cloned().chain([format!("Part {} of {count}.", number + 1)]).collect();
        let mut part =
            Part { division: self, number, signals: Vec::new(), inside: BTreeMap::new(), entering: BTreeMap::new() };
        let inputs = part.inputs();
        part.copy();
        let outputs = part.outputs();
        let items = part.items();
        Module {
            name,
            doc,
            signals: part.signals,
            inputs,
            outputs,
            registers: Vec::new(),
            memories: Vec::new(),
            instances: Vec::new(),
            items,
            text: Text::default(),
        }
    }
}

/// The signals that outputs need, and those that are marked as unused with what they need.
fn kept(module: &Module) -> Vec<bool> {
    let mut is_kept = vec![false; module.signals.len()];
    let mut open: Vec<SignalId> = module.outputs.iter().map(|port| port.signal).collect();
    for item in &module.items {
        if let Item::Unused(_, ids) = item {
            open.extend(ids);
        }
    }
    while let Some(id) = open.pop() {
        if !std::mem::replace(&mut is_kept[id.index()], true) {
            open.extend(module.signal(id).driver.operands());
        }
    }
    is_kept
}

/// The bits of an operand that a signal reads.
fn bits_read(module: &Module, signal: &Signal, operand: SignalId) -> Bits {
    match signal.driver {
        Driver::Slice { low, .. } => (low, signal.width),
        _ => (0, module.signal(operand).width),
    }
}

/// A part under construction.
struct Part<'a> {
    division: &'a Division<'a>,
    number: usize,
    signals: Vec<Signal>,
    /// The signals that are computed here, and constants.
    inside: BTreeMap<SignalId, SignalId>,
    /// The signals that cross the cut before: the input, and its lowest bit.
    entering: BTreeMap<SignalId, (SignalId, u32)>,
}

impl Part<'_> {
    fn push(&mut self, signal: Signal) -> SignalId {
        self.signals.push(signal);
        SignalId(self.signals.len() as u32 - 1)
    }

    fn inputs(&mut self) -> Vec<Port> {
        let division = self.division;
        let Some(before) = self.number.checked_sub(1) else {
            let own = division.module.inputs.iter().map(|port| {
                let signal = self.push(division.module.signal(port.signal).clone());
                self.inside.insert(port.signal, signal);
                Port { name: port.name.clone(), signal }
            });
            return own.collect();
        };
        let entering = division.crossing[before].iter().map(|(&id, &bits)| {
            let name = format!("{}_i", division.port(id, bits));
            let signal = Signal { name: Some(name.clone()), ..Signal::unnamed(bits.1, Driver::Input) };
            let signal = self.push(signal);
            self.entering.insert(id, (signal, bits.0));
            Port { name, signal }
        });
        entering.collect()
    }

    /// Copies the signals that are computed here.
    fn copy(&mut self) {
        let Division { module, placed, is_kept, .. } = self.division;
        for (index, signal) in module.signals.iter().enumerate() {
            let id = SignalId(index as u32);
            let is_here =
                is_kept[index] && placed[index] == self.number && !matches!(signal.driver, Driver::Constant(_));
            if !is_here || self.inside.contains_key(&id) {
                continue;
            }
            let mut copy = signal.clone();
            let operands: Vec<(SignalId, SignalId)> =
                signal.driver.operands().map(|operand| (operand, self.value(operand))).collect();
            let new = |id: SignalId| operands.iter().find(|(old, _)| *old == id).map_or(id, |(_, new)| *new);
            copy.driver.renumber(new);
            if let (Driver::Slice { source, low }, Driver::Slice { source: old, .. }) =
                (&mut copy.driver, &signal.driver)
                && let Some((_, first)) = self.entering.get(old)
            {
                *low -= first;
                let source = *source;
                if self.signals[source.index()].width == copy.width {
                    copy.driver = Driver::Alias(source);
                }
            }
            let new = self.push(copy);
            self.inside.insert(id, new);
        }
    }

    /// A signal of the module in this part.
    fn value(&mut self, id: SignalId) -> SignalId {
        if let Some((input, _)) = self.entering.get(&id) {
            return *input;
        }
        if let Some(&inside) = self.inside.get(&id) {
            return inside;
        }
        // A constant, which is in each part that reads it.
        let constant = self.push(self.division.module.signal(id).clone());
        self.inside.insert(id, constant);
        constant
    }

    fn outputs(&mut self) -> Vec<Port> {
        let division = self.division;
        if self.number + 1 == division.crossing.len() {
            let port = |port: &Port| Port { name: port.name.clone(), signal: self.value(port.signal) };
            return division.module.outputs.iter().map(port).collect();
        }
        let leaving = division.crossing[self.number].iter().map(|(&id, &bits)| {
            let (low, width) = bits;
            let source = self.value(id);
            let first = self.entering.get(&id).map_or(0, |(_, first)| *first);
            let signal = match self.signals[source.index()].width == width {
                true => source,
                false => self.push(Signal::unnamed(width, Driver::Slice { source, low: low - first })),
            };
            Port { name: format!("{}_o", division.port(id, bits)), signal }
        });
        leaving.collect()
    }

    /// The elements of the text: those of the module whose signals are here.
    fn items(&mut self) -> Vec<Item> {
        let mut items = Vec::new();
        let mut section = None;
        for item in &self.division.module.items {
            let here = |id: &SignalId| self.inside.get(id).copied();
            let kept = match item {
                Item::Section(title) => {
                    section = Some(Item::Section(title.clone()));
                    None
                }
                Item::Signal(id) => here(id).map(Item::Signal),
                Item::Parameter(id, formula) => here(id).map(|id| Item::Parameter(id, formula.clone())),
                Item::Unused(name, ids) => {
                    let ids: Vec<SignalId> = ids.iter().filter_map(here).collect();
                    (!ids.is_empty()).then(|| Item::Unused(name.clone(), ids))
                }
                Item::Instance(_) | Item::Register(_) | Item::Memory(_) => None,
            };
            if let Some(kept) = kept {
                items.extend(section.take());
                items.push(kept);
            }
        }
        items.extend(self.unread());
        items
    }

    /// Bits that enter and that nothing reads here: they are between bits that a later part reads.
    fn unread(&mut self) -> Vec<Item> {
        let entering: Vec<(SignalId, SignalId, u32)> =
            self.entering.iter().map(|(&id, &(input, low))| (id, input, low)).collect();
        let mut items = Vec::new();
        for (id, input, first) in entering {
            let width = self.signals[input.index()].width;
            let mut is_read = vec![false; width as usize];
            let mut read = |(low, bits): Bits| is_read[low as usize..(low + bits) as usize].fill(true);
            for signal in &self.signals {
                signal.driver.operands().filter(|operand| *operand == input).for_each(|_| {
                    read(match signal.driver {
                        Driver::Slice { low, .. } => (low, signal.width),
                        _ => (0, width),
                    });
                });
            }
            match self.division.crossing.get(self.number) {
                Some(leaving) if self.number + 1 < self.division.crossing.len() => {
                    leaving.get(&id).into_iter().for_each(|&(low, bits)| read((low - first, bits)));
                }
                _ => {
                    self.division.module.outputs.iter().filter(|port| port.signal == id).for_each(|_| read((0, width)))
                }
            }
            let mut slices = Vec::new();
            let mut low = 0;
            for run in is_read.chunk_by(|a, b| a == b) {
                let bits = run.len() as u32;
                if !run[0] {
                    slices.push(self.push(Signal::unnamed(bits, Driver::Slice { source: input, low })));
                }
                low += bits;
            }
            if !slices.is_empty() {
                items.push(Item::Unused(format!("unused_{}", self.division.stems[&id]), slices));
            }
        }
        items
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Builder, Simulator, verilog};

    /// Sums, a product, a shift, a word of which later parts read some bits, and one that goes to an output at once.
    fn subject() -> Arc<Module> {
        let m = Builder::new("subject");
        let [a, b] = ["a_i", "b_i"].map(|name| m.input(name, 12));
        let sum = (a + b).named("sum");
        let product = (sum.lower(6) * b.lower(6)).named("product");
        let shifted = product.shift_right(a.lower(4)).named("shifted");
        let ends = m.concat(&[sum.top(), sum.bit(0)]);
        m.section("The result");
        let result = (shifted + ends.extend(12)).named("result");
        m.output("early_o", a.top());
        m.output("result_o", result);
        m.unused("unused_b", &[b.top()]);
        // Nothing reads it.
        let _ = product.any() & !shifted.any();
        m.finish().expect("a module")
    }

    fn results(parts: &[Arc<Module>], a: u64, b: u64) -> Vec<u64> {
        let mut values = BTreeMap::from([("a".to_string(), a), ("b".to_string(), b)]);
        let mut outputs = Vec::new();
        for part in parts {
            let mut simulator = Simulator::new(part).expect("no loop");
            outputs = simulator.evaluate(part.inputs().iter().map(|port| values[port.stem()])).to_vec();
            values = part.outputs().iter().map(|port| port.stem().to_string()).zip(outputs.iter().copied()).collect();
        }
        outputs
    }

    #[test]
    fn parts_compute_the_same() {
        let whole = subject();
        for (technology, count) in
            [Technology::Gates, Technology::Luts].into_iter().flat_map(|t| (1..9).map(move |c| (t, c)))
        {
            for bit_gates in [0.0, 100.0] {
                let parts = divide(&whole, count, technology, bit_gates).expect("parts");
                assert_eq!(parts.len(), count as usize);
                for (part, next) in parts.iter().zip(&parts[1..]) {
                    let read: Vec<SignalId> = next.signals.iter().flat_map(|signal| signal.driver.operands()).collect();
                    let is_read = |port: &Port| {
                        read.contains(&port.signal) || next.outputs.iter().any(|output| output.signal == port.signal)
                    };
                    assert!(next.inputs.iter().all(is_read), "{}, {}", part.name, next.name);
                }
                for (a, b) in [(0, 0), (0xfff, 0xfff), (0x123, 0x9ab), (0x801, 0x7ff), (5, 0x2a), (0xc3f, 0x3c)] {
                    let sum = (a + b) & 0xfff;
                    let shifted = ((sum & 63) * (b & 63)) >> (a & 15);
                    let expected = [a >> 11, (shifted + (sum >> 11 << 1 | sum & 1)) & 0xfff];
                    assert_eq!(results(&parts, a, b), expected, "{technology:?}, {count}: {a:#x}, {b:#x}");
                }
            }
        }
    }

    #[test]
    fn a_part_takes_no_longer_than_the_period_and_a_longer_one_has_fewer_bits() {
        let whole = subject();
        let shortest_period = |count| Paths::new(&whole, Technology::Gates).shortest_period(count as usize);
        let bits = |parts: &[Arc<Module>]| -> u32 {
            parts[1..].iter().flat_map(|part| part.inputs().iter().map(|port| part.signal(port.signal).width)).sum()
        };
        for count in 2..5 {
            let shortest = shortest_period(count);
            let [tight, loose] =
                [0.0, 1e6].map(|bit_gates| divide(&whole, count, Technology::Gates, bit_gates).expect("parts"));
            for part in &tight {
                let longest =
                    crate::longest_path(part, |d, o, w, l| Technology::Gates.delay(d, o, w, l)).expect("no loop");
                // A port is a load that the whole does not have.
                assert!(longest <= shortest * 1.05, "{count}: {longest} in {shortest}");
            }
            assert!(bits(&loose) <= bits(&tight), "{count}");
        }
        let [three, four] = [3, 4].map(shortest_period);
        assert!(four <= three);
    }

    /// The multiplier of an FPGA has its registers before and behind the product.
    #[test]
    fn a_product_is_alone_in_its_part() {
        let parts = divide(&subject(), 4, Technology::Luts, 0.0).expect("parts");
        let product = parts.iter().find(|part| part.signals().iter().any(|s| matches!(s.driver, Driver::Mul(..))));
        let text = verilog::text(product.expect("a product")).expect("text");
        assert!(text.contains("product_o") && !text.contains(" + ") && !text.contains(">>"), "{text}");
    }

    #[test]
    fn what_is_not_divided() {
        let m = Builder::new("clocked");
        let register = m.register("a_q", 1);
        register.next(m.input("a_i", 1));
        m.output("a_o", register.wire());
        let clocked = m.finish().expect("a module");
        for (module, count) in [(&clocked, 2), (&subject(), 0)] {
            let problem = divide(module, count, Technology::Gates, 0.0).expect_err("no parts").to_string();
            assert!(problem.contains("does not exist"), "{problem}");
        }
    }
}
