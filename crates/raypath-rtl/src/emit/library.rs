use crate::allocate::plan::Plan;
use crate::config::{Control, Microarchitecture};
use crate::emit::control::{Plain, Skid};
use crate::ir::graph::{Kind, Op, OperationGraph};
use crate::ir::position::Step;
use crate::ir::units::{Unit, UnitKind, UnitWidth, sum_steps};
use raypath_float::{Format, Narrow};
use raypath_hdl::{Error, Module, Technology, divide};
use raypath_ops::{Direction, Narrowing};
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
    /// Adders of several terms in parts, by the number of terms.
    sum: BTreeMap<u32, Vec<Arc<Module>>>,
    multiply: Vec<Arc<Module>>,
    /// The multiplier with an output of what rounding takes, if the plan has it.
    pub residue: Option<Arc<Module>>,
    /// Multipliers by a short factor in parts, if the plan has short words.
    multiply_by_short: Option<Vec<Arc<Module>>>,
    compare: Arc<Module>,
    /// Units for operands with short significands, if the plan has such numbers.
    narrow: Option<NarrowUnits>,
    /// Converters of numbers to shorter significands.
    narrowings: BTreeMap<Narrowing, Arc<Module>>,
    /// Converters of words to numbers, by the words' width.
    numbers: BTreeMap<u32, Arc<Module>>,
}

/// Units whose operands have short significands.
#[derive(Debug)]
struct NarrowUnits {
    /// Multipliers by the rounding of their products, in parts.
    multiply: BTreeMap<Narrowing, Vec<Arc<Module>>>,
    compare: Arc<Module>,
    /// The decoder, whose words have no lower bits of the fraction. Narrow numbers are never subnormal.
    decode: Arc<Module>,
}

fn rounding(to: Narrowing) -> Narrow {
    Narrow { bits: to.bits, away: to.direction == Direction::AwayFromZero, margin: to.margin }
}

impl Microarchitecture {
    /// The parts of an adder, in order.
    ///
    /// # Errors
    /// A format in which the module cannot be built.
    pub fn adder_parts(self, format: Format, with_flags: bool) -> Result<Vec<Arc<Module>>, Error> {
        match self.unit_latency.sums {
            1 => Ok(vec![raypath_float::add(format, with_flags)?]),
            steps => self.divided(&raypath_float::add_to_divide(format, with_flags)?, steps),
        }
    }

    /// The parts of a multiplier, in order.
    ///
    /// # Errors
    /// A format in which the module cannot be built.
    pub fn multiplier_parts(self, format: Format, with_flags: bool) -> Result<Vec<Arc<Module>>, Error> {
        self.divided(&raypath_float::mul(format, self.multiplier.product(), with_flags)?, self.unit_latency.products)
    }

    /// The parts of another unit.
    ///
    /// # Errors
    /// Those of [`divide`].
    pub fn divided(self, unit: &Arc<Module>, steps: u32) -> Result<Vec<Arc<Module>>, Error> {
        let technology = self.multiplier.technology();
        // The weight of a bit that crosses a cut: a skid buffer has two registers for it, and multiplexers. FPGAs have
        // registers enough.
        let bit_gates = match (technology, self.control) {
            (Technology::Luts, _) => 0.0,
            (Technology::Gates, Control::Skid) => 60.0,
            (Technology::Gates, Control::Credit) => 25.0,
        };
        divide(unit, steps, technology, bit_gates)
    }
}

