//! Verification of the datapath: control, operations, models and text.

pub mod campaign;
mod configurations;
pub mod control;
pub mod coverage;
pub mod covering;
pub mod dataflow;
pub mod datapaths;
pub mod geometry;
pub mod models;
mod text_coverage;

pub use raypath_oracle::{exact as oracle, layout, stimuli};
use raypath_verify::Item;
use std::path::Path;

/// The claims about the datapath.
pub const ITEMS: &[Item] = &[
    Item {
        name: "control",
        claim: "no job is lost, repeated or reordered, a stalled output is stable, an accumulator updates once for \
            each beat; at level full for every preset and every pair of values of the parameters",
        oracle: "proofs by Yosys and ABC of the emitted SystemVerilog with its assertions, with free outputs of units, \
            and the netlist's structure, which shows that control does not depend on data",
        has_configuration: true,
        run: control::control,
    },
    Item {
        name: "operations",
        claim: "the emitted pipeline computes each operation for a job alone with a ready sink, for all values of its \
            inputs and states, if its units compute theirs; with the claim of control, jobs in sequence under any \
            handshakes have the same outcomes, in order; at level full for every preset, every pair of values of the \
            parameters, and each added operation",
        oracle: "the operation's function over terms, by SMT (Z3), with the emitted SystemVerilog as Yosys reads it; \
            units may be any functions with the laws that docs/development/verification.md lists",
        has_configuration: true,
        run: dataflow::verify,
    },
    Item {
        name: "watertight",
        claim: "a ray through an edge or vertex shared by faces that all face the ray hits at least one of them",
        oracle: "which faces face the ray, and where it passes them, by exact arithmetic",
        has_configuration: true,
        run: geometry::watertight::verify,
    },
    Item {
        name: "boxes",
        claim: "a ray that crosses a box by more than the rounding bound hits it, a ray that misses it by more does \
            not, and tmin has an error of at most three roundings; with rules bounds and 8 to 24 bits, no box that the \
            ray enters is missed, and tmin is a lower bound",
        oracle: "exact arithmetic on integers times powers of two",
        has_configuration: false,
        run: geometry::boxes::verify,
    },
    Item {
        name: "triangle-distance",
        claim: "t_num, t_denom and, for hits, their quotient have errors within the bounds of \
            docs/reference/error-bounds.md",
        oracle: "exact arithmetic on integers times powers of two",
        has_configuration: true,
        run: geometry::triangle_distances::verify,
    },
    Item {
        name: "sums",
        claim: "Euclidean sums, dot products and norms have errors within the bounds of docs/reference/error-bounds.md",
        oracle: "exact arithmetic on integers times powers of two",
        has_configuration: false,
        run: geometry::sums::verify,
    },
    Item {
        name: "models",
        claim: "the functional model's outcomes are those that docs/reference defines, to the bit, for every preset, \
            number of lanes, rule set, feature and added operation, and formats up to (11,24)",
        oracle: "the same operations written once more from the text, in exact arithmetic rounded once; oracles with a \
            deliberate mistake, one for each rule, which must be refuted",
        has_configuration: true,
        run: |request| models::verify(request, Path::new(campaign::FOLDER)),
    },
    Item {
        name: "campaign",
        claim: "netlist, cycle-exact model and functional model agree at all ports in every cycle, for random jobs and \
            any behaviour of source, sink and reset, and every coverage point that can be reached is hit; at level \
            full for every preset, number of lanes, rule set, feature and added operation, and formats up to (11,24)",
        oracle: "the cycle-exact and the functional model, which share the operations' functions with the netlist, but \
             neither units nor control",
        has_configuration: true,
        run: |request| campaign::verify(request, Path::new(campaign::FOLDER)),
    },
    Item {
        name: "configurations",
        claim: "in every preset and every pair of values of the parameters, the netlist is the cycle-exact model at all \
            ports in every cycle, also through resets, registers hold canonical words, and latency and interval are as \
            documented",
        oracle: "the cycle-exact and the functional model, as for campaign; `mutation` tells which faults these checks \
            find",
        has_configuration: true,
        run: configurations::verify,
    },
    Item {
        name: "text-coverage",
        claim: "the stimuli of campaigns execute 99 % of the lines and branches of the emitted SystemVerilog, and \
            toggle 99 % of its bits, without what is proved to be out of reach; at level full for every preset, small \
            datapaths with every pair of values of the parameters, and each added operation; designs with a lower \
            figure are listed with it, and do not fall below it",
        oracle: "Verilator's counters of lines and branches, while its outputs are those of the cycle-exact model; the \
            netlist's signals; runs that leave out an operation, which must be below 99 %",
        has_configuration: true,
        run: text_coverage::verify,
    },
];
