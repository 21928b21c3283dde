use crate::boundary::label;
use crate::budget::Budget;
use crate::config::{Config, Encoding, Features, Microarchitecture, OperationVisitor, Semantics};
use crate::error::Error;
use crate::graph::Traced;
use crate::library::Library;
use crate::plan::{Plan, StepPlan};
use crate::properties::Properties;
use crate::schedule::{self, Target};
use crate::stage::{self, notes};
use crate::steps::Step;
use crate::top::{self, Pipeline};
use crate::tracer::Marks;
use crate::units::Units;
use raypath_float::Format;
use raypath_hdl::{Label, Module};
use raypath_ops::{Binary32, Operation, Port, ports_of};
use std::sync::Arc;

/// A datapath, elaborated: its netlist, and what can be said of it.
#[derive(Debug)]
pub struct Datapath {
    plan: Plan,
    library: Library,
    pipeline: Pipeline,
}

/// Operations of a datapath at most: more than share anything.
pub const MOST_OPERATIONS: u64 = 64;

/// The operations of a datapath, each with its opcode. Their order is that of ports, tables and comments.
#[derive(Debug)]
pub struct Operations {
    traced: Vec<Traced>,
    marks: Marks,
    budget: Option<Budget>,
    format: Format,
    tag: u32,
    exception_flags: bool,
    ports: Vec<Claim>,
}

/// A port that an operation has.
#[derive(Debug)]
struct Claim {
    name: String,
    is_input: bool,
    /// None for a number.
    width: Option<u32>,
    operation: &'static str,
}

impl Claim {
    fn clashes_with(&self, other: &Self) -> bool {
        let is_same = (self.is_input, &self.name) == (other.is_input, &other.name);
        let are_alike = match (self.width, other.width) {
            (Some(_), Some(_)) if self.is_input => true,
            (ours, theirs) => ours == theirs,
        };
        is_same && (!are_alike || self.operation == other.operation)
    }
}

/// Those ports that are there.
fn those(mut ports: Vec<Port>, are_there: &dyn Fn(&str) -> bool) -> Vec<Port> {
    ports.retain(|port| are_there(&port.name));
    ports
}

/// A port's width: `a number`, `1 bit`, `4 bits`.
fn in_words(width: Option<u32>) -> String {
    match width {
        None => "a number".to_string(),
        Some(1) => "1 bit".to_string(),
        Some(width) => format!("{width} bits"),
    }
}

impl Operations {
    /// The empty set.
    pub fn new() -> Self {
        Self {
            traced: Vec::new(),
            marks: Marks::default(),
            budget: None,
            format: Format::BINARY32,
            tag: 0,
            exception_flags: false,
            ports: Vec::new(),
        }
    }

    /// Adds an operation under an opcode of its own, below [`MOST_OPERATIONS`]; the port is as wide as the largest
    /// needs.
    ///
    /// # Errors
    /// An operation that does not fit the pipeline: a stage that is not there, a value that is read before it is made,
    /// state that is read elsewhere than its next value is made; stages that are marked beside
    /// [`auto`](raypath_ops::Circuit::auto), or a chain of units that is too long for it; an opcode that is taken or
    /// too large; a name that is taken or no identifier; a port that another has otherwise, or that it has twice.
    pub fn with<O: Operation>(mut self, operation: &O, opcode: u64) -> Result<Self, Error> {
        let inputs = those(ports_of::<O::Input<Binary32>>(), &|port| operation.has_input(port));
        let outputs = those(ports_of::<O::Output<Binary32>>(), &|port| operation.has_output(port));
        self.claim(O::NAME, opcode, inputs, outputs)?;
        self.traced.push(Traced::new(operation, opcode, self.marks)?);
        Ok(self)
    }

    /// Sets the format of all numbers; binary32 by default.
    pub fn format(mut self, format: Format) -> Self {
        self.format = format;
        self
    }

    /// Has every operation take a word of `width` bits along, from the port `tag_i` to the port `tag_o`, unchanged: 1
    /// to
    /// [`Features::MAX_TAG_WIDTH`]; 0 for none.
    pub fn tag(mut self, width: u32) -> Self {
        self.tag = width;
        self
    }

