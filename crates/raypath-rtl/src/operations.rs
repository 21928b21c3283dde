//! The set of operations that a datapath is built from.

use crate::config::{Config, Encoding, Features, Microarchitecture, OperationVisitor, Semantics};
use crate::error::Error;
use crate::ir::graph::{MAX_OPERATIONS, Op, OperationGraph};
use crate::ir::position::{SHORT_STAGES, STAGES, Stage};
use crate::ir::recorder::{self, Marks};
use crate::schedule::{self, Budget, Target};
use raypath_float::Format;
use raypath_ops::{Binary32, Operation, Port, Rounding, ports_of};

/// A set of operations, each with its opcode, in the order of ports, tables and comments.
#[derive(Debug)]
pub struct Operations {
    graphs: Vec<OperationGraph<Stage>>,
    marks: Marks,
    budget: Option<Budget>,
    pub(crate) format: Format,
    tag: u32,
    pub(crate) exception_flags: bool,
    rounding: Rounding,
    ports: Vec<PortUse>,
}

/// A port of an operation.
#[derive(Debug)]
struct PortUse {
    name: String,
    is_input: bool,
    /// `None` for a number.
    width: Option<u32>,
    operation: &'static str,
}

impl PortUse {
    fn clashes_with(&self, other: &Self) -> bool {
        let is_same = (self.is_input, &self.name) == (other.is_input, &other.name);
        let are_compatible = match (self.width, other.width) {
            (Some(_), Some(_)) if self.is_input => true,
            (ours, theirs) => ours == theirs,
        };
        is_same && (!are_compatible || self.operation == other.operation)
    }
}

/// Records an operation as a graph and checks the graph.
fn record<O: Operation>(operation: &O, opcode: u64, marks: Marks) -> Result<OperationGraph<Stage>, Error> {
    let mut graph = recorder::record(operation, opcode, marks);
    if graph.is_auto {
        schedule::check(&graph)?;
    } else {
        graph.check()?;
    }
    graph.name_tests();
    graph.name_states();
    Ok(graph)
}

/// The ports that are present.
fn present(mut ports: Vec<Port>, is_present: &dyn Fn(&str) -> bool) -> Vec<Port> {
    ports.retain(|port| is_present(&port.name));
    ports
}

/// The width of a port in words: `a number`, `1 bit`, `4 bits`.
fn width_text(width: Option<u32>) -> String {
    match width {
        None => "a number".to_string(),
        Some(1) => "1 bit".to_string(),
        Some(width) => format!("{width} bits"),
    }
}

impl Operations {
    /// The empty set of operations, in binary32.
    pub fn new() -> Self {
        Self {
            graphs: Vec::new(),
            marks: Marks::default(),
            budget: None,
            format: Format::BINARY32,
            tag: 0,
            exception_flags: false,
            rounding: Rounding::Unit,
            ports: Vec::new(),
        }
    }

    /// The operations of a configuration. They are compiled in this crate: [`Semantics::operations`] compiles them in
    /// the crate that calls it.
    ///
    /// # Errors
    /// Features that cannot be combined ([`Config::check`]).
    pub fn of(config: Config) -> Result<Self, Error> {
        config.check()?;
        let mut operations = Self::empty(config.semantics);
        config.semantics.operations(&mut operations)?;
        Ok(operations)
    }

    /// The empty set of operations, with the format, the rounding, the tag and the exception flags of these semantics.
    pub fn empty(semantics: Semantics) -> Self {
        let Semantics { format, rounding, features: Features { tag, exception_flags, .. }, .. } = semantics;
        Self::new().format(format).rounding(rounding).tag(tag).exception_flags(exception_flags)
    }

    /// Adds an operation under an opcode of its own, below [`MAX_OPERATIONS`]. The opcode port is as wide as the
    /// greatest opcode needs.
    ///
    /// # Errors
    /// A stage out of range; a value that is read before the stage that computes it; state that is not read in the
    /// stage that writes it; stages marked in an operation with [`auto`](raypath_ops::Circuit::auto), or a chain of
    /// units that is longer than the pipeline; an opcode or a name that is taken; an opcode too large; a name that is
    /// not in snake_case; an input, output or state without names; a port that another operation has with another type,
    /// or that the operation has twice.
    pub fn with<O: Operation>(mut self, operation: &O, opcode: u64) -> Result<Self, Error> {
        let inputs = present(ports_of::<O::Input<Binary32>>(), &|port| operation.has_input(port));
        let outputs = present(ports_of::<O::Output<Binary32>>(), &|port| operation.has_output(port));
        for (part, ports) in [("input", &inputs), ("output", &outputs), ("state", &ports_of::<O::State<Binary32>>())] {
            if ports.iter().any(|port| port.name.is_empty()) {
                return Err(Error::Unnamed { operation: O::NAME, part });
            }
        }
        self.reserve(O::NAME, opcode, inputs, outputs)?;
        self.graphs.push(record(operation, opcode, self.marks)?);
        Ok(self)
    }

    /// Sets the format of all numbers; binary32 by default.
    pub fn format(mut self, format: Format) -> Self {
        self.format = format;
        self
    }

    /// Sets the width of a word that every job carries unchanged from the port `tag_i` to the port `tag_o`: 1 to
    /// [`Features::MAX_TAG_WIDTH`] bits, or 0 for none.
    pub fn tag(mut self, width: u32) -> Self {
        self.tag = width;
        self
    }

