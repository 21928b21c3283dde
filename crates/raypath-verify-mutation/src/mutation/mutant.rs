//! The modules that get faults, the sample of their faults, and the results of their checks.

use super::units::Unit;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use raypath_hdl::mutate::{Fault, faults};
use raypath_hdl::{Module, verilog};
use raypath_model::Shape;
use raypath_rtl::{Config, DatapathNetlist};
use raypath_sim::engine::shape;
use raypath_verify::Error;
use std::collections::HashSet;
use std::sync::Arc;

/// A module of a datapath, and the faults that it can have.
pub struct FaultyModule {
    pub datapath: Arc<Elaborated>,
    pub module: Arc<Module>,
    /// The floating-point unit that the module is a part of, if any.
    pub unit: Option<Unit>,
    pub faults: Vec<Fault>,
}

/// A configuration's netlist and pipeline shape.
pub struct Elaborated {
    pub config: Config,
    pub top: Arc<Module>,
    pub shape: Shape,
}

pub struct Mutant<'s> {
    pub subject: &'s FaultyModule,
    pub fault: &'s Fault,
}

/// All modules of these configurations that can have faults, equal ones once.
pub fn subjects(configs: &[Config]) -> Result<Vec<FaultyModule>, Error> {
    let mut known = HashSet::new();
    let mut subjects = Vec::new();
    for &config in configs {
        let datapath = DatapathNetlist::new(config)?;
        let top = datapath.top().clone();
        let datapath = Arc::new(Elaborated { config, shape: shape(config, &datapath), top });
        for module in verilog::modules(&datapath.top)? {
            let mut faults = faults(&module);
            faults.retain(|fault| !exchanges_operands(&module, fault));
            if !faults.is_empty() && known.insert(verilog::print_module(&module, &[])?) {
                let unit = Unit::of(config, module.name())?;
                subjects.push(FaultyModule { datapath: datapath.clone(), module, unit, faults });
            }
        }
    }
    Ok(subjects)
}

/// Whether a fault exchanges the operands of an adder or a multiplier. The results are the same: a test proves it for
/// the adders, and the item `multiplication` that products are those of IEEE 754.
fn exchanges_operands(module: &Module, fault: &Fault) -> bool {
    let Some((instance, inputs)) = fault.exchanged_inputs() else { return false };
    let unit = &module.instances()[instance].module;
    let commutes = ["raypath_fp_add_", "raypath_fp_mul_"].iter().any(|name| unit.name().starts_with(name));
    commutes && inputs.map(|input| unit.inputs()[input].name.as_str()) == ["a_i", "b_i"]
}

/// A random sample of about `count` faults: a few of every module, and the rest in proportion to the modules' faults.
/// If there are more modules than `count`, one fault each of `count` modules.
pub fn choose(subjects: &[FaultyModule], count: usize, seed: u64) -> Vec<Mutant<'_>> {
    const A_FEW: usize = 5;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let few = A_FEW.min(count / subjects.len().max(1)).max(1);
    let all: usize = subjects.iter().map(|subject| subject.faults.len()).sum();
    let rest = count.saturating_sub(few * subjects.len());
    let mut mutants = Vec::new();
    for subject in subjects {
        let share = few + (rest * subject.faults.len()).div_ceil(all.max(1));
        let mut faults: Vec<&Fault> = subject.faults.iter().collect();
        faults.shuffle(&mut rng);
        mutants.extend(faults.into_iter().take(share).map(|fault| Mutant { subject, fault }));
    }
    mutants.shuffle(&mut rng);
    if count < subjects.len() {
        mutants.truncate(count);
    }
    mutants
}
