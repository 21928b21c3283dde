//! A datapath of any operations: the one list from which hardware and models are made.

use crate::engine::{NetlistEngine, shape};
use crate::operation::AnyOperation;
use raypath_float::Format;
use raypath_model::{CycleModel, ModelOptions, Shape, WordModel, WordOperation};
use raypath_ops::Operation;
use raypath_rtl::{
    self as rtl, Budget, Config, Error, Features, Microarchitecture, OperationVisitor, Operations, Semantics,
};
use std::convert::Infallible;
use std::fmt;
use std::sync::Arc;

/// A set of operations and how they are built.
///
/// ```
/// use raypath_sim::Datapath;
/// use raypath_ops::{RayBox, RayTriangle, Rules};
///
/// let rules = Rules::Paper;
/// let datapath = Datapath::new().with(RayBox { rules }).with(RayTriangle { rules });
/// let netlist = datapath.elaborate()?;
/// assert_eq!((netlist.latency(), netlist.units(2).add), (12, 24));
/// # Ok::<(), raypath_rtl::Error>(())
/// ```
#[derive(Clone)]
pub struct Datapath {
    config: Config,
    budget: Option<Budget>,
    operations: Vec<(u64, Arc<dyn AnyOperation>)>,
}

impl Datapath {
    /// None yet, built as by default.
    pub fn new() -> Self {
        Self { config: Config::DEFAULT, budget: None, operations: Vec::new() }
    }

    /// The operations that a configuration has, with its features, under the paper's opcodes.
    pub fn paper(config: Config) -> Self {
        let mut datapath = Self { config, ..Self::new() };
        match config.semantics.operations(&mut datapath) {
            Ok(()) => datapath,
        }
    }

    /// Adds an operation under the lowest opcode that is free.
    pub fn with(self, operation: impl Operation + Send + Sync + 'static) -> Self {
        self.with_any(Arc::new(operation))
    }

    /// Adds an operation under an opcode, which is checked when the datapath is elaborated.
    pub fn with_opcode(mut self, opcode: u64, operation: impl Operation + Send + Sync + 'static) -> Self {
        self.operations.push((opcode, Arc::new(operation)));
        self
    }

    /// [`with`](Self::with), of an operation whose type is forgotten.
    pub fn with_any(mut self, operation: Arc<dyn AnyOperation>) -> Self {
        let is_taken = |opcode: &u64| self.operations.iter().any(|(taken, _)| taken == opcode);
        let opcode = (0..).find(|opcode| !is_taken(opcode)).unwrap_or_default();
        self.operations.push((opcode, operation));
        self
    }

    /// Sets how the datapath is built.
    pub fn built_as(mut self, microarchitecture: Microarchitecture) -> Self {
        self.config.microarchitecture = microarchitecture;
        self
    }

    /// Sets the format of all numbers; binary32 by default.
    pub fn format(mut self, format: Format) -> Self {
        self.config = self.config.format(format);
        self
    }

    /// Has every job carry a word of so many bits from the port `tag_i` to the port `tag_o`; 0 for none.
    pub fn tag(mut self, width: u32) -> Self {
        self.config = self.config.tag(width);
        self
    }

    /// Adds an output port for the exceptions of all additions and multiplications of a job.
    pub fn exception_flags(mut self, are_present: bool) -> Self {
        self.config = self.config.exception_flags(are_present);
        self
    }

    /// Allows no operation more units in a stage than this.
    pub fn within(mut self, budget: Budget) -> Self {
        self.budget = Some(budget);
        self
    }

    /// How they are built.
    pub fn config(&self) -> Config {
        self.config
    }

    /// Whether it has an operation of this name.
    pub fn has(&self, name: &str) -> bool {
        self.operations.iter().any(|(_, operation)| operation.name() == name)
    }

    /// Whether it has no operation.
    pub fn is_empty(&self) -> bool {
        self.operations.is_empty()
    }

    /// The same without the operation of this name; others keep their opcodes.
    pub fn without(mut self, name: &str) -> Self {
        self.operations.retain(|(_, operation)| operation.name() != name);
        self
    }

    /// The netlist.
    ///
    /// # Errors
    /// An operation that does not fit: an opcode or a name that is taken, a stage that is not there, a value that is
    /// read before it is made, more units in a stage than the budget allows, a chain that is too long for the latency;
    /// two operations whose shared units would feed each other.
    pub fn elaborate(&self) -> Result<rtl::Datapath, Error> {
        self.config.check()?;
        let Semantics { format, features: Features { tag, exception_flags, .. }, .. } = self.config.semantics;
        let mut operations = Operations::new().format(format).tag(tag).exception_flags(exception_flags);
        if let Some(budget) = self.budget {
            operations = operations.within(budget);
        }
        for (opcode, operation) in &self.operations {
            operations = operation.add_to(operations, *opcode)?;
        }
        rtl::Datapath::build(operations, self.config.microarchitecture)
    }

    /// What it answers, job by job.
    pub fn model(&self) -> WordModel {
        let Semantics { format, features: Features { tag, exception_flags, .. }, .. } = self.config.semantics;
        let operations = self.operations.iter().map(|(opcode, one)| (*opcode, one.clone() as Arc<dyn WordOperation>));
        WordModel::new(operations, ModelOptions { format, tag, exception_flags })
    }

    /// What it shows in every cycle.
    ///
    /// # Errors
    /// Those of [`elaborate`](Self::elaborate): the latency follows from the netlist's steps.
    pub fn cycle_model(&self) -> Result<CycleModel<WordModel>, Error> {
        let shape = self.shape()?;
        Ok(CycleModel::new(self.model(), &shape))
    }

    /// The netlist, compiled, as an engine.
    ///
    /// # Errors
    /// Those of [`elaborate`](Self::elaborate).
    pub fn netlist(&self, elaborated: &rtl::Datapath) -> Result<NetlistEngine, Error> {
        NetlistEngine::of(self.model(), self.config, elaborated, |_| false)
    }

    fn shape(&self) -> Result<Shape, Error> {
        Ok(shape(self.config, &self.elaborate()?))
    }
}

impl OperationVisitor for Datapath {
    type Error = Infallible;

    fn visit<O: Operation + Send + Sync + 'static>(&mut self, operation: O, opcode: u64) -> Result<(), Infallible> {
        self.operations.push((opcode, Arc::new(operation)));
        Ok(())
    }
}

impl Default for Datapath {
    fn default() -> Self {
        Self::new()
    }
}

impl fmt::Debug for Datapath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let operations: Vec<_> =
            self.operations.iter().map(|(opcode, operation)| format!("{opcode} {}", operation.name())).collect();
        f.debug_struct("Datapath").field("operations", &operations).field("config", &self.config).finish()
    }
}