impl Library {
    /// The modules of a plan, whose adders and multipliers report exceptions if `with_flags`.
    pub fn new(plan: &Plan, with_flags: bool) -> Result<Self, Error> {
        let Microarchitecture { unit_latency, multiplier, .. } = plan.microarchitecture;
        let (format, product) = (plan.format, multiplier.product());
        let divided = |unit, steps| plan.microarchitecture.divided(&unit, steps);
        let mut numbers = BTreeMap::new();
        for width in plan.operations.iter().flat_map(word_widths) {
            numbers.insert(width, raypath_float::number(format, width)?);
        }
        let mut sum = BTreeMap::new();
        for node in plan.operations.iter().flat_map(|graph| &graph.nodes) {
            if let Op::Sum(terms) = &node.op {
                let terms = terms.len() as u32;
                sum.insert(terms, divided(raypath_float::sum(format, terms)?, sum_steps(terms))?);
            }
        }
        let mut narrowings = BTreeMap::new();
        for to in plan.operations.iter().flat_map(|graph| &graph.nodes).filter_map(|node| node.op.narrowing()) {
            narrowings.insert(to, raypath_float::narrow(format, rounding(to))?);
        }
        let narrow = plan.widths.narrow().map(|operand| {
            let mut multiply = BTreeMap::new();
            for to in narrowings.keys().filter(|to| to.margin == 0) {
                let unit = raypath_float::mul_narrow(format, operand, rounding(*to))?;
                multiply.insert(*to, divided(unit, unit_latency.products)?);
            }
            let compare = raypath_float::compare_narrow(format, operand)?;
            let decode = raypath_float::decode_narrow(format, operand)?;
            Ok::<_, Error>(NarrowUnits { multiply, compare, decode })
        });
        let by_short = |bits| divided(raypath_float::mul_by_short(format, bits, product)?, unit_latency.products);
        let multiply_by_short = plan.widths.factor().map(by_short).transpose()?;
        let mut nodes = plan.operations.iter().flat_map(|graph| &graph.nodes);
        let has_residue = nodes.any(|node| matches!(node.op, Op::Residue(..)));
        Ok(Self {
            format,
            multiply_by_short,
            skid: Skid::module()?,
            skid_buffer: Skid::buffer()?,
            register: Plain::buffer()?,
            encode: raypath_float::encode(format)?,
            decode: raypath_float::decode(format)?,
            add: plan.microarchitecture.adder_parts(format, with_flags)?,
            sum,
            multiply: plan.microarchitecture.multiplier_parts(format, with_flags)?,
            residue: has_residue.then(|| raypath_float::mul_with_residue(format, product)).transpose()?,
            compare: raypath_float::compare(format)?,
            narrow: narrow.transpose()?,
            narrowings,
            numbers,
        })
    }

    /// The module of a unit's part.
    pub fn unit(&self, unit: Unit) -> &Arc<Module> {
        let part = unit.part as usize;
        match (unit.width, &self.narrow) {
            (UnitWidth::Rounding(to), Some(narrow)) => return &narrow.multiply[&to][part],
            (UnitWidth::Short, Some(narrow)) => return &narrow.compare,
            (UnitWidth::ShortFactor(_), _) => return &self.multiply_by_short.as_ref().unwrap_or(&self.multiply)[part],
            (UnitWidth::Terms(terms), _) => return &self.sum[&terms][part],
            _ => {}
        }
        match unit.kind {
            UnitKind::Encode => &self.encode,
            UnitKind::Add | UnitKind::Sum => &self.add[part],
            UnitKind::Multiply => &self.multiply[part],
            UnitKind::Compare => &self.compare,
            UnitKind::Decode => &self.decode,
        }
    }

    /// The converter of words of `width` bits to numbers, if the plan has one.
    pub fn number(&self, width: u32) -> Option<&Arc<Module>> {
        self.numbers.get(&width)
    }

    /// The converter of numbers to a shorter significand, if the plan has it.
    pub fn narrowing(&self, to: Narrowing) -> Option<&Arc<Module>> {
        self.narrowings.get(&to)
    }

    /// The decoder of numbers with short significands, if the plan has narrow units.
    pub fn decode_narrow(&self) -> Option<&Arc<Module>> {
        self.narrow.as_ref().map(|narrow| &narrow.decode)
    }

    /// The kind of unit that a module is, or is a part of.
    pub fn kind(&self, module: &Arc<Module>) -> Option<UnitKind> {
        let is = |parts: &[Arc<Module>]| parts.iter().any(|part| Arc::ptr_eq(part, module));
        match &self.narrow {
            Some(narrow) if narrow.multiply.values().any(|parts| is(parts)) => return Some(UnitKind::Multiply),
            Some(narrow) if Arc::ptr_eq(&narrow.compare, module) => return Some(UnitKind::Compare),
            Some(narrow) if Arc::ptr_eq(&narrow.decode, module) => return Some(UnitKind::Decode),
            _ => {}
        }
        UnitKind::ALL.into_iter().find(|kind| match kind {
            UnitKind::Encode => Arc::ptr_eq(&self.encode, module),
            UnitKind::Add => is(&self.add),
            UnitKind::Sum => self.sum.values().any(|parts| is(parts)),
            UnitKind::Multiply => {
                is(&self.multiply) || is(self.residue.as_slice()) || self.multiply_by_short.as_deref().is_some_and(is)
            }
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