    /// Sets whether there is a port `exception_flags_o` for the exceptions of all additions and multiplications of a
    /// job, as the bits of [`raypath_float::flags`].
    pub fn exception_flags(mut self, are_present: bool) -> Self {
        self.exception_flags = are_present;
        self
    }

    /// Sets how the operations added after this call round their sums; at every addition by default. With
    /// [`Rounding::Sum`] they mark the stages of the shorter pipeline, whose last stage also decodes. The pipeline has
    /// its full length all the same if an operation computes something in a later stage.
    pub fn rounding(mut self, rounding: Rounding) -> Self {
        self.rounding = rounding;
        if self.marks != Marks::Ignored {
            self.marks = if rounding == Rounding::Sum { Marks::Short } else { Marks::Used };
        }
        self
    }

    /// Stages the operations added after this call automatically and ignores the stages that they mark
    /// (`docs/extending/staging.md`).
    pub fn auto(mut self) -> Self {
        self.marks = Marks::Ignored;
        self
    }

    /// Limits the units that each operation may use in a stage. Automatic staging observes the budget; marked stages
    /// that exceed it are an error. Without a budget, automatic staging uses the units of the other operations and as
    /// few more as possible.
    pub fn within(mut self, budget: Budget) -> Self {
        self.budget = Some(budget);
        self
    }

    /// Reserves an operation's opcode, name and ports. Ports of the same name are one port, which an operation must not
    /// have twice. Outputs of the same name must have the same width. Of an input word, an operation may read the
    /// lowest bits alone.
    fn reserve(
        &mut self,
        operation: &'static str,
        opcode: u64,
        inputs: Vec<Port>,
        outputs: Vec<Port>,
    ) -> Result<(), Error> {
        let taken = self.graphs.iter().find(|graph| graph.opcode == opcode).map(|graph| graph.name);
        if taken.is_some() || opcode >= MAX_OPERATIONS {
            return Err(Error::Opcode { operation, opcode, taken });
        }
        let is_taken = self.graphs.iter().any(|graph| graph.name == operation);
        if is_taken || !is_identifier(operation) {
            return Err(Error::Name { operation, is_taken });
        }
        let inputs = inputs.into_iter().map(|port| (port, true));
        for (port, is_input) in inputs.chain(outputs.into_iter().map(|port| (port, false))) {
            let port_use = PortUse { name: port.name, is_input, width: port.width, operation };
            if let Some(other) = self.ports.iter().find(|other| other.clashes_with(&port_use)) {
                let [ours, theirs] = [port_use.width, other.width].map(width_text);
                let port = format!("{}_{}", port_use.name, if is_input { "i" } else { "o" });
                return Err(Error::Port { operation, port, ours, other: other.operation, theirs });
            }
            self.ports.push(port_use);
        }
        Ok(())
    }

    /// The graphs of the operations, with all stages assigned, and the number of stages.
    pub(crate) fn staged(
        mut self,
        microarchitecture: Microarchitecture,
    ) -> Result<(Vec<OperationGraph<Stage>>, u32), Error> {
        Features::check_tag(self.tag)?;
        if self.tag > 0 {
            self.graphs.iter_mut().try_for_each(|graph| graph.add_tag(self.tag))?;
        }
        if self.exception_flags {
            for graph in &mut self.graphs {
                graph.counts_exceptions = true;
                // Dead sums and products are live now and may make a chain too long.
                if graph.is_auto {
                    schedule::check(graph)?;
                }
            }
        }
        self.graphs.iter_mut().for_each(OperationGraph::eliminate_dead_values);
        let Microarchitecture { registers, sharing, .. } = microarchitecture;
        let number_width = match registers {
            Encoding::Ieee => self.format.ieee_width(),
            Encoding::Recoded => self.format.recoded_width(),
        };
        self.config(microarchitecture).check()?;
        let staged = schedule::assign(self.graphs, &Target { budget: self.budget, number_width, sharing })?;
        let last = staged.iter().flat_map(|graph| &graph.nodes).map(|node| node.position).max();
        let is_short = self.rounding == Rounding::Sum && last <= Some(Stage(SHORT_STAGES));
        Ok((staged, if is_short { SHORT_STAGES } else { STAGES }))
    }
}

impl Operations {
    /// What these operations have in common with a configuration of the paper's, for its exceptions. Their formats have
    /// none: only the models of the paper's operations lack exceptions in other formats than binary32.
    fn config(&self, microarchitecture: Microarchitecture) -> Config {
        let mut nodes = self.graphs.iter().flat_map(|graph| &graph.nodes);
        let has_sums = nodes.any(|node| matches!(node.op, Op::Sum(_)));
        let rounding = if has_sums { Rounding::Sum } else { Rounding::Unit };
        let config = Config { microarchitecture, ..Config::DEFAULT };
        config.rounding(rounding).exception_flags(self.exception_flags)
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

/// Whether a name can be part of labels, states and ports: small letters, digits and `_`, the first a letter.
pub fn is_identifier(name: &str) -> bool {
    let is_part = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    name.starts_with(|c: char| c.is_ascii_lowercase()) && name.chars().all(is_part)
}
