//! All items, in the order of `docs/development/verification.md`.

use crate::units::Dividers;
use crate::units::bench::Units;
use crate::units::proofs;
use crate::{Error, Level, Request, Shard, Verdict};
use crate::{
    campaign, control, dataflow, gates, geometry, models, mutation, operation_mutation, parsers, reset, text_coverage,
    unit, units,
};
use raypath_float::Format;
use std::path::Path;

/// A claim about the datapath, its oracle, and the function that checks it.
#[derive(Debug, Clone, Copy)]
pub struct Item {
    /// The item's name on the command line.
    pub name: &'static str,
    /// What is claimed.
    pub claim: &'static str,
    /// What the claim is checked against.
    pub oracle: &'static str,
    /// The files and folders of the repository that the result depends on: what is verified, and what verifies it. A
    /// recorded result is stale once they have changed.
    pub subject: &'static [&'static str],
    /// Whether the request's configuration changes what is checked.
    pub has_configuration: bool,
    /// The part of its work that level `regression` does, as `--shard` takes it: "1/1", or less if all takes long.
    pub regression_shard: &'static str,
    /// Checks the claim with all of the request's work.
    pub run: fn(&mut Request<'_>) -> Result<Verdict, Error>,
}

impl Item {
    /// Checks the claim. Level `regression` does its part of the work, and the verdict says which, unless the request
    /// chooses a configuration, a number of jobs or shards.
    ///
    /// # Errors
    /// The item cannot run.
    pub fn verify(&self, request: &mut Request<'_>) -> Result<Verdict, Error> {
        let has_parts = request.parts.is_saved() || request.parts.seconds().is_some();
        let has_choice = request.is_chosen || request.jobs.is_some() || has_parts || request.shard != Shard::ALL;
        if request.level > Level::Regression || has_choice {
            return (self.run)(request);
        }
        request.shard = self.regression_shard.parse()?;
        let mut verdict = (self.run)(request)?;
        if request.shard != Shard::ALL {
            verdict.remarks.insert(0, format!("shard {} of level regression", request.shard));
        }
        Ok(verdict)
    }
}

const UNITS: &[&str] = &["crates/raypath-float/src", "crates/raypath-hdl/src", "crates/raypath-verify/src/units"];
const PROOFS: &[&str] = &[
    "crates/raypath-float/src",
    "crates/raypath-hdl/src",
    "crates/raypath-verify/src/sat",
    "crates/raypath-verify/src/units",
];
const GEOMETRY: &[&str] = &["crates/raypath-model/src", "crates/raypath-ops/src", "crates/raypath-verify/src/geometry"];

