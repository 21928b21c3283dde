//! Survivors that nothing proves alike, but of which it is known why no test can kill them. They count as survivors.

/// Where such faults are, and why no job shows them.
struct Explanation {
    /// What the module's name begins with.
    module: &'static str,
    /// Parts of the fault's own words.
    fault: &'static [&'static str],
    reason: &'static str,
}

const EXPLANATIONS: &[Explanation] = &[
    Explanation {
        module: "raypath_stage_",
        fault: &["triangle_edge_", "_at_least_zero"],
        reason: "if it concerns NaN only: t_denom is a sum of u, v and w, so it is NaN too, and then there is no hit",
    },
    Explanation {
        module: "raypath_stage_10_",
        fault: &["add_0_sign"],
        reason: "this adder adds sums of squares only, which are never negative",
    },
];

/// Why a fault survives, if that is known.
pub fn reason(module: &str, fault: &str) -> Option<&'static str> {
    let is_it = |explanation: &&Explanation| {
        module.starts_with(explanation.module) && explanation.fault.iter().all(|part| fault.contains(part))
    };
    EXPLANATIONS.iter().find(is_it).map(|explanation| explanation.reason)
}
