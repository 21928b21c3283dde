//! Survivors without a proof of equivalence, with the reason why no test can kill them. They count as survivors.

/// A group of such faults, and the reason why no job shows them.
struct Explanation {
    /// The prefix of the module's name.
    module: &'static str,
    /// Parts of the fault's description.
    fault: &'static [&'static str],
    reason: &'static str,
}

const SQUARES: &str = "this adder adds sums of squares only, which are never negative";

const EXPLANATIONS: &[Explanation] = &[
    Explanation {
        module: "raypath_stage_",
        fault: &["triangle_edge_", "_at_least_zero"],
        reason: "if it affects NaN only: t_denom is a sum of u, v and w, so it is NaN too, and there is no hit",
    },
    Explanation {
        module: "raypath_stage_10",
        fault: &["triangle_t_denom_is_nan"],
        reason: "a sum of u, v and w, none of which is negative or NaN, is not NaN",
    },
    Explanation {
        module: "raypath_stage_",
        fault: &["quadbox_near_", "_z0_is_nan"],
        reason: "z0 is the maximum of a distance and 0, which ignores NaN",
    },
    Explanation {
        module: "raypath_stage_2",
        fault: &["Constant", "in euclidean_difference_", "top bit"],
        reason: "a masked lane becomes -0 instead of +0, and its square is +0 in both cases",
    },
    Explanation { module: "raypath", fault: &["stage_10_", "add_0_sign"], reason: SQUARES },
    Explanation { module: "raypath", fault: &["stage_10_", "add_0_subtract"], reason: SQUARES },
];

/// The reason why a fault survives, if it is known.
pub fn reason(module: &str, fault: &str) -> Option<&'static str> {
    let is_it = |explanation: &&Explanation| {
        module.starts_with(explanation.module) && explanation.fault.iter().all(|part| fault.contains(part))
    };
    EXPLANATIONS.iter().find(is_it).map(|explanation| explanation.reason)
}
