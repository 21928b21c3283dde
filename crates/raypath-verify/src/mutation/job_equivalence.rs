//! A proof that a fault in a stage changes no job's outcome.
//!
//! Many values of a stage are don't-cares: the values that an operation leaves in registers of other operations, and
//! the operands of units that it does not use. Comparing two stages alone cannot show this; it depends on the stages
//! behind. Therefore each operation's job passes symbolically through the whole datapath, as a function of arbitrary
//! inputs and state: the control passes it on, registers hold what they have loaded, and units are uninterpreted
//! functions. In the stage with the fault the job takes every path: directly, or through the spare register, or through
//! each slot of the FIFO; in the last two cases the stage's inputs are arbitrary when the job leaves. Outputs and next
//! states must be the same functions as without the fault. In the stage itself, with arbitrary registers, everything
//! that affects control must be the same: enables, resets, handshakes.

use super::logic::Logic;
use super::mutant::Subject;
use super::symbolic::{SlotPath, SymbolicJob, is_control, is_unit};
use raypath_hdl::Module;
use std::sync::Arc;

/// Whether the proof shows that a fault changes no job's outcome. It does not apply to faults in units and control.
pub fn is_equivalent_for_jobs(subject: &Subject, changed: &Arc<Module>, changed_top: &Arc<Module>) -> bool {
    let (datapath, original) = (&subject.datapath, &subject.module);
    if is_unit(original) || is_control(original) {
        return false;
    }
    let mut logic = Logic::default();
    datapath.config.kinds().iter().all(|kind| {
        let mut control =
            |module: &Arc<Module>| SymbolicJob::new(&mut logic, module, kind.opcode(), None, original.name()).control();
        if control(original) != control(changed) {
            return false;
        }
        slot_paths(original).into_iter().all(|path| {
            let mut outcome = |top: &Arc<Module>| {
                SymbolicJob::new(&mut logic, top, kind.opcode(), Some(path), original.name()).outcome()
            };
            outcome(&datapath.top) == outcome(changed_top)
        })
    })
}

fn slot_paths(module: &Module) -> Vec<SlotPath> {
    let mut paths = vec![SlotPath::Direct];
    for instance in module.instances() {
        match instance.module.name() {
            "raypath_skid" => paths.push(SlotPath::Spare),
            "raypath_exit" => paths.extend((0..instance.module.port_width("read_o").unwrap_or(0)).map(SlotPath::Slot)),
            _ => {}
        }
    }
    paths
}
