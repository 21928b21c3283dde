use crate::allocate::plan::{Plan, StepPlan};
use crate::config::{Config, Microarchitecture};
use crate::emit::library::Library;
use crate::emit::properties::Properties;
use crate::emit::stage::{self, notes};
use crate::emit::top::{self, Pipeline};
use crate::error::Error;
use crate::ir::graph::OperationGraph;
use crate::ir::position::{Step, StepLabel};
use crate::ir::units::{Unit, Units};
use crate::operations::Operations;
use crate::schedule;
use raypath_hdl::Module;
use std::collections::BTreeSet;
use std::sync::Arc;

/// An elaborated datapath: its netlist, schedule, units and registers.
#[derive(Debug)]
pub struct DatapathNetlist {
    plan: Plan,
    library: Library,
    pipeline: Pipeline,
}

/// The work of an operation in a step: a cell of Table VII.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StageNote {
    /// The operation.
    pub operation: &'static str,
    /// A description; empty if values only pass through.
    pub what: String,
    /// The units that it uses.
    pub units: Units,
}

/// An operation that reads its state in one step and writes it in a later step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StateLoop {
    /// The operation.
    pub operation: &'static str,
    /// Its opcode.
    pub opcode: u64,
    /// The step that reads the state first, as an index into [`DatapathNetlist::steps`].
    pub first: u32,
    /// The step that writes the state. A job may follow the previous one after `last - first + 1` cycles, not earlier.
    pub last: u32,
}

/// The register bits after a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Registers {
    /// Live bits of a job, including the opcode.
    pub live: u64,
    /// Data registers: twice `live` in skid buffers, once `live` in registers that do not stall, and in the exit's FIFO
    /// `live` for every job.
    pub data: u64,
    /// Control registers: valid, ready, credits and pointers.
    pub control: u64,
    /// Accumulators.
    pub state: u64,
}

impl DatapathNetlist {
    /// Elaborates a configuration of the paper's operations.
    ///
    /// # Errors
    /// Features that cannot be combined ([`Config::check`]).
    pub fn new(config: Config) -> Result<Self, Error> {
        Self::build(Operations::of(config)?, config.microarchitecture)
    }

    /// Elaborates any set of operations with the default microarchitecture.
    ///
    /// # Errors
    /// More units in a stage than the budget allows; operations whose shared units would make a combinational loop;
    /// names that cannot be printed; an automatic schedule that does not read state in the stage that writes it; a
    /// value that is not available where it is read; a tag that is too wide, or whose port an operation has already.
    pub fn of(operations: Operations) -> Result<Self, Error> {
        Self::build(operations, Microarchitecture::DEFAULT)
    }

    /// Elaborates any set of operations with this microarchitecture.
    ///
    /// # Errors
    /// Those of [`DatapathNetlist::of`].
    pub fn build(operations: Operations, microarchitecture: Microarchitecture) -> Result<Self, Error> {
        let Operations { format, exception_flags: with_flags, .. } = operations;
        let (staged, stages) = operations.staged(microarchitecture)?;
        let (operations, labels) = schedule::expand(&staged, microarchitecture, stages);
        let plan = Plan::new(operations, labels, format, microarchitecture)?;
        let library = Library::new(&plan, with_flags)?;
        let pipeline = top::pipeline(&plan, &library, &description(&plan))?;
        Ok(Self { plan, library, pipeline })
    }

    /// The module `raypath`.
    pub fn top(&self) -> &Arc<Module> {
        &self.pipeline.top
    }

    /// The assertions about the control of the pipeline.
    pub fn properties(&self) -> Properties {
        Properties::new(&self.plan, &self.pipeline)
    }

