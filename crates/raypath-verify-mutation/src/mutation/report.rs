//! The results of mutation testing.

use super::mutant::{Mutant, MutantResult, Subject};
use raypath_verify::files;
use raypath_verify::score::{Count, MIN_SCORE, percent};
use raypath_verify::{Error, Verdict};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

pub struct Report<'s> {
    subjects: &'s [Subject],
    total: usize,
    checked: Vec<CheckedMutant>,
}

struct CheckedMutant {
    module: String,
    config: String,
    fault: String,
    result: MutantResult,
}

impl<'s> Report<'s> {
    pub fn new(subjects: &'s [Subject], total: usize) -> Self {
        Self { subjects, total, checked: Vec::new() }
    }

    pub fn add(&mut self, mutant: &Mutant<'_>, result: MutantResult) {
        self.checked.push(CheckedMutant {
            module: mutant.subject.module.name().to_string(),
            config: mutant.subject.datapath.config.to_string(),
            fault: mutant.fault.to_string(),
            result,
        });
        // Mutants arrive in no particular order.
        self.checked.sort_by(|a, b| (&a.config, &a.fault).cmp(&(&b.config, &b.fault)));
    }

    fn count<'j>(mutant: impl Iterator<Item = &'j CheckedMutant>) -> Count {
        mutant.fold(Count::default(), |count, mutant| Count {
            faults: count.faults + 1,
            killed: count.killed + usize::from(matches!(mutant.result, MutantResult::Killed(_))),
            equivalent: count.equivalent + usize::from(matches!(mutant.result, MutantResult::Equivalent(_))),
        })
    }

    /// The number of faults that all modules have, from which the sample is drawn.
    fn population(&self) -> usize {
        self.subjects.iter().map(|subject| subject.faults.len()).sum()
    }

    pub fn all(&self) -> Count {
        Self::count(self.checked.iter())
    }

    pub fn verdict(&self) -> Verdict {
        let all = self.all();
        let [low, high] = all.interval().map(|bound| 100.0 * bound);
        let mut verdict = Verdict {
            covered: format!(
                "a sample of {} of the {} faults in {} modules: {} killed, {} proven equivalent, {} survivors; \
                 {} killed of those not proven equivalent, 95 % confidence interval {low:.2} % to {high:.2} %",
                all.faults,
                self.population(),
                self.subjects.len(),
                all.killed,
                all.equivalent,
                all.survivors(),
                percent(all.score()),
            ),
            is_stopped: self.checked.len() < self.total,
            ..Verdict::default()
        };
        verdict.remarks.push(format!("killed by {}", self.checks()));
        verdict.remarks.extend(self.survivors());
        verdict.remarks.push(format!("each mutant: {}", super::LIST));
        if all.score() < MIN_SCORE {
            let (score, least) = (percent(all.score()), percent(MIN_SCORE));
            verdict
                .failures
                .push(format!("the regression tests kill {score} of the mutants, expected at least {least}"));
        }
        verdict
    }

    fn checks(&self) -> String {
        let mut checks: BTreeMap<&str, usize> = BTreeMap::new();
        for mutant in &self.checked {
            if let MutantResult::Killed(check) = &mutant.result {
                *checks.entry(check).or_default() += 1;
            }
        }
        checks.iter().map(|(check, count)| format!("{check}: {count}")).collect::<Vec<_>>().join("; ")
    }

    fn survivors(&self) -> impl Iterator<Item = String> {
        self.checked.iter().filter_map(|mutant| match &mutant.result {
            MutantResult::Survived(why) => {
                let reason = reason(&mutant.module, &mutant.fault);
                let reason = reason.map_or(String::new(), |reason| format!("; known: {reason}"));
                Some(format!("survivor: {} ({}); {why}{reason}", mutant.fault, mutant.config))
            }
            _ => None,
        })
    }

    pub fn write(&self, path: &Path) -> Result<(), Error> {
        files::write(path, &self.text())
    }

    fn text(&self) -> String {
        let mut modules: BTreeMap<(&str, &str), Vec<&CheckedMutant>> = BTreeMap::new();
        for mutant in &self.checked {
            modules.entry((&mutant.config, &mutant.module)).or_default().push(mutant);
        }
        let mut text = "# faults, killed, equivalent, survivors, module (configuration)\n".to_string();
        for ((config, module), mutant) in &modules {
            let count = Self::count(mutant.iter().copied());
            let Count { faults, killed, equivalent } = count;
            let _ = writeln!(text, "{faults:5} {killed:5} {equivalent:5} {:5}  {module} ({config})", count.survivors());
        }
        text.push_str("\n# result, fault\n");
        for mutant in &self.checked {
            let result = match &mutant.result {
                MutantResult::Killed(check) => format!("killed by {check}"),
                MutantResult::Equivalent(proof) => format!("equivalent, {proof}"),
                MutantResult::Survived(why) => format!("survived, {why}"),
            };
            let _ = writeln!(text, "{result:32} {} ({})", mutant.fault, mutant.config);
        }
        text
    }
}

/// Survivors without a proof of equivalence, and the reason why no test can kill them. They count as survivors.
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
    Explanation {
        module: "raypath_stage_10",
        fault: &["Constant", "in euclidean_accumulator_state_q", "top bit"],
        reason: "an accumulator of squares begins with -0 instead of +0, and each sum with it is the same",
    },
    Explanation { module: "raypath", fault: &["stage_10_", "add_0_sign"], reason: SQUARES },
    Explanation { module: "raypath", fault: &["stage_10_", "add_0_subtract"], reason: SQUARES },
];

/// The reason why a fault survives, if it is known.
fn reason(module: &str, fault: &str) -> Option<&'static str> {
    let is_it = |explanation: &&Explanation| {
        module.starts_with(explanation.module) && explanation.fault.iter().all(|part| fault.contains(part))
    };
    EXPLANATIONS.iter().find(is_it).map(|explanation| explanation.reason)
}
