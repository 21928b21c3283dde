use crate::allocate::plan::Plan;
use crate::emit::control::{Plain, Skid};
use crate::ir::graph::{Kind, Op, OperationGraph};
use crate::ir::position::Step;
use crate::ir::units::{Unit, UnitKind};
use raypath_float::Format;
use raypath_hdl::{Error, Module};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The modules that steps instantiate, each built once.
#[derive(Debug)]
pub struct Library {
    pub format: Format,
    /// The control of skid buffers.
    pub skid: Arc<Module>,
    /// A skid buffer in the text: control and data.
    pub skid_buffer: Arc<Module>,
    /// A register that never stalls, in the text: control and data.
    pub register: Arc<Module>,
    pub encode: Arc<Module>,
    pub decode: Arc<Module>,
    add: Vec<Arc<Module>>,
    multiply: Vec<Arc<Module>>,
    compare: Arc<Module>,
    /// Converters of words to numbers, by the words' width.
    numbers: BTreeMap<u32, Arc<Module>>,
}

impl Library {
    /// The modules of a plan, whose adders and multipliers report exceptions if `with_flags`.
    pub fn new(plan: &Plan, with_flags: bool) -> Result<Self, Error> {
        let (format, parts) = (plan.format, plan.microarchitecture.unit_latency.steps());
        let mut numbers = BTreeMap::new();
        for width in plan.operations.iter().flat_map(word_widths) {
            numbers.insert(width, raypath_float::number(format, width)?);
        }
        Ok(Self {
            format,
            skid: Skid::module()?,
            skid_buffer: Skid::buffer()?,
            register: Plain::buffer()?,
            encode: raypath_float::encode(format)?,
            decode: raypath_float::decode(format)?,
            add: raypath_float::add_parts(format, parts, with_flags)?,
            multiply: plan.microarchitecture.multiplier.parts(format, parts, with_flags)?,
            compare: raypath_float::compare(format)?,
            numbers,
        })
    }

    /// The module of a unit's part.
    pub fn unit(&self, unit: Unit) -> &Arc<Module> {
        let part = unit.part as usize;
        match unit.kind {
            UnitKind::Encode => &self.encode,
            UnitKind::Add => &self.add[part],
            UnitKind::Multiply => &self.multiply[part],
            UnitKind::Compare => &self.compare,
            UnitKind::Decode => &self.decode,
        }
    }

    /// The converter of words of `width` bits to numbers, if the plan has one.
    pub fn number(&self, width: u32) -> Option<&Arc<Module>> {
        self.numbers.get(&width)
    }

    /// The kind of unit that a module is, or is a part of.
    pub fn kind(&self, module: &Arc<Module>) -> Option<UnitKind> {
        let is = |parts: &[Arc<Module>]| parts.iter().any(|part| Arc::ptr_eq(part, module));
        UnitKind::ALL.into_iter().find(|kind| match kind {
            UnitKind::Encode => Arc::ptr_eq(&self.encode, module),
            UnitKind::Add => is(&self.add),
            UnitKind::Multiply => is(&self.multiply),
            UnitKind::Compare => Arc::ptr_eq(&self.compare, module),
            UnitKind::Decode => Arc::ptr_eq(&self.decode, module),
        })
    }

    /// The registers after a unit's part that is not the last: their stems and widths.
    pub fn cut(&self, unit: Unit) -> impl Iterator<Item = (&str, u32)> {
        let module = self.unit(unit);
        module.outputs().iter().map(|port| (port.stem(), module.signal(port.signal).width))
    }
}

/// The widths of the words that an operation converts to numbers.
fn word_widths(traced: &OperationGraph<Step>) -> impl Iterator<Item = u32> {
    traced.nodes.iter().filter_map(|node| match node.op {
        Op::NumberOf(word) => match traced.node(word).kind {
            Kind::Word(width) => Some(width),
            _ => None,
        },
        _ => None,
    })
}
