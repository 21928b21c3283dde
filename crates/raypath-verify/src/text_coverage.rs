//! Coverage of the emitted text: lines, branches and toggles, counted by Verilator under the stimuli of campaigns.

mod constants;
mod reachable;
mod run;
mod subjects;

use crate::campaign::FOLDER;
use crate::subjects::Subject;
use crate::{Error, Level, Request, Verdict, files};
use constants::{Bit, constants};
use raypath_hdl::{Module, verilog};
use raypath_model::{OperationId, Shape};
use raypath_sim::engine::shape;
use raypath_tools::{CoverageKind, CoveragePoint, Options, Sources, Verilated, pool, read, temporary_folder};
use reachable::Text;
use run::Run;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fmt;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use tempfile::TempDir;

/// The share of reachable points that must be hit, in percent.
const BAR: f64 = 99.0;
/// The episodes of a run of the simulator.
const EPISODES_PER_RUN: u64 = 8;

/// Counts the coverage of the level's datapaths, or of the one that the user chose; and of runs that leave out an
/// operation, which must be below the bar.
///
/// # Errors
/// A program is missing or fails; a datapath cannot be elaborated; a file cannot be written.
pub(crate) fn verify(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let (level, seed, shard) = (request.level, request.seed, request.shard);
    let subjects = if request.is_chosen { vec![Subject::of(request)] } else { subjects::subjects(level)? };
    let shards = request.parts.phase(|| {
        let own: Vec<(usize, &Subject)> = shard.of(subjects.iter().enumerate()).collect();
        pool::map(&own, pool::ALL_CORES, request.proceed, |(number, subject), _| {
            // Each operation left out costs a run.
            let has_controls = *number == 0 || level > Level::Full;
            Ok::<_, Error>(Some(Found::of(subject, level.pick(1, 8, 64), seed, has_controls)?))
        })
    })?;
    let mut verdict = Verdict::default();
    let (mut text, mut designs, mut controls, mut sums) = (String::new(), 0, 0, [Counts::default(); 3]);
    for found in shards.into_iter().flatten() {
        let Some(found) = found else {
            verdict.is_stopped = true;
            continue;
        };
        designs += 1;
        controls += found.controls;
        sums.iter_mut().zip(found.counts).for_each(|(sum, counts)| sum.add(counts));
        text += &found.report;
        verdict.failures.extend(found.failures);
    }
    let counts: Vec<String> =
        CoverageKind::ALL.iter().zip(sums).map(|(kind, counts)| format!("{} {counts}", kind.name())).collect();
    verdict.covered =
        format!("{designs} designs: {}; {controls} runs without an operation are below {BAR} %", counts.join(", "));
    let path = Path::new(FOLDER).join("text-coverage.txt");
    files::write(&path, &text)?;
    verdict.remarks.push(format!("points that were not hit: {}", path.display()));
    Ok(verdict)
}

/// The points of a kind.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct Counts {
    hit: u64,
    reachable: u64,
    /// Proved to be out of reach, and not hit.
    unreachable: u64,
}

impl Counts {
    fn add(&mut self, other: Self) {
        self.hit += other.hit;
        self.reachable += other.reachable;
        self.unreachable += other.unreachable;
    }

    fn percent(self) -> f64 {
        if self.reachable == 0 { 100.0 } else { 100.0 * self.hit as f64 / self.reachable as f64 }
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { hit, reachable, unreachable } = self;
        write!(f, "{:.2} % ({hit} of {reachable} points, {unreachable} out of reach)", self.percent())
    }
}

/// The result of a datapath.
#[derive(Serialize, Deserialize)]
struct Found {
    /// Of each kind of points.
    counts: [Counts; 3],
    controls: u64,
    failures: Vec<String>,
    /// The points that were not hit.
    report: String,
}

