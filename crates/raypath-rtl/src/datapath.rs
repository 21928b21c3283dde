use crate::STAGES;
use crate::config::{Config, Lanes};
use crate::error::Error;
use crate::graph::Traced;
use crate::library::Library;
use crate::plan::Plan;
use crate::stage::notes;
use crate::top;
use crate::units::{UnitKind, Units};
use raypath_float::Format;
use raypath_hdl::Module;
use raypath_ops::{Angular, Euclidean, JobKind, RayBox, RayTriangle};
use std::sync::Arc;

/// A datapath, elaborated: its netlist, and what can be said of it.
#[derive(Debug)]
pub struct Datapath {
    config: Config,
    plan: Plan,
    top: Arc<Module>,
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
    /// Elaborates a configuration.
    ///
    /// # Errors
    /// Operations that do not fit the pipeline; with the operations of this crate's configurations, none.
    pub fn new(config: Config) -> Result<Self, Error> {
        let rules = config.rules;
        let mut operations = vec![
            Traced::new(&RayBox { rules }, JobKind::Quadbox.opcode())?,
            Traced::new(&RayTriangle { rules }, JobKind::Triangle.opcode())?,
        ];
        if config.lanes == Lanes::Sixteen {
            operations.push(Traced::new(&Euclidean::<16>, JobKind::Euclidean.opcode())?);
            operations.push(Traced::new(&Angular::<8>, JobKind::Angular.opcode())?);
        }
        let plan = Plan::new(operations)?;
        let library = Library::new(Format::BINARY32)?;
        let mut doc = vec![
            "A ray-tracer datapath: one job a cycle, latency 12, ready and valid at both ends.".to_string(),
            format!("Opcodes: {}.", opcodes(&plan)),
        ];
        for traced in &plan.operations {
            doc.extend([String::new(), format!("{}, stage by stage:", traced.name)]);
            let works = (1..=STAGES).map(|stage| (stage, notes(traced, stage))).filter(|(_, what)| !what.is_empty());
            doc.extend(works.map(|(stage, what)| format!("  {stage:>2}  {what}")));
        }
        let top = top::top(&plan, &library, &doc)?;
        Ok(Self { config, plan, top })
    }

    /// What it was elaborated from.
    pub fn config(&self) -> Config {
        self.config
    }

    /// The module `raypath`.
    pub fn top(&self) -> &Arc<Module> {
        &self.top
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
        let Some(module) = self.module(stage) else { return units };
        for instance in module.instances() {
            for kind in UnitKind::ALL {
                if instance.module.name().starts_with(&format!("raypath_fp_{}_", kind.stem())) {
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
        let name = if stage == 0 { "raypath_input".to_string() } else { format!("raypath_stage_{stage}") };
        let instance = self.top.instances().iter().find(|instance| instance.module.name() == name)?;
        (stage <= STAGES).then_some(&instance.module)
    }
}

fn opcodes(plan: &Plan) -> String {
    let mut operations: Vec<&Traced> = plan.operations.iter().collect();
    operations.sort_by_key(|traced| traced.opcode);
    let named: Vec<String> = operations.iter().map(|traced| format!("{} {}", traced.opcode, traced.name)).collect();
    named.join(", ")
}