    /// The steps of the pipeline; the first is the input's registers. If units have a latency of one step, these are
    /// the stages of Table VII.
    pub fn steps(&self) -> impl Iterator<Item = StepLabel> + '_ {
        self.plan.steps.iter().map(|plan| plan.label)
    }

    /// The module of a step, by its index in [`DatapathNetlist::steps`].
    pub fn module(&self, step: usize) -> Option<&Arc<Module>> {
        self.pipeline.steps.get(step)
    }

    /// Cycles from the acceptance of a job to its outcome in an empty pipeline.
    pub fn latency(&self) -> u32 {
        self.plan.latency()
    }

    /// The operations and their opcodes, in the order of [`schedule`](Self::schedule).
    pub fn operations(&self) -> Vec<(&'static str, u64)> {
        self.plan.operations.iter().map(|graph| (graph.name, graph.opcode)).collect()
    }

    /// The operations whose jobs may not follow each other directly, because their state passes through a unit of
    /// several steps.
    pub fn loops(&self) -> Vec<StateLoop> {
        let loops = self.plan.operations.iter().enumerate().filter(|(_, graph)| graph.is_loop());
        loops
            .map(|(op, graph)| StateLoop {
                operation: graph.name,
                opcode: graph.opcode,
                first: graph.first_read().0,
                last: graph.first_read().0 + self.plan.spacing(op),
            })
            .collect()
    }

    /// Cycles between two jobs of any operation at full throughput.
    pub fn interval(&self) -> u32 {
        self.plan.microarchitecture.interval.cycles()
    }

    /// The number of jobs that fit while the sink is not ready.
    pub fn capacity(&self) -> u64 {
        self.plan.capacity()
    }

    /// The first position of each step in a folded pipeline; empty otherwise. A job is at position 0 in the cycle after
    /// its acceptance.
    pub fn starts(&self) -> &[u32] {
        self.plan.rounds.as_ref().map_or(&[], |rounds| &rounds.starts)
    }

    /// The work of each operation in a step.
    pub fn schedule(&self, step: usize) -> Vec<StageNote> {
        let Some(plan) = self.plan.steps.get(step) else { return Vec::new() };
        let operations = self.plan.operations.iter().zip(&plan.bindings);
        operations
            .enumerate()
            .map(|(op, (graph, bindings))| {
                let mut units = self.plan.conversions(step, op);
                let used: BTreeSet<Unit> = bindings.values().map(|binding| binding.unit).collect();
                for unit in used {
                    *units.of_mut(unit.kind) += 1;
                }
                StageNote { operation: graph.name, what: notes(&self.plan, graph, step), units }
            })
            .collect()
    }

    /// The units of a step, counted in the netlist. Each part of a unit counts in its own step.
    pub fn units(&self, step: usize) -> Units {
        let mut units = Units::default();
        for instance in self.module(step).iter().flat_map(|module| module.instances()) {
            if let Some(kind) = self.library.kind(&instance.module) {
                *units.of_mut(kind) += 1;
            }
        }
        units
    }

    /// The registers after a step, counted in the netlist. The credit counter belongs to the input's registers.
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
        let states = self.plan.operations.iter().flat_map(|graph| graph.states.iter().map(move |state| (graph, state)));
        let here = states.filter(|(_, state)| state.written == Step(step as u32));
        let state = here.map(|(graph, state)| u64::from(stage::width(graph, state, &self.library))).sum();
        let below: u64 = module.instances().iter().map(|instance| instance.module.register_bits()).sum();
        let entrance = self.pipeline.credit.iter().chain(&self.pipeline.rounds);
        let entrance = entrance.filter(|_| step == 0).map(|module| module.register_bits());
        let control = own(true) - state + below + entrance.sum::<u64>();
        Registers { live, data: own(false), control, state }
    }
}

impl Registers {
    /// The number of flip-flops.
    pub fn flip_flops(self) -> u64 {
        self.data + self.control + self.state
    }
}

/// The head comment of the top module: Table VII by columns.
fn description(plan: &Plan) -> Vec<String> {
    let mut operations: Vec<&OperationGraph<Step>> = plan.operations.iter().collect();
    operations.sort_by_key(|graph| graph.opcode);
    let opcodes: Vec<String> = operations.iter().map(|graph| format!("{} {}", graph.opcode, graph.name)).collect();
    let mut lines = vec![
        format!(
            "A ray-tracer datapath: one job {}, latency {}, ready and valid at both ends.",
            match plan.microarchitecture.interval.cycles() {
                1 => "a cycle".to_string(),
                cycles => format!("every {cycles} cycles"),
            },
            plan.latency()
        ),
        format!("Opcodes: {}.", opcodes.join(", ")),
    ];
    for graph in plan.operations.iter().filter(|graph| graph.is_loop()) {
        let (name, cycles) = (graph.name, graph.spacing() + 1);
        lines.push(format!("A job of {name} may follow another one of {name} {cycles} cycles later, not before."));
    }
    for graph in &plan.operations {
        lines.extend([String::new(), format!("{}, stage by stage:", graph.name)]);
        for (index, StepPlan { label, .. }) in plan.steps.iter().enumerate().filter(|(_, plan)| plan.label.part == 1) {
            let what = notes(plan, graph, index);
            if !what.is_empty() {
                lines.push(format!("  {:>2}  {what}", label.stage));
            }
        }
    }
    lines
}