impl Found {
    /// The coverage of so many runs of a datapath, and the runs that leave out an operation if there are several.
    fn of(subject: &Subject, runs: u64, seed: u64, has_controls: bool) -> Result<Self, Error> {
        let mut design = Design::new(subject)?;
        let mut failures = Vec::new();
        let points = design.points(0..runs, seed, None, &mut failures)?;
        design.constants = constants(&design.source, &points)?;
        let counts = design.counts(&points, &mut failures);
        for (kind, counts) in CoverageKind::ALL.iter().zip(counts) {
            if counts.percent() < BAR {
                failures.push(format!("{} coverage is {counts}, expected {BAR} %", kind.name()));
            }
        }
        let operations = subject.datapath().model().kinds();
        let omitted: &[OperationId] = if has_controls && operations.len() > 1 { &operations } else { &[] };
        let controls = pool::map(omitted, pool::ALL_CORES, &mut |_| true, |operation, _| {
            let mut failures = Vec::new();
            let points = design.points(0..runs, seed, Some(*operation), &mut failures)?;
            if design.counts(&points, &mut failures).iter().all(|counts| counts.percent() >= BAR) {
                failures.push(format!("without jobs of {operation}, the coverage is not below {BAR} %"));
            }
            Ok::<_, Error>(Some(failures))
        })?;
        failures.extend(controls.into_iter().flatten().flatten());
        let rest = points.iter().filter(|point| !is_hit(point) && !design.is_out_of_reach(point));
        let lines = rest
            .map(|point| format!("  {}, line {}: {} {}\n", point.module, point.line, point.kind.name(), point.name));
        let report = std::iter::once(format!("{subject}\n")).chain(lines).collect();
        let failures = failures.into_iter().map(|failure| format!("{subject}: {failure}")).collect();
        Ok(Self { counts, controls: omitted.len() as u64, failures, report })
    }
}

/// Whether a line or a branch was executed, or a bit has risen and fallen.
fn is_hit(point: &CoveragePoint) -> bool {
    point.hits >= if point.kind == CoverageKind::Toggle { 2 } else { 1 }
}

/// A datapath's text in Verilator.
struct Design<'s> {
    subject: &'s Subject,
    top: Arc<Module>,
    shape: Shape,
    text: Text,
    /// All modules as printed.
    source: String,
    /// The bits that are proved to be constant.
    constants: BTreeSet<Bit>,
    verilated: Verilated,
    /// Has the program.
    _folder: TempDir,
}

impl<'s> Design<'s> {
    fn new(subject: &'s Subject) -> Result<Self, Error> {
        let datapath = subject.datapath().elaborate()?;
        let (top, folder) = (datapath.top().clone(), temporary_folder()?);
        let text = Text::new(&verilog::sources(&top, &[])?);
        let Sources { files, all, .. } = Sources::write(&top, folder.path())?;
        let source = String::from_utf8_lossy(&read(&all)?).into_owned();
        let options = Options { coverage: true, ..Options::default() };
        let verilated = Verilated::build_sources(&files, &top, folder.path(), &options)?;
        let shape = shape(subject.config, &datapath);
        Ok(Self { subject, top, shape, text, source, constants: BTreeSet::new(), verilated, _folder: folder })
    }

    /// The points with their hits in all runs. Outputs that are not the cycle-exact model's are failures.
    fn points(
        &self,
        runs: Range<u64>,
        seed: u64,
        omitted: Option<OperationId>,
        failures: &mut Vec<String>,
    ) -> Result<Vec<CoveragePoint>, Error> {
        let mut sum: Vec<CoveragePoint> = Vec::new();
        for run in runs {
            let episodes = run * EPISODES_PER_RUN..(run + 1) * EPISODES_PER_RUN;
            let Run { frames, expected } = Run::new(self.subject, &self.top, &self.shape, seed, episodes, omitted);
            let mut wrong = None;
            let points = self.verilated.coverage(frames, |cycle, words| {
                let expected = expected.get(cycle).and_then(Option::as_ref);
                if let (None, Some(what)) = (&wrong, expected.and_then(|it| it.fault(&self.top, words))) {
                    wrong = Some(format!("run {run}, cycle {cycle}: {what}"));
                }
            })?;
            failures.extend(wrong);
            if sum.is_empty() {
                sum = points;
            } else {
                // The same program has the same points in the same order.
                sum.iter_mut().zip(points).for_each(|(sum, point)| sum.hits += point.hits);
            }
        }
        Ok(sum)
    }

    fn is_out_of_reach(&self, point: &CoveragePoint) -> bool {
        let is_constant = || self.constants.contains(&(point.module.clone(), point.name.clone()));
        match point.kind {
            CoverageKind::Line => self.text.is_default_of_complete_case(point),
            CoverageKind::Branch => false,
            CoverageKind::Toggle => is_constant(),
        }
    }

    /// The counts of each kind. A hit of a point that is said to be out of reach is a failure.
    fn counts(&self, points: &[CoveragePoint], failures: &mut Vec<String>) -> [Counts; 3] {
        CoverageKind::ALL.map(|kind| {
            let mut counts = Counts::default();
            for point in points.iter().filter(|point| point.kind == kind) {
                if !self.is_out_of_reach(point) {
                    counts.reachable += 1;
                    counts.hit += u64::from(is_hit(point));
                } else if is_hit(point) {
                    let CoveragePoint { module, line, name, .. } = point;
                    failures.push(format!("{module}, line {line}: {name} is said to be out of reach and was reached"));
                } else {
                    counts.unreachable += 1;
                }
            }
            counts
        })
    }
}
