use crate::STAGES;
use crate::boundary::OPCODE_WIDTH;
use crate::config::{Config, Lanes};
use crate::error::Error;
use crate::graph::Traced;
use crate::library::Library;
use crate::plan::Plan;
use crate::stage::notes;
use crate::top::{self, Pipeline};
use crate::units::{UnitKind, Units};
use raypath_float::Format;
use raypath_hdl::Module;
use raypath_ops::{Angular, Euclidean, JobKind, Operation, RayBox, RayTriangle};
use std::sync::Arc;

/// A datapath, elaborated: its netlist, and what can be said of it.
#[derive(Debug)]
pub struct Datapath {
    plan: Plan,
    library: Library,
    pipeline: Pipeline,
}

/// The operations of a datapath, each with its opcode. Their order is that of ports, tables and comments.
#[derive(Debug, Default)]
pub struct Operations {
    traced: Vec<Traced>,
}

impl Operations {
    /// None yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds an operation under an opcode of two bits.
    ///
    /// # Errors
    /// An operation that does not fit the pipeline: a stage that is not there, a value that is read before it is made,
    /// state that is read elsewhere than its next value is made; an opcode that is taken or too large.
    pub fn with<O: Operation>(mut self, operation: &O, opcode: u64) -> Result<Self, Error> {
        let taken = self.traced.iter().find(|traced| traced.opcode == opcode).map(|traced| traced.name);
        if taken.is_some() || opcode >> OPCODE_WIDTH != 0 {
            return Err(Error::Opcode { operation: O::NAME, opcode, taken });
        }
        self.traced.push(Traced::new(operation, opcode)?);
        Ok(self)
    }
}

/// What an operation does in a stage: a cell of Table VII.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StageNote {
    /// The operation.
    pub operation: &'static str,
    /// In words; empty where it only passes.
    pub what: String,
    /// The units that it uses.
    pub units: Units,
}

/// Register bits of a stage, both registers of each skid buffer counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Registers {
    /// Bits of a job that must cross, opcode included: half of the data registers.
    pub live: u64,
    /// Data registers: `live` twice.
    pub data: u64,
    /// Valid and ready.
    pub control: u64,
    /// Accumulators.
    pub state: u64,
}

impl Datapath {
    /// Elaborates a configuration of the paper's operations.
    ///
    /// # Errors
    /// None that a user can cause: these operations fit.
    pub fn new(config: Config) -> Result<Self, Error> {
        let rules = config.rules;
        let operations = Operations::new()
            .with(&RayBox { rules }, JobKind::Quadbox.opcode())?
            .with(&RayTriangle { rules }, JobKind::Triangle.opcode())?;
        Self::of(match config.lanes {
            Lanes::None => operations,
            Lanes::Two => with_distances::<2, 1>(operations)?,
            Lanes::Four => with_distances::<4, 2>(operations)?,
            Lanes::Eight => with_distances::<8, 4>(operations)?,
            Lanes::Sixteen => with_distances::<16, 8>(operations)?,
            Lanes::ThirtyTwo => with_distances::<32, 16>(operations)?,
            Lanes::SixtyFour => with_distances::<64, 32>(operations)?,
        })
    }

    /// Elaborates any set of operations.
    ///
    /// # Errors
    /// Operations that use the units of a stage in orders that make a loop, or whose names cannot be printed.
    pub fn of(operations: Operations) -> Result<Self, Error> {
        let plan = Plan::new(operations.traced);
        let library = Library::new(Format::BINARY32)?;
        let pipeline = top::pipeline(&plan, &library, &description(&plan))?;
        Ok(Self { plan, library, pipeline })
    }

    /// The module `raypath`.
    pub fn top(&self) -> &Arc<Module> {
        &self.pipeline.top
    }

    /// What each operation does in a stage (1 to [`STAGES`]), in words and units.
    pub fn schedule(&self, stage: u32) -> Vec<StageNote> {
        let Some(plan) = self.plan.stages.get(stage as usize) else { return Vec::new() };
        let operations = self.plan.operations.iter().zip(&plan.assigned);
        operations
            .map(|(traced, assigned)| {
                let mut units = Units::default();
                for (kind, _) in assigned.values() {
                    *units.of_mut(*kind) += 1;
                }
                StageNote { operation: traced.name, what: notes(traced, stage), units }
            })
            .collect()
    }

    /// The units of a stage (1 to [`STAGES`]), counted in the netlist.
    pub fn units(&self, stage: u32) -> Units {
        let mut units = Units::default();
        for instance in self.module(stage).iter().flat_map(|module| module.instances()) {
            for kind in UnitKind::ALL {
                if Arc::ptr_eq(&instance.module, self.library.unit(kind)) {
                    *units.of_mut(kind) += 1;
                }
            }
        }
        units
    }

    /// The registers after a stage (0, the input's, to [`STAGES`]), counted in the netlist.
    pub fn registers(&self, stage: u32) -> Registers {
        let Some(module) = self.module(stage) else { return Registers::default() };
        let bits = |with_reset: bool| -> u64 {
            let chosen = module.registers().iter().filter(|register| register.reset.is_some() == with_reset);
            chosen.map(|register| u64::from(module.signal(register.signal).width)).sum()
        };
        let control = module.instances().iter().map(|instance| instance.module.register_bits()).sum();
        Registers { live: bits(false) / 2, data: bits(false), control, state: bits(true) }
    }

    fn module(&self, stage: u32) -> Option<&Arc<Module>> {
        self.pipeline.stages.get(stage as usize)
    }
}

fn with_distances<const E: usize, const A: usize>(operations: Operations) -> Result<Operations, Error> {
    operations.with(&Euclidean::<E>, JobKind::Euclidean.opcode())?.with(&Angular::<A>, JobKind::Angular.opcode())
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
        "A ray-tracer datapath: one job a cycle, latency 12, ready and valid at both ends.".to_string(),
        format!("Opcodes: {}.", opcodes.join(", ")),
    ];
    for traced in &plan.operations {
        lines.extend([String::new(), format!("{}, stage by stage:", traced.name)]);
        let works = (1..=STAGES).map(|stage| (stage, notes(traced, stage))).filter(|(_, what)| !what.is_empty());
        lines.extend(works.map(|(stage, what)| format!("  {stage:>2}  {what}")));
    }
    lines
}
