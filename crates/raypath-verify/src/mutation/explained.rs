//! Survivors that nothing proves alike, but of which it is known why no test can kill them. They count as survivors.

/// Where such faults are, and why no job shows them.
struct Explanation {
    /// What the module's name begins with.
    module: &'static str,
    /// Parts of the fault's own words.
    fault: &'static [&'static str],
    reason: &'static str,
}

const SQUARES: &str = "this adder adds sums of squares only, which are never negative";

const EXPLANATIONS: &[Explanation] = &[
    Explanation {
        module: "raypath_stage_",
        fault: &["triangle_edge_", "_at_least_zero"],
        reason: "if it concerns NaN only: t_denom is a sum of u, v and w, so it is NaN too, and then there is no hit",
    },
    Explanation {
        module: "raypath_stage_10",
        fault: &["triangle_t_denom_is_nan"],
        reason: "a sum of u, v and w that are none of them negative or NaN is not NaN",
    },
    Explanation {
        module: "raypath_stage_",
        fault: &["quadbox_near_", "_z0_is_nan"],
        reason: "z0 is the greater of a distance and 0, where NaN drops out",
    },
    Explanation {
        module: "raypath_stage_2",
        fault: &["Constant", "in euclidean_difference_", "top bit"],
        reason: "a lane that is masked off becomes -0 instead of +0, and its square is +0 all the same",
    },
    Explanation { module: "raypath", fault: &["stage_10_", "add_0_sign"], reason: SQUARES },
    Explanation { module: "raypath", fault: &["stage_10_", "add_0_subtract"], reason: SQUARES },
];

/// Why a fault survives, if that is known.
pub fn reason(module: &str, fault: &str) -> Option<&'static str> {
    let is_it = |explanation: &&Explanation| {
        module.starts_with(explanation.module) && explanation.fault.iter().all(|part| fault.contains(part))
    };
    EXPLANATIONS.iter().find(is_it).map(|explanation| explanation.reason)
}