    /// Has every operation answer the exceptions of all its additions and multiplications, at the port
    /// `exception_flags_o`: the bits of [`raypath_float::flags`].
    pub fn exception_flags(mut self, are_there: bool) -> Self {
        self.exception_flags = are_there;
        self
    }

    /// Stages the operations that are added from here on automatically, whatever stages they mark
    /// (`docs/extending/staging.md`).
    pub fn auto(mut self) -> Self {
        self.marks = Marks::Ignored;
        self
    }

    /// Allows no operation more units in a stage than `budget` does. Whoever marks stages must keep to it; what is
    /// staged automatically is staged so. Without a budget, what is staged automatically uses the units that other
    /// operations have, and as few others as possible.
    pub fn within(mut self, budget: Budget) -> Self {
        self.budget = Some(budget);
        self
    }

    /// Its opcode, its name and its ports are the operation's. Ports of one name are one port, which an operation must
    /// not have twice. Outputs must be as wide as each other; of an input that is a word or flags, an operation may
    /// read the lowest bits alone.
    fn claim(
        &mut self,
        operation: &'static str,
        opcode: u64,
        inputs: Vec<Port>,
        outputs: Vec<Port>,
    ) -> Result<(), Error> {
        let taken = self.traced.iter().find(|traced| traced.opcode == opcode).map(|traced| traced.name);
        if taken.is_some() || opcode >= MOST_OPERATIONS {
            return Err(Error::Opcode { operation, opcode, taken });
        }
        let is_taken = self.traced.iter().any(|traced| traced.name == operation);
        if is_taken || !is_identifier(operation) {
            return Err(Error::Name { operation, is_taken });
        }
        let inputs = inputs.into_iter().map(|port| (port, true));
        for (port, is_input) in inputs.chain(outputs.into_iter().map(|port| (port, false))) {
            let claim = Claim { name: port.name, is_input, width: port.width, operation };
            if let Some(other) = self.ports.iter().find(|other| other.clashes_with(&claim)) {
                let [ours, theirs] = [claim.width, other.width].map(in_words);
                let port = format!("{}_{}", claim.name, if is_input { "i" } else { "o" });
                return Err(Error::Port { operation, port, ours, other: other.operation, theirs });
            }
            self.ports.push(claim);
        }
        Ok(())
    }

    /// Their records, with all stages known.
    fn staged(mut self, microarchitecture: Microarchitecture) -> Result<Vec<Traced>, Error> {
        Features::check_tag(self.tag)?;
        if self.tag > 0 {
            self.traced.iter_mut().try_for_each(|traced| traced.add_tag(self.tag))?;
        }
        if self.exception_flags {
            self.traced.iter_mut().try_for_each(Traced::count_exceptions)?;
        }
        self.traced.iter_mut().for_each(Traced::forget_unread);
        let Microarchitecture { registers, sharing, .. } = microarchitecture;
        let number_width = match registers {
            Encoding::Ieee => self.format.ieee_width(),
            Encoding::Recoded => self.format.recoded_width(),
        };
        schedule::assign(self.traced, &Target { budget: self.budget, number_width, sharing })
    }
}

impl Default for Operations {
    fn default() -> Self {
        Self::new()
    }
}

impl OperationVisitor for Operations {
    type Error = Error;

    fn visit<O: Operation + Send + Sync + 'static>(&mut self, operation: O, opcode: u64) -> Result<(), Error> {
        *self = std::mem::take(self).with(&operation, opcode)?;
        Ok(())
    }
}

/// What an operation does in a step: a cell of Table VII.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StageNote {
    /// The operation.
    pub operation: &'static str,
    /// In words; empty where it only passes.
    pub what: String,
    /// The units that it uses.
    pub units: Units,
}

/// An operation that reads its state in one step and writes it in a later one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StateLoop {
    /// The operation.
    pub operation: &'static str,
    /// Its opcode.
    pub opcode: u64,
    /// The step that reads the state first, by its place in [`Datapath::steps`].
    pub first: u32,
    /// The step that writes it: a job may follow `last - first + 1` cycles after the one before, and not earlier.
    pub last: u32,
}

