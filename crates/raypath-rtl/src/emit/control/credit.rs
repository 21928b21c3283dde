//! Credits: the number of jobs that a pipeline without stalls can still accept.

use raypath_hdl::text::Package;
use raypath_hdl::{Builder, Label, Module};
use std::sync::Arc;

/// Jobs of one opcode that may not follow each other at once.
#[derive(Debug, Clone)]
pub struct Spacing {
    /// The operation, as a label of its opcode.
    pub label: Label,
    /// Its name.
    pub name: &'static str,
    /// The number of cycles after one of its jobs in which no other one is accepted; at least 1.
    pub cycles: u32,
}

/// `raypath_credit`: accepts a job while the exit has a place for it. `credits` is the number of places, `interval` the
/// number of cycles between two jobs, at least 1.
pub fn credit(
    credits: u32,
    interval: u32,
    opcode_width: u32,
    spacings: &[Spacing],
    package: &Arc<Package>,
) -> Result<Arc<Module>, raypath_hdl::Error> {
    let m = Builder::new("raypath_credit");
    m.package(package);
    m.doc(format!("Accepts a job while one of {credits} credits is left; a job that leaves returns its credit."));
    m.doc("ready comes from a flip-flop, so there is no combinational path from the sink to the source.");
    let valid = m.input("valid_i", 1);
    let returned = m.input("returned_i", 1).comment("a job leaves");
    let opcode = (!spacings.is_empty()).then(|| m.input("opcode_i", opcode_width));

    let width = u32::BITS - credits.leading_zeros();
    let count = m.register("count_q", width).reset_to(credits.into());
    let available = m.register("available_q", 1).reset_to(1);

    let mut ready = available.wire();
    let mut spaced = Vec::new();
    if let Some(opcode) = opcode {
        m.section("A job of an operation with a loop waits for the job before it");
        for spacing in spacings {
            let recent = m.register(&format!("{}_recent_q", spacing.name), spacing.cycles).reset_to(0);
            let same = opcode.equals(m.label(&spacing.label, opcode_width)).named(&format!("is_{}", spacing.name));
            ready = ready & !(same & recent.wire().any());
            spaced.push((spacing, recent, same));
        }
    }
    let recent = (interval > 1).then(|| {
        m.section(format!("A job enters {interval} or more cycles after the job before it"));
        m.register("recent_q", interval - 1).reset_to(0)
    });
    if let Some(recent) = recent {
        ready = ready & !recent.wire().any();
    }
    let enters = (valid & ready).named("enters");
    if let Some(recent) = recent {
        recent.next(match interval {
            2 => enters,
            _ => m.concat(&[recent.wire().lower(interval - 2), enters]),
        });
    }
    for (spacing, recent, same) in spaced {
        let enters = enters & same;
        recent.next(match spacing.cycles {
            1 => enters,
            cycles => m.concat(&[recent.wire().lower(cycles - 1), enters]),
        });
    }

    m.section("Count");
    let more = count.wire() + returned.extend(width) - enters.extend(width);
    let more = more.named("count_d");
    count.next(more);
    available.next(more.any());
    m.output("ready_o", ready);
    m.output("valid_o", enters);
    m.finish()
}
