//! The parts of a module whose signals have their places.

use super::{is_constant, needed};
use crate::names::fresh;
use crate::netlist::{Driver, Item, Module, Port, Signal, SignalId};
use crate::text::Text;
use std::collections::{BTreeMap, HashSet};

/// A module whose signals are placed in parts.
pub struct Division<'m> {
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

/// The longest name that is made of the names of two signals.
const MOST_LETTERS: usize = 48;

impl<'m> Division<'m> {
    pub fn new(module: &'m Module, placed: Vec<usize>, count: usize) -> Self {
        let mut reads: Vec<BTreeMap<SignalId, Bits>> = vec![BTreeMap::new(); count];
        let mut read = |id: SignalId, bits: Bits, reader: usize| {
            if is_constant(module.signal(id)) {
                return;
            }
            for reads in reads.iter_mut().take(reader).skip(placed[id.index()]) {
                let known = reads.entry(id).or_insert(bits);
                let low = known.0.min(bits.0);
                *known = (low, (known.0 + known.1).max(bits.0 + bits.1) - low);
            }
        };
        let unused = module.items.iter().filter_map(|item| match item {
            Item::Unused(_, ids) => Some(ids),
            _ => None,
        });
        let outputs = module.outputs.iter().map(|port| port.signal);
        let is_kept = needed(module, outputs.chain(unused.flatten().copied()));
        for (index, signal) in module.signals.iter().enumerate().filter(|(index, _)| is_kept[*index]) {
            for operand in signal.driver.operands() {
                read(operand, bits_read(signal, module.signal(operand).width), placed[index]);
            }
        }
        module.outputs.iter().for_each(|port| read(port.signal, (0, module.signal(port.signal).width), count - 1));
        let mut division = Self { module, placed, is_kept, crossing: reads, stems: BTreeMap::new() };
        let ids: Vec<SignalId> = division.crossing.iter().flat_map(BTreeMap::keys).copied().collect();
        let mut taken = HashSet::new();
        for id in ids {
            if !division.stems.contains_key(&id) {
                let stem = fresh(&mut taken, &division.stem(id));
                division.stems.insert(id, stem);
            }
        }
        division
    }

    /// The bits between the parts.
    pub fn bits(&self) -> u32 {
        self.crossing.iter().flat_map(BTreeMap::values).map(|(_, bits)| bits).sum()
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
            (None, driver) => self.of_two(driver).unwrap_or_else(|| format!("value_{}", id.0)),
        }
    }

    /// The name of what an operator makes of two signals, if it is short.
    fn of_two(&self, driver: &Driver) -> Option<String> {
        let (word, a, b) = match driver {
            Driver::And(a, b) => ("and", a, b),
            Driver::Or(a, b) => ("or", a, b),
            Driver::Xor(a, b) => ("xor", a, b),
            Driver::Add(a, b) => ("plus", a, b),
            Driver::Sub(a, b) => ("minus", a, b),
            Driver::Less(a, b) => ("below", a, b),
            Driver::Equal(a, b) => ("equals", a, b),
            _ => return None,
        };
        let [a, b] = [a, b].map(|id| self.stem(*id));
        let name = format!("{a}_{word}_{b}");
        (name.len() <= MOST_LETTERS && !name.contains("value_")).then_some(name)
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

    pub fn part(&self, number: usize) -> Module {
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

/// The bits that a signal reads of an operand of this width.
fn bits_read(signal: &Signal, width: u32) -> Bits {
    match signal.driver {
        Driver::Slice { low, .. } => (low, signal.width),
        _ => (0, width),
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
            let is_here = is_kept[index] && placed[index] == self.number && !is_constant(signal);
            if !is_here || self.inside.contains_key(&id) {
                continue;
            }
            let mut copy = signal.clone();
            let operands: Vec<[SignalId; 2]> = copy.driver.operands().map(|id| [id, self.value(id)]).collect();
            copy.driver.renumber(|id| operands.iter().find(|[old, _]| *old == id).map_or(id, |[_, new]| *new));
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
                signal.driver.operands().filter(|id| *id == input).for_each(|_| read(bits_read(signal, width)));
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
