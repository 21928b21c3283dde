//! Mutation: whether the everyday tests notice a fault in the netlist.

mod explained;
mod logic;
mod passes;
mod report;
mod sample;
mod trial;
mod units;

use crate::error::Error;
use crate::pool::{self, Cases};
use crate::request::{Level, Request};
use crate::verdict::{Item, Verdict};
use raypath_hdl::mutate::{Fault, replace};
use raypath_rtl::{Config, Control, Lanes, UnitLatency};
use report::Report;
use sample::{Subject, choose, subjects};
use std::path::Path;
use std::sync::Arc;
use trial::Trial;

/// The datapaths whose modules get faults: the default, and small ones with the modules that it does not have.
/// `tests/configurations.rs` gives them as many jobs as they get here.
pub const CONFIGS: [Config; 4] = [
    Config::DEFAULT,
    Config::DEFAULT.lanes(Lanes::Two).control(Control::Credit),
    Config::DEFAULT.lanes(Lanes::Two).unit_latency(UnitLatency::Two),
    Config::DEFAULT.lanes(Lanes::Two).control(Control::Credit).unit_latency(UnitLatency::Two),
];

/// Where the fate of each mutant is written.
const LIST: &str = "build/verify/mutants.txt";

/// What became of a mutant.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Fate {
    /// A check failed.
    Killed(&'static str),
    /// No check did, and rightly: this proof says that the fault changes nothing.
    Equivalent(&'static str),
    /// No check did, and this is what a proof came to.
    Survived(String),
}

/// The item of `raypath verify`.
pub const ITEM: Item = Item {
    name: "mutation",
    claim: "the everyday tests kill at least 99 % of the faults in the netlist that are not proven equivalent",
    oracle: "the checks that the everyday tests make: units against the host's f32, the datapath against its models",
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
    run,
};

/// Faults of every module, each before the checks of the everyday tests.
fn run(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let count = request.jobs.unwrap_or(request.level.pick(40, 2400, 10_000)) as usize;
    let subjects = subjects(&CONFIGS)?;
    let mutants = choose(&subjects, count, request.seed);
    let proves_modules = request.level > Level::Regression;
    let report = judge(&subjects, &mutants, request, &|trial| trial.run(proves_modules))?;
    report.write(Path::new(LIST))?;
    Ok(report.verdict())
}

/// A fault of a subject.
struct Mutant<'s> {
    subject: &'s Subject,
    fault: &'s Fault,
}

type Judge<'a> = &'a (dyn Fn(&Trial<'_>) -> Result<Fate, Error> + Sync);

/// Lets `judge` decide on each mutant of the shard, on all cores.
fn judge<'s>(
    subjects: &'s [Subject],
    mutants: &[Mutant<'s>],
    request: &mut Request<'_>,
    judge: Judge<'_>,
) -> Result<Report<'s>, Error> {
    let cases = Cases { total: mutants.len() as u64, shard: request.shard };
    let finished = pool::run(cases, request.proceed, |queue| {
        let mut judged = Vec::new();
        queue.run(|number, _| {
            let mutant = &mutants[number as usize];
            judged.push((mutant, judge(&trial(mutant)?)?));
            Ok(())
        });
        Ok(judged)
    })?;
    let mut report = Report::new(subjects, request.shard.share(cases.total) as usize);
    for (mutant, fate) in finished.workers.into_iter().flatten() {
        report.add(mutant, fate);
    }
    Ok(report)
}

/// The mutant as a module and as a datapath.
fn trial<'s>(mutant: &Mutant<'s>) -> Result<Trial<'s>, Error> {
    let subject = mutant.subject;
    let module = Arc::new(mutant.fault.apply(&subject.module)?);
    let top = replace(&subject.datapath.top, &module)?;
    Ok(Trial { subject, module, top })
}

#[cfg(test)]
mod tests;