/// Register bits after a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Registers {
    /// Bits of a job that must cross, opcode included.
    pub live: u64,
    /// Data registers: `live` twice in skid buffers, `live` once where nothing stalls, and a place for every job in the
    /// exit's FIFO.
    pub data: u64,
    /// Valid, ready, credits, pointers.
    pub control: u64,
    /// Accumulators.
    pub state: u64,
}

impl Datapath {
    /// Elaborates a configuration of the paper's operations.
    ///
    /// # Errors
    /// Features that cannot be had as they are asked for ([`Config::check`]). These operations fit.
    pub fn new(config: Config) -> Result<Self, Error> {
        config.check()?;
        let Semantics { format, features, .. } = config.semantics;
        let mut operations =
            Operations::new().format(format).tag(features.tag).exception_flags(features.exception_flags);
        config.semantics.operations(&mut operations)?;
        Self::build(operations, config.microarchitecture)
    }

    /// Elaborates any set of operations, built as by default.
    ///
    /// # Errors
    /// More units in a stage than the budget allows; operations that use the units of a stage in orders that make a
    /// loop, or whose names cannot be printed; an automatic schedule that reads state elsewhere than its next value is
    /// made; a value that nothing brings to where it is read; a tag that is too wide, or whose port an operation has.
    pub fn of(operations: Operations) -> Result<Self, Error> {
        Self::build(operations, Microarchitecture::DEFAULT)
    }

    /// Elaborates any set of operations with this microarchitecture.
    ///
    /// # Errors
    /// Those of [`Datapath::of`].
    pub fn build(operations: Operations, microarchitecture: Microarchitecture) -> Result<Self, Error> {
        let Operations { format, exception_flags: with_flags, .. } = operations;
        let plan = Plan::new(&operations.staged(microarchitecture)?, format, microarchitecture);
        let library = Library::new(&plan, with_flags)?;
        let pipeline = top::pipeline(&plan, &library, &description(&plan))?;
        Ok(Self { plan, library, pipeline })
    }

    /// The module `raypath`.
    pub fn top(&self) -> &Arc<Module> {
        &self.pipeline.top
    }

    /// The opcodes by the names that the printed modules have for them (`OpQuadbox`), in rising order.
    pub fn opcodes(&self) -> Vec<Label> {
        let mut labels: Vec<Label> = self.plan.operations.iter().map(label).collect();
        labels.sort_by_key(|label| label.value);
        labels
    }

    /// Checkers of what the pipeline's control promises, and where they are bound.
    pub fn properties(&self) -> Properties {
        Properties::new(&self.plan, &self.pipeline)
    }

