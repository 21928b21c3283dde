//! The pipeline's control, proved: nothing lost, repeated or reordered, what stalls stays, accumulators act once a beat.
//!
//! Three parts make the whole. An engine proves of every step's module alone, as it is emitted, with the assertions that
//! are emitted beside it, that opcodes go through it as through a FIFO; of the entrance, that it lets in no more than fit;
//! of the whole, that stalled outputs stay and that beats of an accumulator keep apart. The structure of the netlist shows
//! that the steps stand in a row, and that data move with the opcode. That a row of FIFOs is a FIFO, and that a FIFO which
//! never looks at what it carries treats all of it alike (Wolper 1986), does the rest. Where units take one step the engine
//! proves the order of the whole besides, all steps at once.

mod engine;
mod lemmas;
mod problems;
mod structure;

pub use engine::{Answer, Engine, Method, Problem};
pub use problems::{Fault, Texts, problems, vacuous};
pub use structure::faults;

use crate::proof::pool;
use crate::{Error, Item, Request, Step, Verdict};
use raypath_ops::Rules;
use raypath_rtl::{Config, Control, Datapath, Lanes, Sharing, UnitLatency};
use std::collections::HashMap;

/// The item of `raypath verify`.
pub const CONTROL: Item = Item {
    name: "control",
    claim: "no job is lost, repeated or reordered, a stalled output stays, an accumulator acts once for each beat",
    oracle: "proofs by Yosys and ABC of the emitted SystemVerilog with its assertions, units free",
    run: control,
};

/// Proves the control of several configurations.
///
/// # Errors
/// A program is missing or fails; a configuration cannot be elaborated.
pub fn control(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let engine = Engine::find()?;
    let configs = request.level.pick(representatives(), all(), all());
    let mut work = Vec::new();
    let mut verdict = Verdict::default();
    let mut configurations = 0;
    for (config, number) in configs.into_iter().zip(0..) {
        if !request.shard.takes(number) {
            continue;
        }
        let datapath = Datapath::new(config)?;
        verdict.failures.extend(faults(&datapath, config)?.into_iter().map(|fault| format!("{config}: {fault}")));
        let texts = Texts::new(datapath.top())?;
        let mut problems = problems(&datapath, config, &texts);
        problems.push(vacuous(&datapath, config, &texts, datapath.top().name()));
        work.extend(problems.into_iter().map(|problem| (config, problem)));
        configurations += 1;
    }
    let judged = judge_all(&engine, &work, request)?;
    let mut proved = 0;
    for ((config, problem), answer) in work.iter().zip(&judged) {
        let is_vacuous = problem.name.ends_with("never_leaves");
        match (answer, problem.method) {
            (None, _) => verdict.is_stopped = true,
            (Some(Answer::Fails), _) if is_vacuous => {}
            (Some(Answer::Holds), Method::Unbounded | Method::Inductive) => proved += problem.assertions,
            (Some(Answer::Holds), Method::Bounded(_)) => verdict.failures.push(format!("{config}: no job ever leaves")),
            (Some(answer), _) => verdict.failures.push(format!("{config}: {}: {answer:?}", problem.name)),
        }
    }
    verdict.failures.truncate(8);
    verdict.covered = format!("{proved} assertions of {configurations} configurations proved");
    Ok(verdict)
}

/// Every control there is: what else a configuration says changes widths alone.
pub fn all() -> Vec<Config> {
    let mut configs = Vec::new();
    for &control in Control::ALL {
        for &unit_latency in UnitLatency::ALL {
            for lanes in [Lanes::None, Lanes::Two] {
                for &sharing in Sharing::ALL {
                    for rules in [Rules::Paper, Rules::Chisel] {
                        configs.push(Config { control, unit_latency, lanes, sharing, rules, ..Config::DEFAULT });
                    }
                }
            }
        }
    }
    configs
}

/// Both controls.
fn representatives() -> Vec<Config> {
    let config = |control, unit_latency| Config { control, unit_latency, lanes: Lanes::Two, ..Config::DEFAULT };
    vec![config(Control::Skid, UnitLatency::One), config(Control::Credit, UnitLatency::One)]
}

/// Judges each text once, on all cores; nothing for what was not reached when it was stopped.
fn judge_all(
    engine: &Engine,
    work: &[(Config, Problem)],
    request: &mut Request<'_>,
) -> Result<Vec<Option<Answer>>, Error> {
    let mut places: HashMap<(&str, Method), usize> = HashMap::new();
    let mut different: Vec<&Problem> = Vec::new();
    let mut place = Vec::new();
    for (_, problem) in work {
        place.push(*places.entry((&problem.text, problem.method)).or_insert_with(|| {
            different.push(problem);
            different.len() - 1
        }));
    }
    let total = different.len() as u64;
    let watch = |done: usize| (request.watch)(Step { done: done as u64, total });
    let answers = pool::for_each(&different, |problem, stop| engine.judge(problem, stop), watch)?;
    Ok(place.into_iter().map(|place| answers[place]).collect())
}
