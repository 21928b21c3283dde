//! Proofs of the pipeline's control: no job is lost, repeated or reordered, a stalled output is stable, and an
//! accumulator updates once for each beat.
//!
//! The proof has three parts. First, a model checker proves properties of the emitted SystemVerilog with its emitted
//! assertions: opcodes pass through each step's module as through a FIFO; the entrance accepts no more jobs than fit;
//! in the whole pipeline stalled outputs are stable, and beats of an accumulator keep their distance. Second, the
//! netlist's structure shows that the steps form a chain, and that data moves with the opcode. Third, a chain of FIFOs
//! is a FIFO, and a FIFO whose control does not depend on its data treats all data alike (Wolper 1986). If units take
//! one step, the model checker also proves the order of the whole pipeline at once.

mod lemmas;
mod properties;
mod structure;

pub use properties::{never_leaves, problems};
pub use structure::structural_faults;
pub use structure::together;

use raypath_hdl::with_enables;
use raypath_ops::Rules;
use raypath_rtl::{Config, Control, Datapath, Interval, Lanes, Sharing, UnitLatency};
use raypath_tools::pool;
use raypath_verify::safety::{CheckResult, Method, ModelChecker, ModuleTexts, SafetyProblem};
use raypath_verify::{Error, Progress, Request, Verdict};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap};

/// Proves the control of the level's configurations.
///
/// # Errors
/// A program is missing or fails; a configuration cannot be elaborated.
pub fn control(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let configs = request.level.pick(representatives(), all(), all());
    let shard = request.shard;
    let configs: Vec<(u64, Config)> = (0..).zip(configs).filter(|(number, _)| shard.takes(*number)).collect();
    let mut is_stopped = false;
    let shards = request.parts.phase(|| {
        let mut results: BTreeMap<u64, Proved> = BTreeMap::new();
        let checker = ModelChecker::find()?;
        let mut work = Vec::new();
        for &(number, config) in &configs {
            let datapath = Datapath::new(config)?;
            let faults = structural_faults(&datapath, config)?.into_iter().map(|fault| format!("{config}: {fault}"));
            results.entry(number).or_default().failures.extend(faults);
            // A clock gate is an enable for the model checker, which has one clock.
            let texts = ModuleTexts::new(&with_enables(datapath.top()))?;
            let mut problems = problems(&datapath, config, &texts);
            problems.push(never_leaves(&datapath, config, &texts, datapath.top().name()));
            work.extend(problems.into_iter().map(|problem| (number, config, problem)));
        }
        let problems: Vec<&SafetyProblem> = work.iter().map(|(.., problem)| problem).collect();
        let checked = check_all(&checker, &problems, request.proceed)?;
        for ((number, config, problem), result) in work.iter().zip(&checked) {
            let Proved { assertions, failures } = results.entry(*number).or_default();
            let must_fail = problem.name.ends_with("never_leaves");
            match (result, problem.method) {
                (None, _) => is_stopped = true,
                (Some(CheckResult::Fails), _) if must_fail => {}
                (Some(CheckResult::Holds), Method::Unbounded | Method::Inductive) => *assertions += problem.assertions,
                (Some(CheckResult::Holds), Method::Bounded(_)) => {
                    failures.push(format!("{config}: no job leaves within the bound"))
                }
                (Some(result), _) => failures.push(format!("{config}: {}: {result:?}", problem.name)),
            }
        }
        Ok::<_, Error>(results)
    })?;
    let results: BTreeMap<u64, Proved> = shards.into_iter().flatten().collect();
    let proved: usize = results.values().map(|proved| proved.assertions).sum();
    let covered = format!("{proved} assertions of {} configurations proved", results.len());
    let failures = results.into_values().flat_map(|proved| proved.failures).take(FAILURES_SHOWN).collect();
    Ok(Verdict { covered, failures, is_stopped, ..Verdict::default() })
}

const FAILURES_SHOWN: usize = 8;

/// The result of a configuration.
#[derive(Default, Serialize, Deserialize)]
struct Proved {
    assertions: usize,
    failures: Vec<String>,
}

/// All configurations with different control. The other parameters change widths only.
pub fn all() -> Vec<Config> {
    let mut configs = Vec::new();
    for &control in Control::ALL {
        for &unit_latency in UnitLatency::ALL {
            for lanes in [Lanes::None, Lanes::Two] {
                for &sharing in Sharing::ALL {
                    for rules in [Rules::Paper, Rules::Chisel] {
                        let config = Config::DEFAULT.control(control).unit_latency(unit_latency).lanes(lanes);
                        configs.push(config.sharing(sharing).rules(rules));
                        configs.push(config.sharing(sharing).rules(rules).clock_gating(true));
                    }
                }
            }
        }
        for &interval in Interval::ALL.iter().filter(|interval| **interval != Interval::One) {
            let folded = Config::DEFAULT.control(control).interval(interval);
            configs.extend([Lanes::None, Lanes::Two].map(|lanes| folded.lanes(lanes)));
        }
    }
    configs
}

/// One configuration of each kind of control, with and without clock gates.
fn representatives() -> Vec<Config> {
    let config = |control, unit_latency| Config::DEFAULT.control(control).unit_latency(unit_latency).lanes(Lanes::Two);
    let configs = Control::ALL.iter().map(|&control| config(control, UnitLatency::One));
    configs.flat_map(|config| [config, config.interval(Interval::Four), config.clock_gating(true)]).collect()
}

/// Checks each problem, equal ones once, on all cores; none for problems not reached when the run was stopped.
fn check_all(
    checker: &ModelChecker,
    work: &[&SafetyProblem],
    proceed: &mut dyn FnMut(Progress) -> bool,
) -> Result<Vec<Option<CheckResult>>, Error> {
    let mut known: HashMap<(&str, Method), usize> = HashMap::new();
    let mut different: Vec<&SafetyProblem> = Vec::new();
    let mut indices = Vec::new();
    for problem in work {
        indices.push(*known.entry((&problem.text, problem.method)).or_insert_with(|| {
            different.push(problem);
            different.len() - 1
        }));
    }
    let results = pool::map(&different, pool::ALL_CORES, proceed, |problem, stop| checker.check(problem, stop))?;
    Ok(indices.into_iter().map(|index| results[index]).collect())
}