    /// The steps of the pipeline, each with the registers after it; the first is the input's registers alone. Where
    /// units take one step they are the stages of Table VII.
    pub fn steps(&self) -> impl Iterator<Item = Step> + '_ {
        self.plan.steps.iter().map(|plan| plan.step)
    }

    /// The module of a step, by its place in [`Datapath::steps`].
    pub fn module(&self, step: usize) -> Option<&Arc<Module>> {
        self.pipeline.steps.get(step)
    }

    /// Cycles from the one in which a job is accepted to the one that shows its outcome, in an empty pipeline.
    pub fn latency(&self) -> u32 {
        self.plan.latency()
    }

    /// Its operations and their opcodes, in the order of [`schedule`](Self::schedule).
    pub fn operations(&self) -> Vec<(&'static str, u64)> {
        self.plan.operations.iter().map(|traced| (traced.name, traced.opcode)).collect()
    }

    /// Operations whose jobs may not follow each other at once, because their state goes through a unit of several
    /// steps.
    pub fn loops(&self) -> Vec<StateLoop> {
        let loops = self.plan.operations.iter().filter(|traced| traced.is_loop());
        loops
            .map(|traced| StateLoop {
                operation: traced.name,
                opcode: traced.opcode,
                first: traced.states.iter().map(|state| state.read).min().unwrap_or(0),
                last: traced.states.iter().map(|state| state.written).max().unwrap_or(0),
            })
            .collect()
    }

    /// What each operation does in a step, in words and units.
    pub fn schedule(&self, step: usize) -> Vec<StageNote> {
        let Some(plan) = self.plan.steps.get(step) else { return Vec::new() };
        let operations = self.plan.operations.iter().zip(&plan.bindings);
        operations
            .enumerate()
            .map(|(op, (traced, bindings))| {
                let mut units = self.plan.conversions(step, op);
                for binding in bindings.values() {
                    *units.of_mut(binding.unit.kind) += 1;
                }
                StageNote { operation: traced.name, what: notes(&self.plan, traced, step), units }
            })
            .collect()
    }

    /// The units of a step, counted in the netlist; where a unit has several parts, each counts in its own step.
    pub fn units(&self, step: usize) -> Units {
        let mut units = Units::default();
        for instance in self.module(step).iter().flat_map(|module| module.instances()) {
            if let Some(kind) = self.library.kind(&instance.module) {
                *units.of_mut(kind) += 1;
            }
        }
        units
    }

    /// The registers after a step, counted in the netlist. What lets jobs in counts as the input's.
    pub fn registers(&self, step: usize) -> Registers {
        let (Some(module), Some(plan)) = (self.module(step), self.plan.steps.get(step)) else {
            return Registers::default();
        };
        let own = |with_reset: bool| -> u64 {
            let chosen = module.registers().iter().filter(|register| register.reset.is_some() == with_reset);
            chosen.map(|register| u64::from(module.signal(register.signal).width)).sum()
        };
        let layout = &plan.layout;
        let cuts = layout.cuts.iter().flat_map(|&unit| self.library.cut(unit)).map(|(_, width)| u64::from(width));
        let numbers = layout.numbers as u64 * u64::from(self.plan.number_width(step));
        let live = u64::from(self.plan.opcode_width()) + numbers + u64::from(layout.flags) + cuts.sum::<u64>();
        let states =
            self.plan.operations.iter().flat_map(|traced| traced.states.iter().map(move |state| (traced, state)));
        let here = states.filter(|(_, state)| state.written as usize == step);
        let state = here.map(|(traced, state)| u64::from(stage::width(traced, state, &self.library))).sum();
        let below: u64 = module.instances().iter().map(|instance| instance.module.register_bits()).sum();
        let entrance = self.pipeline.credit.iter().filter(|_| step == 0).map(|module| module.register_bits());
        let control = own(true) - state + below + entrance.sum::<u64>();
        Registers { live, data: own(false), control, state }
    }
}

/// Whether a name can be part of labels, states and ports as it is.
fn is_identifier(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

impl Registers {
    /// All flip-flops.
    pub fn flip_flops(self) -> u64 {
        self.data + self.control + self.state
    }
}

/// The head comment of the top module: Table VII, column by column.
fn description(plan: &Plan) -> Vec<String> {
    let mut operations: Vec<&Traced> = plan.operations.iter().collect();
    operations.sort_by_key(|traced| traced.opcode);
    let opcodes: Vec<String> = operations.iter().map(|traced| format!("{} {}", traced.opcode, traced.name)).collect();
    let mut lines = vec![
        format!("A ray-tracer datapath: one job a cycle, latency {}, ready and valid at both ends.", plan.latency()),
        format!("Opcodes: {}.", opcodes.join(", ")),
    ];
    for traced in plan.operations.iter().filter(|traced| traced.is_loop()) {
        let (name, cycles) = (traced.name, traced.spacing() + 1);
        lines.push(format!("A job of {name} may follow another one of {name} {cycles} cycles later, not before."));
    }
    for traced in &plan.operations {
        lines.extend([String::new(), format!("{}, stage by stage:", traced.name)]);
        for (index, StepPlan { step, .. }) in plan.steps.iter().enumerate().filter(|(_, plan)| plan.step.part == 1) {
            let what = notes(plan, traced, index);
            if !what.is_empty() {
                lines.push(format!("  {:>2}  {what}", step.stage));
            }
        }
    }
    lines
}
