use crate::allocate::plan::Plan;
use crate::config::{Control, Interval, Microarchitecture, Multiplier};
use crate::emit::control::{Plain, Skid};
use crate::ir::graph::{Kind, Op, OperationGraph};
use crate::ir::position::Step;
use crate::ir::units::{Unit, UnitKind, UnitWidth, sum_steps};
use raypath_float::{Format, Narrow};
use raypath_hdl::{Driver, Error, Module, Technology, divide, with_multipliers};
use raypath_ops::{Direction, Narrowing};
use std::collections::{BTreeMap, BTreeSet};
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
    multiply: Multipliers,
    /// The multiplier with an output of what rounding takes, if the plan has it.
    pub residue: Option<Arc<Module>>,
    /// Multipliers by a short factor in parts, if the plan has short words.
    multiply_by_short: Option<Multipliers>,
    compare: Vec<Arc<Module>>,
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
    compare: Vec<Arc<Module>>,
    /// The decoder, whose words have no lower bits of the fraction. Narrow numbers are never subnormal.
    decode: Arc<Module>,
}

/// Multipliers in parts.
#[derive(Debug, Default)]
struct Multipliers {
    parts: Vec<Arc<Module>>,
    /// With DSP blocks: the words between parts that are in their registers, by the part before and the stem.
    inside: BTreeSet<(u32, String)>,
}

impl Multipliers {
    fn new(mut parts: Vec<Arc<Module>>, multiplier: Multiplier) -> Result<Self, Error> {
        let mut inside = BTreeSet::new();
        let has_product = |part: &Arc<Module>| part.signals().iter().any(|s| matches!(s.driver, Driver::Mul(..)));
        if multiplier == Multiplier::Dsp
            && let Some(place) = parts.iter().position(has_product)
        {
            let made = with_multipliers(&parts[place], raypath_float::multiplier)?;
            let before = (place as u32).saturating_sub(1);
            inside.extend(made.inputs.into_iter().map(|stem| (before, stem)));
            inside.extend(made.outputs.into_iter().map(|stem| (place as u32, stem)));
            parts[place] = made.module;
        }
        Ok(Self { parts, inside })
    }
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
            steps => {
                let technology = self.multiplier.technology();
                self.divided(&raypath_float::add_to_divide(format, with_flags, technology)?, steps)
            }
        }
    }

    /// The parts of a multiplier, in order.
    ///
    /// # Errors
    /// A format in which the module cannot be built.
    pub fn multiplier_parts(self, format: Format, with_flags: bool) -> Result<Vec<Arc<Module>>, Error> {
        let product = self.multiplier.product();
        match self.unit_latency.products {
            1 => Ok(vec![raypath_float::mul(format, product, with_flags)?]),
            steps => self.divided(&raypath_float::mul_to_divide(format, product, with_flags)?, steps),
        }
    }

    /// The steps of a comparator. In rounds, what several comparators determine is computed in the step of all of them.
    pub(crate) fn comparator_steps(self) -> u32 {
        if self.unit_latency.sums < 4 || self.interval != Interval::One { 1 } else { 2 }
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
            let compare =
                divided(raypath_float::compare_narrow(format, operand)?, plan.microarchitecture.comparator_steps())?;
            let decode = raypath_float::decode_narrow(format, operand)?;
            Ok::<_, Error>(NarrowUnits { multiply, compare, decode })
        });
        let by_short = |bits| {
            let parts = divided(raypath_float::mul_by_short(format, bits, product)?, unit_latency.products)?;
            Multipliers::new(parts, multiplier)
        };
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
            multiply: Multipliers::new(plan.microarchitecture.multiplier_parts(format, with_flags)?, multiplier)?,
            residue: has_residue.then(|| raypath_float::mul_with_residue(format, product)).transpose()?,
            compare: divided(raypath_float::compare(format)?, plan.microarchitecture.comparator_steps())?,
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
            (UnitWidth::Short, Some(narrow)) => return &narrow.compare[part],
            (UnitWidth::ShortFactor(_), _) => return &self.by_short().parts[part],
            (UnitWidth::Terms(terms), _) => return &self.sum[&terms][part],
            _ => {}
        }
        match unit.kind {
            UnitKind::Encode => &self.encode,
            UnitKind::Add | UnitKind::Sum => &self.add[part],
            UnitKind::Multiply => &self.multiply.parts[part],
            UnitKind::Compare => &self.compare[part],
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
            Some(narrow) if is(&narrow.compare) => return Some(UnitKind::Compare),
            Some(narrow) if Arc::ptr_eq(&narrow.decode, module) => return Some(UnitKind::Decode),
            _ => {}
        }
        UnitKind::ALL.into_iter().find(|kind| match kind {
            UnitKind::Encode => Arc::ptr_eq(&self.encode, module),
            UnitKind::Add => is(&self.add),
            UnitKind::Sum => self.sum.values().any(|parts| is(parts)),
            UnitKind::Multiply => is(&self.multiply.parts) || is(self.residue.as_slice()) || is(&self.by_short().parts),
            UnitKind::Compare => is(&self.compare),
            UnitKind::Decode => Arc::ptr_eq(&self.decode, module),
        })
    }

    fn by_short(&self) -> &Multipliers {
        self.multiply_by_short.as_ref().unwrap_or(&self.multiply)
    }

    /// Whether a word after a unit's part is in a register of a DSP block, and not of the boundary.
    pub fn is_inside(&self, unit: Unit, stem: &str) -> bool {
        let multipliers = match unit.width {
            UnitWidth::ShortFactor(_) => self.by_short(),
            _ => &self.multiply,
        };
        let is_one = unit.kind == UnitKind::Multiply && !matches!(unit.width, UnitWidth::Rounding(_));
        is_one && multipliers.inside.contains(&(unit.part, stem.to_string()))
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
