//! Reset: after one, nothing unknown leaves a port that has a meaning, whatever registers and memories held before.
//!
//! The emitted text is simulated with the values 0, 1 and unknown ([`FourState`]). All registers and memories begin
//! with unknown values, and so are inputs in every cycle in which they have no meaning.

mod datapath;
mod faults;
mod traversal;

use crate::covering::{Space, presets_and_pairs};
use faults::{LostReset, lost_resets};
use raypath_float::Format;
use raypath_hdl::{Module, verilog};
use raypath_rtl::{Config, Control, Datapath, Interval, Lanes};
use raypath_tools::{FourState, KnownWord, pool, temporary_folder};
use raypath_verify::{Error, Level, Request, Verdict};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Simulates the level's subjects, and some of them with every reset lost in turn.
///
/// # Errors
/// A program is missing or fails; a subject cannot be built.
pub fn verify(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let (level, seed, shard) = (request.level, request.seed, request.shard);
    let mut work = Vec::new();
    for (subject, loses_resets) in subjects(level)? {
        let lost = lost_resets(&text_of(&subject.top()?)?);
        work.push((subject, None));
        work.extend(lost.into_iter().filter(|_| loses_resets).map(|lost| (subject, Some(lost))));
    }
    let shards = request.parts.phase(|| {
        let own: Vec<&(Subject, Option<LostReset>)> = shard.of(&work).collect();
        pool::map(&own, pool::ALL_CORES, request.proceed, |(subject, lost), _| {
            let scenario = subject.scenario(level, seed)?;
            Ok::<_, Error>(Some(Found::of(*subject, lost.as_ref(), &scenario, scenario.run(lost.as_ref())?)))
        })
    })?;
    let mut verdict = Verdict::default();
    let mut all = Found::default();
    for found in shards.into_iter().flatten() {
        match found {
            Some(found) => all.join(found),
            None => verdict.is_stopped = true,
        }
    }
    let Found { designs, cycles, outcomes, lost, failures } = all;
    verdict.covered =
        format!("{designs} designs in {cycles} cycles with {outcomes} outcomes; {lost} lost resets found at the ports");
    verdict.failures = failures;
    Ok(verdict)
}

/// What is simulated.
#[derive(Debug, Clone, Copy)]
enum Subject {
    Datapath(Config),
    /// The traversal unit around the default datapath.
    Unit,
}

/// A message about what is wrong at the outputs of a cycle.
type Check = Box<dyn Fn(usize, &[KnownWord]) -> Option<String>>;

/// A run of a subject.
struct Scenario {
    top: Arc<Module>,
    frames: Vec<Vec<KnownWord>>,
    check: Check,
    /// The outcomes that are shown.
    outcomes: u64,
}

impl Subject {
    fn top(self) -> Result<Arc<Module>, Error> {
        match self {
            Self::Datapath(config) => Ok(Datapath::new(config)?.top().clone()),
            Self::Unit => Ok(traversal::unit()?.top),
        }
    }

    fn scenario(self, level: Level, seed: u64) -> Result<Scenario, Error> {
        match self {
            Self::Datapath(config) => datapath::scenario(config, level.pick(40, 100, 400), seed),
            Self::Unit => traversal::scenario(level.pick(2, 6, 24), seed),
        }
    }

    fn name(self) -> String {
        match self {
            Self::Datapath(config) => config.to_string(),
            Self::Unit => "traversal unit".to_string(),
        }
    }
}

impl Scenario {
    /// Simulates the text, without a reset if one is lost. Returns a message about the first cycle that is wrong.
    fn run(&self, lost: Option<&LostReset>) -> Result<Option<String>, Error> {
        let (folder, text) = (temporary_folder()?, text_of(&self.top)?);
        let text = lost.map_or(text.clone(), |lost| lost.insert(&text));
        let simulation = FourState::build(&text, &self.top, folder.path())?;
        let mut wrong = None;
        simulation.run(self.frames.iter().cloned(), |cycle, words| {
            wrong = (self.check)(cycle, words).map(|what| format!("cycle {cycle}: {what}"));
            wrong.is_none()
        })?;
        Ok(wrong)
    }
}

/// All modules of a design as printed.
fn text_of(top: &Arc<Module>) -> Result<String, Error> {
    Ok(verilog::sources(top, &[])?.into_iter().map(|source| source.text).collect())
}

/// What was run, and what was wrong.
#[derive(Default, Serialize, Deserialize)]
struct Found {
    designs: u64,
    cycles: u64,
    outcomes: u64,
    lost: u64,
    failures: Vec<String>,
}

impl Found {
    fn of(subject: Subject, lost: Option<&LostReset>, scenario: &Scenario, wrong: Option<String>) -> Self {
        let (cycles, outcomes) = (scenario.frames.len() as u64, scenario.outcomes);
        let name = subject.name();
        match (lost, wrong) {
            (None, None) if outcomes > 0 => Self { designs: 1, cycles, outcomes, ..Self::default() },
            (None, None) => Self::failed(format!("{name}: no outcome")),
            (None, Some(wrong)) => Self::failed(format!("{name}: {wrong}")),
            (Some(_), Some(_)) => Self { lost: 1, ..Self::default() },
            (Some(lost), None) => Self::failed(format!("{name}: {lost} has no reset, and no port shows it")),
        }
    }

    fn failed(failure: String) -> Self {
        Self { failures: vec![failure], ..Self::default() }
    }

    fn join(&mut self, other: Self) {
        self.designs += other.designs;
        self.cycles += other.cycles;
        self.outcomes += other.outcomes;
        self.lost += other.lost;
        self.failures.extend(other.failures);
    }
}

/// The designs of a level, and whether each also runs with lost resets. Full: the presets, and small datapaths with
/// every pair of values of the parameters.
///
/// # Errors
/// A parameter without the values that are given here.
fn subjects(level: Level) -> Result<Vec<(Subject, bool)>, Error> {
    let small = Config::DEFAULT.lanes(Lanes::Two).format(Format::BINARY16);
    let (small, folded) =
        (Subject::Datapath(small), Subject::Datapath(small.control(Control::Credit).interval(Interval::Two)));
    if level == Level::Regression {
        return Ok(vec![(small, true), (folded, false)]);
    }
    let space = Space::new(&|_| true).with("lanes", &["2", "none", "4"])?.with("format", &["fp16", "fp32", "bf16"])?;
    let all = presets_and_pairs(&space).into_iter().map(|config| (Subject::Datapath(config), false));
    Ok([(small, true), (folded, true)].into_iter().chain(all).chain([(Subject::Unit, false)]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_designs_can_be_built() {
        for (subject, _) in subjects(Level::Full).expect("values") {
            let name = subject.name();
            subject.top().unwrap_or_else(|error| panic!("{name}: {error}"));
        }
    }
}
