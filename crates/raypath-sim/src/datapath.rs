//! A datapath of any operations, from which netlist and models are made.

use crate::engine::{NetlistEngine, shape};
use raypath_float::Format;
use raypath_model::{CycleModel, ModelOptions, WordModel, WordOperation};
use raypath_ops::Operation;
use raypath_rtl::dataflow::OperationGraph;
use raypath_rtl::{
    self as rtl, Budget, Config, Error, Features, Microarchitecture, OperationVisitor, Operations, Semantics,
};
use std::convert::Infallible;
use std::fmt;
use std::sync::Arc;

/// A set of operations and the configuration of their datapath.
///
/// ```
/// use raypath_sim::Datapath;
/// use raypath_ops::{RayBox, RayTriangle, Rounding, Rules};
///
/// let rules = Rules::Paper;
/// let datapath = Datapath::new().with(RayBox { rules, is_conservative: false }).with(RayTriangle { rules, rounding: Rounding::Unit });
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
    /// A datapath without operations, in the default configuration.
    pub fn new() -> Self {
        Self { config: Config::DEFAULT, budget: None, operations: Vec::new() }
    }

    /// The paper's operations that a configuration has, with its features and the paper's opcodes.
    pub fn paper(config: Config) -> Self {
        let mut datapath = Self { config, ..Self::new() };
        match config.semantics.operations(&mut datapath) {
            Ok(()) => datapath,
        }
    }

    /// Adds an operation with the lowest free opcode.
    pub fn with(self, operation: impl Operation + Send + Sync + 'static) -> Self {
        self.with_any(Arc::new(operation))
    }

    /// Adds an operation with an opcode, which [`elaborate`](Self::elaborate) checks.
    pub fn with_opcode(mut self, opcode: u64, operation: impl Operation + Send + Sync + 'static) -> Self {
        self.operations.push((opcode, Arc::new(operation)));
        self
    }

    /// As [`with`](Self::with), for an operation of any type.
    pub fn with_any(mut self, operation: Arc<dyn AnyOperation>) -> Self {
        let is_taken = |opcode: &u64| self.operations.iter().any(|(taken, _)| taken == opcode);
        let opcode = (0..).find(|opcode| !is_taken(opcode)).unwrap_or_default();
        self.operations.push((opcode, operation));
        self
    }

    /// Sets the microarchitecture.
    pub fn built_as(mut self, microarchitecture: Microarchitecture) -> Self {
        self.config.microarchitecture = microarchitecture;
        self
    }

    /// Sets the format of all numbers; binary32 by default.
    pub fn format(mut self, format: Format) -> Self {
        self.config = self.config.format(format);
        self
    }

    /// Sets the width in bits of a tag that each job carries from the port `tag_i` to the port `tag_o`; 0 for none.
    pub fn tag(mut self, width: u32) -> Self {
        self.config = self.config.tag(width);
        self
    }

    /// Sets whether there is an output port for the exceptions of the additions and multiplications of a job.
    pub fn exception_flags(mut self, are_present: bool) -> Self {
        self.config = self.config.exception_flags(are_present);
        self
    }

    /// Limits the units that an operation may use in a stage.
    pub fn within(mut self, budget: Budget) -> Self {
        self.budget = Some(budget);
        self
    }

    /// The configuration.
    pub fn config(&self) -> Config {
        self.config
    }

    /// Whether the datapath has an operation with this name.
    pub fn has(&self, name: &str) -> bool {
        self.operations.iter().any(|(_, operation)| operation.name() == name)
    }

    /// Whether the datapath has no operations.
    pub fn is_empty(&self) -> bool {
        self.operations.is_empty()
    }

    /// Removes the operation with this name. The others keep their opcodes.
    pub fn without(mut self, name: &str) -> Self {
        self.operations.retain(|(_, operation)| operation.name() != name);
        self
    }

    /// Elaborates the netlist.
    ///
    /// # Errors
    /// An opcode or a name that occurs twice; an operation with a stage that does not exist, a value that is read
    /// before it is computed, more units in a stage than the budget, or a chain that is too long for the latency; two
    /// operations whose shared units would form a loop.
    pub fn elaborate(&self) -> Result<rtl::DatapathNetlist, Error> {
        self.config.check()?;
        let mut operations = Operations::empty(self.config.semantics);
        if let Some(budget) = self.budget {
            operations = operations.within(budget);
        }
        for (opcode, operation) in &self.operations {
            operations = operation.add_to(operations, *opcode)?;
        }
        rtl::DatapathNetlist::build(operations, self.config.microarchitecture)
    }

    /// The dataflow of each operation.
    pub fn dataflows(&self) -> Vec<OperationGraph> {
        self.operations.iter().map(|(_, operation)| operation.dataflow()).collect()
    }

    /// The functional model.
    pub fn model(&self) -> WordModel {
        let Semantics { format, features: Features { tag, exception_flags, .. }, .. } = self.config.semantics;
        let operations = self.operations.iter().map(|(opcode, one)| (*opcode, one.clone() as Arc<dyn WordOperation>));
        WordModel::new(operations, ModelOptions { format, tag, exception_flags })
    }

    /// The cycle-exact model.
    ///
    /// # Errors
    /// The errors of [`elaborate`](Self::elaborate), which determines the latency.
    pub fn cycle_model(&self) -> Result<CycleModel<WordModel>, Error> {
        Ok(CycleModel::new(self.model(), &shape(self.config, &self.elaborate()?)))
    }

    /// Compiles the elaborated netlist for simulation.
    ///
    /// # Errors
    /// None occur for a result of [`elaborate`](Self::elaborate).
    pub fn netlist(&self, elaborated: &rtl::DatapathNetlist) -> Result<NetlistEngine, Error> {
        NetlistEngine::of(self.model(), self.config, elaborated, |_| false)
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

/// An operation of any type: a function on words ([`WordOperation`]) and a part of a datapath.
pub trait AnyOperation: WordOperation {
    /// Adds the operation to those of a datapath.
    ///
    /// # Errors
    /// An operation that does not fit: those of [`Operations::with`].
    fn add_to(&self, operations: Operations, opcode: u64) -> Result<Operations, Error>;

    /// The dataflow of the operation.
    fn dataflow(&self) -> OperationGraph;
}

impl<O: Operation + Send + Sync> AnyOperation for O {
    fn add_to(&self, operations: Operations, opcode: u64) -> Result<Operations, Error> {
        operations.with(self, opcode)
    }

    fn dataflow(&self) -> OperationGraph {
        rtl::dataflow::record(self)
    }
}
