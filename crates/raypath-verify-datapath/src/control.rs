//! Proofs of the pipeline's control: no job is lost, repeated or reordered, a stalled output is stable, and an
//! accumulator updates once for each beat.
//!
//! The proof has three parts. First, a model checker proves properties of the emitted SystemVerilog with its emitted
//! assertions: opcodes pass through each step's module as through a FIFO; the entrance accepts no more jobs than fit;
//! in the whole pipeline stalled outputs are stable, whatever data enter the last step, and beats of an accumulator
//! keep their distance. Second, the netlist's structure shows that the steps form a chain, that data moves with the
//! opcode, and that no handshake and no opcode depends on data in any cycle. Third, a chain of FIFOs is a FIFO, and a
//! FIFO whose control does not depend on its data treats all data alike (Wolper 1986). If units take one step, the
//! model checker also proves the order of the whole pipeline at once.

mod lemmas;
mod properties;
mod structure;

pub use properties::{never_leaves, problems};
pub use structure::{data_faults, structural_faults, together};

use crate::covering::{Space, presets_and_pairs};
use crate::datapaths::TestedDatapath;
use raypath_hdl::with_enables;
use raypath_rtl::{Config, Control, Interval, Lanes};
use raypath_tools::Key;
use raypath_verify::safety::{CheckResult, Method, ModelChecker, ModuleTexts, SafetyProblem};
use raypath_verify::{Error, Level, Request, Verdict};
use raypath_work::pool;
use std::collections::HashSet;

/// Proves the control of the level's datapaths, or of the one that the request names. Datapaths whose text is the same
/// share its proof.
///
/// # Errors
/// A program is missing or fails; a configuration cannot be elaborated.
pub fn control(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let subjects = if request.is_chosen { vec![TestedDatapath::of(request)] } else { subjects(request.level)? };
    let (shard, mut is_stopped) = (request.shard, false);
    let shards = request.parts.phase(|| {
        let checker = ModelChecker::find()?;
        let (mut failures, mut problems) = (Vec::new(), Vec::new());
        let mut known: HashSet<Key> = HashSet::new();
        for (number, subject) in (0..).zip(&subjects) {
            let datapath = subject.datapath().elaborate()?;
            if shard.takes(number) {
                let faults = structural_faults(&datapath, subject.config)?;
                failures.extend(faults.into_iter().map(|fault| format!("{subject}: {fault}")));
            }
            // A clock gate is an enable for the model checker, which has one clock.
            let texts = ModuleTexts::new(&with_enables(datapath.top()))?;
            let mut all = self::problems(&datapath, subject.config, &texts)?;
            all.push(never_leaves(&datapath, subject.config, &texts, datapath.top().name()));
            all.retain(|problem| known.insert(Key::new("control", &[&problem.text, &format!("{:?}", problem.method)])));
            problems.extend(all.into_iter().map(|problem| (subject, problem)));
        }
        let own: Vec<(&TestedDatapath, SafetyProblem)> = shard.of(problems).collect();
        let check = |(_, problem): &(&TestedDatapath, SafetyProblem), stop: &_| checker.check(problem, stop);
        let results = pool::map(&own, pool::ALL_CORES, request.proceed, check)?;
        let mut proved = 0;
        for ((subject, problem), result) in own.iter().zip(results) {
            let Some(result) = result else {
                is_stopped = true;
                continue;
            };
            // The claim that no job leaves must be refuted; it is the only one with a bound.
            let expected = match problem.method {
                Method::Bounded(_) => CheckResult::Fails,
                Method::Unbounded | Method::Inductive => CheckResult::Holds,
            };
            if result != expected {
                failures.push(format!("{subject}: {}: {result:?}, expected {expected:?}", problem.name));
            } else if result == CheckResult::Holds {
                proved += problem.assertions;
            }
        }
        Ok::<(usize, Vec<String>), Error>((proved, failures))
    })?;
    let proved: usize = shards.iter().map(|(proved, _)| proved).sum();
    let covered = format!("{proved} different assertions of {} datapaths proved", subjects.len());
    let failures = shards.into_iter().flat_map(|(_, failures)| failures).take(FAILURES_SHOWN).collect();
    Ok(Verdict { covered, failures, is_stopped, ..Verdict::default() })
}

const FAILURES_SHOWN: usize = 8;

/// The datapaths of a level. Regression: one of each kind of control, one with clock gates. Full: the presets,
/// and every pair of values, with no lanes, 2 or 4: more lanes widen data and repeat accumulators.
fn subjects(level: Level) -> Result<Vec<TestedDatapath>, Error> {
    let configs = match level {
        Level::Regression => {
            let [skid, credit] =
                [Control::Skid, Control::Credit].map(|it| Config::DEFAULT.control(it).lanes(Lanes::Two));
            vec![skid, credit.clock_gating(true), skid.interval(Interval::Four), credit.interval(Interval::Four)]
        }
        Level::Full | Level::Long => presets_and_pairs(&Space::new(&|_| true).with("lanes", &["none", "2", "4"])?),
    };
    Ok(configs.into_iter().map(TestedDatapath::from).collect())
}