/// All items, in the order of `docs/development/verification.md`.
pub const ITEMS: &[Item] = &[
    Item {
        name: "testfloat",
        claim: "the units add, subtract, multiply and compare binary32 as IEEE 754 specifies, unsplit and split, and \
            raise its exceptions",
        oracle: "Berkeley SoftFloat, on the cases of Berkeley TestFloat",
        subject: UNITS,
        has_configuration: false,
        regression_shard: "1/1",
        run: |request| units::testfloat(&Units::new(Format::BINARY32)?, &Units::with_flags(Format::BINARY32)?, request),
    },
    Item {
        name: "conversions",
        claim: "recoding loses no number of binary32, keeps their order and follows its table; every word of the \
            classes zero, infinity and NaN is decoded by its class alone",
        oracle: "the host's conversion to binary64, and the table of docs/reference/formats.md",
        subject: UNITS,
        has_configuration: false,
        regression_shard: "1/1",
        run: |request| units::conversions(&Units::new(Format::BINARY32)?, request),
    },
    Item {
        name: "small-formats",
        claim: "the units of small formats give IEEE 754's result for every pair of operands, unsplit and split",
        oracle: "LLVM's soft float, in the crate rustc_apfloat",
        subject: UNITS,
        has_configuration: false,
        regression_shard: "1/1",
        run: |request| units::small_formats(&|format| Ok(Units::new(format)?), request),
    },
    Item {
        name: "division",
        claim: "the units give IEEE 754's quotients, reciprocals and square roots, pipelined and iterative",
        oracle: "Berkeley SoftFloat in binary32, on the cases of Berkeley TestFloat and other numbers, and in \
            binary16; LLVM's soft float, in the crate rustc_apfloat, and the host's roots in small formats",
        subject: UNITS,
        has_configuration: false,
        regression_shard: "1/1",
        run: |request| units::division(&Dividers::new, request),
    },
    Item {
        name: "unit-proofs",
        claim: "adders, multipliers, dividers, square roots, comparison and conversions give IEEE 754's result for all \
            operands; split and iterative units give the result of the unsplit ones; products and numbers with short \
            significands are rounded in their direction; sums of several terms round once",
        oracle: "Yosys's symfpu, and a definition of sums on integers, by SAT (ABC)",
        subject: PROOFS,
        has_configuration: false,
        regression_shard: "1/2",
        run: proofs::unit_proofs,
    },
    Item {
        name: "multiplication",
        claim: "the multipliers of binary32 and of other formats, built of gates and with `*`, and by short factors, \
            give IEEE 754's product for all operands, and its exceptions",
        oracle: "lemmas about the emitted signals, each proved by SAT (ABC), with Yosys's symfpu and a free product in \
            the last one; the theorem of docs/development/verification.md composes them",
        subject: PROOFS,
        has_configuration: false,
        regression_shard: "1/2",
        run: proofs::multiplication,
    },
    Item {
        name: "adder-proof",
        claim: "the binary32 adder gives IEEE 754's sum for all operands",
        oracle: "Yosys's symfpu, by SAT (ABC), in 55 cases of the difference of exponents",
        subject: PROOFS,
        has_configuration: false,
        regression_shard: "1/1",
        run: proofs::adder_proof,
    },
    Item {
        name: "gates",
        claim: "the gates that `raypath ppa` synthesises for the floating-point units compute what their text says",
        oracle: "the emitted SystemVerilog, by SAT (ABC)",
        subject: &[
            "crates/raypath-float/src",
            "crates/raypath-hdl/src",
            "crates/raypath-ppa/src",
            "crates/raypath-verify/src/gates.rs",
            "crates/raypath-verify/src/sat",
        ],
        has_configuration: false,
        regression_shard: "1/1",
        run: gates::gates,
    },
    Item {
        name: "control",
        claim: "no job is lost, repeated or reordered, a stalled output is stable, an accumulator updates once for \
            each beat",
        oracle: "proofs by Yosys and ABC of the emitted SystemVerilog with its assertions, with free outputs of units",
        subject: &[
            "crates/raypath-hdl/src",
            "crates/raypath-ops/src",
            "crates/raypath-rtl/src",
            "crates/raypath-verify/src/control",
            "crates/raypath-verify/src/sat",
        ],
        has_configuration: false,
        regression_shard: "1/4",
        run: control::control,
    },
    Item {
        name: "operations",
        claim: "the emitted pipeline computes each operation, for all values of its inputs and states, if its units \
            compute theirs",
        oracle: "the operation's function over terms, by SMT (Z3), with the emitted SystemVerilog as Yosys reads it; \
            units may be any functions with the laws that docs/development/verification.md lists",
        subject: &[
            "crates/raypath-hdl/src",
            "crates/raypath-ops/src",
            "crates/raypath-rtl/src",
            "crates/raypath-verify/src/control",
            "crates/raypath-verify/src/dataflow.rs",
            "crates/raypath-verify/src/dataflow",
        ],
        has_configuration: true,
        regression_shard: "1/5",
        run: dataflow::verify,
    },
    Item {
        name: "watertight",
        claim: "a ray through an edge or vertex shared by faces that all face the ray hits at least one of them",
        oracle: "which faces face the ray, and where it passes them, by exact arithmetic",
        subject: GEOMETRY,
        has_configuration: true,
        regression_shard: "1/2",
        run: geometry::watertight::verify,
    },
    Item {
        name: "boxes",
        claim: "a ray that crosses a box by more than the rounding bound hits it, a ray that misses it by more does \
            not, and tmin has an error of at most three roundings; with rules bounds and 8 to 24 bits, no box that the \
            ray enters is missed, and tmin is a lower bound",
        oracle: "exact arithmetic on integers times powers of two",
        subject: GEOMETRY,
        has_configuration: false,
        regression_shard: "1/1",
        run: geometry::boxes::verify,
    },
    Item {
        name: "triangle-distance",
        claim: "t_num, t_denom and, for hits, their quotient have errors within the bounds of \
            docs/reference/error-bounds.md",
        oracle: "exact arithmetic on integers times powers of two",
        subject: GEOMETRY,
        has_configuration: true,
        regression_shard: "1/1",
        run: geometry::triangle_distances::verify,
    },
    Item {
        name: "sums",
        claim: "Euclidean sums, dot products and norms have errors within the bounds of docs/reference/error-bounds.md",
        oracle: "exact arithmetic on integers times powers of two",
        subject: GEOMETRY,
        has_configuration: false,
        regression_shard: "1/1",
        run: geometry::sums::verify,
    },
    Item {
        name: "models",
        claim: "the functional model's outcomes are those that docs/reference defines, to the bit, and the cycle-exact \
            model has the same outcomes, in order, for every preset, number of lanes, rule set, feature and added \
            operation, and formats up to (11,24)",
        oracle: "the same operations written once more from the text, in exact arithmetic rounded once; for most jobs \
            of the default configuration in binary64 rounded once, which is compared with the exact one",
        subject: &[
            "crates/raypath-model/src",
            "crates/raypath-ops/src",
            "crates/raypath-verify/src/geometry/dyadic.rs",
            "crates/raypath-verify/src/layout.rs",
            "crates/raypath-verify/src/models.rs",
            "crates/raypath-verify/src/models",
            "crates/raypath-verify/src/oracle.rs",
            "crates/raypath-verify/src/oracle",
            "crates/raypath-verify/src/subjects.rs",
            "crates/raypath-verify/src/stimuli",
        ],
        has_configuration: true,
        regression_shard: "1/2",
        run: |request| models::verify(request, Path::new(campaign::FOLDER)),
    },
    Item {
        name: "campaign",
        claim: "netlist, cycle-exact model and functional model agree at all ports in every cycle, for random jobs and \
            any behaviour of source, sink and reset, and every coverage point that can be reached is hit; at level \
            full for every preset, number of lanes, rule set, feature and added operation, and formats up to (11,24)",
        oracle: "the cycle-exact and the functional model, which share the operations' functions with the netlist, but \
             neither units nor control",
        subject: &[
            "crates/raypath-float/src",
            "crates/raypath-hdl/src",
            "crates/raypath-sim/src",
            "crates/raypath-model/src",
            "crates/raypath-ops/src",
            "crates/raypath-rtl/src",
            "crates/raypath-verify/src/campaign.rs",
            "crates/raypath-verify/src/campaign",
            "crates/raypath-verify/src/coverage.rs",
            "crates/raypath-verify/src/coverage",
            "crates/raypath-verify/src/layout.rs",
            "crates/raypath-verify/src/subjects.rs",
            "crates/raypath-verify/src/stimuli",
        ],
        has_configuration: true,
        regression_shard: "1/1",
        run: |request| campaign::verify(request, Path::new(campaign::FOLDER)),
    },
    Item {
        name: "text-coverage",
        claim: "the stimuli of campaigns execute 99 % of the lines and branches of the emitted SystemVerilog, and \
            toggle 99 % of its bits, without what is proved to be out of reach; at level full for every preset, flow \
            control, sharing, interval, unit latency, encoding, rule set, feature and added operation, and for the \
            traversal units of their campaign",
        oracle: "Verilator's counters, while its outputs are those of the cycle-exact model; runs that leave out an \
            operation or all nodes, which must be below 99 %",
        subject: &[
            "crates/raypath-float/src",
            "crates/raypath-hdl/src",
            "crates/raypath-ops/src",
            "crates/raypath-rtl/src",
            "crates/raypath-tools/src/verilator.rs",
            "crates/raypath-tools/src/verilator_coverage.rs",
            "crates/raypath-tools/src/verilator_main.rs",
            "crates/raypath-unit/src",
            "crates/raypath-verify/src/text_coverage.rs",
            "crates/raypath-verify/src/text_coverage",
        ],
        has_configuration: true,
        regression_shard: "1/1",
        run: text_coverage::verify,
    },
    Item {
        name: "reset",
        claim: "after a reset nothing unknown leaves a port that has a meaning, whatever registers, memories and \
            inputs without meaning hold; outcomes are those of the models",
        oracle: "simulation of the emitted SystemVerilog with unknown values, by Yosys and Icarus Verilog; the \
            cycle-exact and the functional model",
        subject: &[
            "crates/raypath-float/src",
            "crates/raypath-hdl/src",
            "crates/raypath-ops/src",
            "crates/raypath-rtl/src",
            "crates/raypath-tools/src/four_state.rs",
            "crates/raypath-unit/src",
            "crates/raypath-verify/src/reset.rs",
            "crates/raypath-verify/src/reset",
        ],
        has_configuration: false,
        regression_shard: "1/1",
        run: reset::verify,
    },
    Item {
        name: "mutation",
        claim: "the regression tests kill at least 99 % of the faults in the netlist that are not proven equivalent",
        oracle: "the checks that the regression tests make: units against the host's f32, the datapath against its \
            models",
        subject: &[
            "crates/raypath-float/src",
            "crates/raypath-hdl/src",
            "crates/raypath-sim/src",
            "crates/raypath-model/src",
            "crates/raypath-ops/src",
            "crates/raypath-rtl/src",
            "crates/raypath-verify/src/units",
            "crates/raypath-verify/src/mutation.rs",
            "crates/raypath-verify/src/mutation",
        ],
        has_configuration: false,
        regression_shard: "1/1",
        run: mutation::run,
    },
    Item {
        name: "operation-mutation",
        claim: "an oracle that does not come from the operations' source finds at least 99 % of the faults in their \
            dataflow that are not proven equivalent, so that a fault that netlist and models share does not stay \
            hidden",
        oracle: "docs/reference, in exact arithmetic with one rounding for each operation; equivalence by an SMT \
            solver",
        subject: &[
            "crates/raypath-ops/src",
            "crates/raypath-verify/src/operation_mutation.rs",
            "crates/raypath-verify/src/operation_mutation",
            "crates/raypath-verify/src/oracle.rs",
            "crates/raypath-verify/src/oracle",
            "crates/raypath-verify/src/stimuli.rs",
            "crates/raypath-verify/src/stimuli",
        ],
        has_configuration: false,
        regression_shard: "1/1",
        run: operation_mutation::run,
    },
    Item {
        name: "unit",
        claim: "the traversal unit loses, repeats and mixes up no ray, and its netlist returns what the functional \
            model does, for any memory, any users of the channels and resets",
        oracle: "proofs by Yosys and ABC of the emitted SystemVerilog of each module, with properties of queues; the \
            functional model, which shares the functions of a step with the netlist, but neither units nor control",
        subject: &[
            "crates/raypath-float/src",
            "crates/raypath-hdl/src",
            "crates/raypath-ops/src",
            "crates/raypath-rtl/src",
            "crates/raypath-unit/src",
            "crates/raypath-verify/src/control",
            "crates/raypath-verify/src/unit.rs",
            "crates/raypath-verify/src/unit",
        ],
        has_configuration: false,
        regression_shard: "1/3",
        run: unit::verify,
    },
    Item {
        name: "parsers",
        claim: "no file makes raypath panic, hang, or exhaust the memory",
        oracle: "the bounds that docs/reference/transactions.md, docs/reference/configurations.md and \
             docs/user/area-and-timing.md \
             state; what was read means the same when it is written and read again",
        subject: &[
            "crates/raypath-ppa/src",
            "crates/raypath-render/src",
            "crates/raypath-rtl/src/config",
            "crates/raypath-sim/src",
            "crates/raypath-tools/src",
            "crates/raypath-verify/src/parsers",
            "crates/raypath-verify/src/parsers.rs",
            "fuzz/corpus",
        ],
        has_configuration: false,
        regression_shard: "1/1",
        run: parsers::run,
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use raypath_tools::parts::Parts;

    /// An item that does nothing, and says which shard that was.
    const ITEM: Item = Item {
        name: "shards",
        claim: "",
        oracle: "",
        subject: &[],
        has_configuration: true,
        regression_shard: "1/5",
        run: |request| Ok(Verdict { covered: request.shard.to_string(), ..Verdict::default() }),
    };

    fn verified(change: impl FnOnce(&mut Request<'_>)) -> (String, Vec<String>) {
        let watch = &mut |_| true;
        let mut request = Request::new(watch);
        change(&mut request);
        let verdict = ITEM.verify(&mut request).expect("a verdict");
        (verdict.covered, verdict.remarks)
    }

    #[test]
    fn level_regression_does_its_part_and_says_so() {
        let part = ("1/5".to_string(), vec!["shard 1/5 of level regression".to_string()]);
        assert_eq!(verified(|_| ()), part);
    }

    #[test]
    fn a_request_with_a_choice_and_other_levels_have_all_of_their_work() {
        let whole = |shard: &str| (shard.to_string(), Vec::new());
        assert_eq!(verified(|request| request.level = Level::Full), whole("1/1"));
        assert_eq!(verified(|request| request.is_chosen = true), whole("1/1"));
        assert_eq!(verified(|request| request.jobs = Some(9)), whole("1/1"));
        assert_eq!(verified(|request| request.parts = Parts::saved()), whole("1/1"));
        assert_eq!(verified(|request| request.shard = "2/3".parse().expect("a shard")), whole("2/3"));
    }

    #[test]
    fn all_items_have_a_part_at_level_regression() {
        for item in ITEMS {
            let shard: Result<Shard, _> = item.regression_shard.parse();
            assert!(shard.is_ok_and(|shard| shard.number() == 0), "{}", item.name);
        }
    }
}
