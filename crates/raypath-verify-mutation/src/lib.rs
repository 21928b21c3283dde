//! Faults that the regression tests must find: in netlists, and in the operations that netlists and models share.

pub mod mutation;
pub mod operation_mutation;
mod report;

use raypath_verify::Item;

/// The claims about faults.
pub const ITEMS: &[Item] = &[
    Item {
        name: "mutation",
        claim: "the regression tests kill at least 98 % of the faults in the netlist that are not proven equivalent: \
            the lower end of a 95 % confidence interval",
        oracle: "the checks that the regression tests make: units against the host's f32, the datapath against its \
            models",
        has_configuration: false,
        run: mutation::run,
    },
    Item {
        name: "operation-mutation",
        claim: "an oracle that does not come from the operations' source finds at least 98 % of the faults in their \
            dataflow that are not proven equivalent, the lower end of a 95 % confidence interval, so that a fault that \
            netlist and models share does not stay hidden",
        oracle: "docs/reference, in exact arithmetic with one rounding for each operation; equivalence by an SMT \
            solver",
        has_configuration: false,
        run: operation_mutation::run,
    },
];
