//! A proof that a fault in a stage changes nothing that a job can see.
//!
//! Many values of a stage matter to nobody: what an operation leaves in registers that only other operations read, what
//! it gives to units that it does not use. No comparison of two stages can tell; the stages behind must be asked. So for
//! each opcode a job goes through the datapath as a function of arbitrary inputs and state: the control passes it on,
//! registers show what they have loaded, units are functions that nothing is known of. In the stage with the fault it
//! takes every way that there is: straight through, or by way of the spare register or each place of the FIFO, and then
//! something arbitrary stands before the stage when it leaves. Outputs and next states must come out the same as without
//! the fault. And in the stage itself, whatever its registers hold, all that control sees must be the same: enables,
//! resets, handshakes.

mod view;

use super::logic::Logic;
use super::trial::Trial;
use raypath_hdl::Module;
use std::sync::Arc;
use view::View;

/// Whether the fault is proven to change nothing. Of faults in units and in control it says nothing.
pub fn passes_alike(trial: &Trial<'_>) -> bool {
    let (datapath, original) = (&trial.subject.datapath, &trial.subject.module);
    if is_unit(original) || is_control(original) {
        return false;
    }
    let mut logic = Logic::default();
    datapath.config.kinds().iter().all(|kind| {
        let mut controlled = |module: &Arc<Module>| {
            let mut view = View::new(module, kind.opcode(), None, original.name());
            view.control(&mut logic)
        };
        if controlled(original) != controlled(&trial.module) {
            return false;
        }
        ways(original).into_iter().all(|way| {
            let mut seen = |top: &Arc<Module>| {
                let mut view = View::new(top, kind.opcode(), Some(way), original.name());
                view.outcome(&mut logic)
            };
            seen(&datapath.top) == seen(&trial.top)
        })
    })
}

/// How a job goes through the stage with the fault.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    /// At once.
    Straight,
    /// By way of the spare register of a skid buffer.
    Spare,
    /// By way of this place of the exit's FIFO.
    Place(u32),
}

/// When a stage is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Time {
    /// The job is in the registers before; those of the stage hold anything.
    Arriving,
    /// The job is in a register behind the one that it leaves by; anything is before the stage.
    Leaving,
    /// The job is in the registers that the next stage sees.
    After,
}

fn ways(module: &Module) -> Vec<Way> {
    let mut ways = vec![Way::Straight];
    for instance in module.instances() {
        match instance.module.name() {
            "raypath_skid" => ways.push(Way::Spare),
            "raypath_exit" => ways.extend((0..instance.module.port_width("read_o").unwrap_or(0)).map(Way::Place)),
            _ => {}
        }
    }
    ways
}

fn is_unit(module: &Module) -> bool {
    module.name().starts_with("raypath_fp_")
}

fn is_control(module: &Module) -> bool {
    matches!(module.name(), "raypath_skid" | "raypath_exit" | "raypath_credit")
}

/// Ports by which stages control each other.
fn is_handshake(port: &str) -> bool {
    ["valid_i", "valid_o", "ready_i", "ready_o", "opcode_i", "opcode_o", "returned_i"].contains(&port)
        || port.ends_with("_written_i")
        || port.ends_with("_written_o")
}

/// What the control of a stage's registers shows while a job passes; `None` where that does not matter to the job.
fn passed(port: &str, way: Way, time: Time) -> Option<u64> {
    match (time, port, way) {
        (Time::Arriving, "ready_o" | "arrives_o", _) => Some(1),
        (Time::Arriving, "load_front_o", way) => Some((way == Way::Straight).into()),
        (Time::Arriving, "from_store_o" | "store_o", Way::Straight) => Some(0),
        (Time::Arriving, "store_o", Way::Place(place)) | (Time::Leaving, "read_o", Way::Place(place)) => {
            Some(1 << place)
        }
        (Time::Leaving, "arrives_o", _) => Some(0),
        (Time::Leaving, "load_front_o" | "from_store_o", _) | (Time::After, "valid_o", _) => Some(1),
        _ => None,
    }
}
