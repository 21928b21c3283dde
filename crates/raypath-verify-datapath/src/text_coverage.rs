//! Coverage of the emitted text under the stimuli of campaigns: lines and branches as Verilator counts them, and bits
//! that change.

mod choices;
mod constants;
mod datapath;
mod reachable;
mod toggles;

use crate::campaign::FOLDER;
use crate::datapaths::TestedDatapath;
use choices::choices;
use constants::{Bit, constants, places};
use datapath::Design;
use raypath_hdl::text::plain;
use raypath_hdl::{Module, verilog, with_enables};
use raypath_tools::{CoverageKind, CoveragePoint, Options, Sources, Verilated, temporary_folder, versions};
use raypath_verify::proofs::cache;
use raypath_verify::{Error, Level, Request, Verdict, files};
use raypath_work::pool;
use reachable::Text;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use tempfile::TempDir;
use toggles::toggles;

/// The share of reachable points that must be hit, in percent.
const BAR: f64 = 99.0;

/// Designs whose bits miss the bar, with the share that is reached. A lower one is a failure; this one is a remark.
const BELOW: &[(&str, f64)] = &[
    // The places of the exit's queue, of which each takes few jobs in a run.
    (
        "lanes 2, rules chisel, format bf16, io recoded, registers ieee, control credit, sharing segregated, units \
         disjoint, interval 2, multiplier inferred, tag 3, barycentrics true, culling front, facing true, range true, \
         accumulators 2",
        98.40,
    ),
    (
        "lanes 4, rules chisel, format bf16, io recoded, registers ieee, control credit, sharing segregated, units \
         disjoint, interval 4, multiplier inferred, tag 3, barycentrics true, facing true, range true",
        98.40,
    ),
    (
        "lanes 2, rules paper, format bf16, rounding sum, control credit, sharing segregated, clock gating true, \
         multiplier inferred, tag 3, barycentrics true, facing true, range true, quantised boxes true",
        98.72,
    ),
    (
        "lanes none, rules chisel, format e4s5, control credit, sharing segregated, unit latency 3, multiplier \
         inferred, accumulators 4",
        98.11,
    ),
    // Bits that are 0 between the parts of multipliers and in products of short significands.
    (
        "lanes 2, rules bounds, box bits 8, unit latency 3, tag 3, barycentrics true, culling front, range true, \
         accumulators 2, exception flags true",
        97.85,
    ),
    (
        "lanes 2, rules paper, format bf16, io recoded, registers ieee, units disjoint, unit latency 3, clock gating \
         true, barycentrics true, culling front, facing true, conservative true, accumulators 8",
        98.83,
    ),
    ("lanes 4, rules bounds, box bits 8, rounding sum, clock gating true, facing true, accumulators 16", 98.77),
];

/// The share of the points of a kind that a design must reach, in percent.
fn bar(design: &str, kind: CoverageKind) -> f64 {
    let known = BELOW.iter().find(|(name, _)| *name == design && kind == CoverageKind::Toggle);
    known.map_or(BAR, |(_, percent)| *percent)
}

/// Counts the coverage of the level's datapaths, or of the one that the user chose; and of runs that leave an operation
/// out, which must be below the bar.
///
/// # Errors
/// A program is missing or fails; a design cannot be built; a file cannot be written.
pub fn verify(request: &mut Request<'_>) -> Result<Verdict, Error> {
    let (level, seed, shard) = (request.level, request.seed, request.shard);
    let choices = if request.is_chosen { vec![TestedDatapath::of(request)] } else { choices(level)? };
    let versions = versions();
    let shards = request.parts.phase(|| {
        let own: Vec<(usize, &TestedDatapath)> = shard.of(choices.iter().enumerate()).collect();
        pool::map(&own, pool::ALL_CORES, request.proceed, |(number, choice), _| {
            // Whatever is left out costs runs.
            let has_controls = *number == 0 || level > Level::Full;
            let (design, runs) = (Design::new(choice)?, level.pick(1, 2, 16));
            let key = design.key(runs, seed, &format!("{choice} {has_controls} {BAR} {BELOW:?} {versions:?}"))?;
            let compute = || Found::of(choice, &design, runs, seed, has_controls);
            Ok::<_, Error>(Some(cache().kept(&key, |found: &Found| found.failures.is_empty(), compute)?))
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
        verdict.remarks.push(found.remark);
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

/// The result of a design.
#[derive(Serialize, Deserialize)]
struct Found {
    /// Of each kind of points.
    counts: [Counts; 3],
    controls: u64,
    failures: Vec<String>,
    /// What the design reached.
    remark: String,
    /// The points that were not hit.
    report: String,
}

impl Found {
    /// The coverage of so many runs of a design, and the runs that leave something out if it has controls.
    fn of(subject: &TestedDatapath, design: &Design, runs: u64, seed: u64, has_controls: bool) -> Result<Self, Error> {
        let mut covered = Covered::new(design)?;
        let mut failures = Vec::new();
        let points = covered.points(0..runs, seed, None, &mut failures)?;
        let (top, text) = covered.for_proofs()?;
        covered.constants = constants(&text, top.name(), &places(&top), &points)?;
        let counts = covered.counts(&points, &mut failures);
        let name = subject.to_string();
        for (kind, counts) in CoverageKind::ALL.iter().zip(counts) {
            let bar = bar(&name, *kind);
            if counts.percent() < bar {
                failures.push(format!("{} coverage is {counts}, expected {bar} %", kind.name()));
            }
        }
        let reached = CoverageKind::ALL.iter().zip(counts).map(|(kind, counts)| (kind.name(), counts));
        let reached: Vec<String> = reached.map(|(kind, counts)| format!("{kind} {:.2} %", counts.percent())).collect();
        let is_below = CoverageKind::ALL.iter().zip(counts).any(|(_, counts)| counts.percent() < BAR);
        let remark = format!("{name}: {}{}", reached.join(", "), if is_below { ", below the bar" } else { "" });
        let omissions = if has_controls { design.omissions() } else { Vec::new() };
        let omitted: Vec<usize> = (0..omissions.len()).collect();
        let controls = pool::map(&omitted, pool::ALL_CORES, &mut |_| true, |&omitted, _| {
            let mut failures = Vec::new();
            let points = covered.points(0..runs, seed, Some(omitted), &mut failures)?;
            if covered.counts(&points, &mut failures).iter().all(|counts| counts.percent() >= BAR) {
                failures.push(format!("without {}, the coverage is not below {BAR} %", omissions[omitted]));
            }
            Ok::<_, Error>(Some(failures))
        })?;
        failures.extend(controls.into_iter().flatten().flatten());
        let rest = points.iter().filter(|point| !(is_hit(point) || covered.is_out_of_reach(point)));
        let lines = rest
            .map(|point| format!("  {}, line {}: {} {}\n", point.module, point.line, point.kind.name(), point.name));
        let report = std::iter::once(format!("{name}\n")).chain(lines).collect();
        let failures = failures.into_iter().map(|failure| format!("{name}: {failure}")).collect();
        Ok(Self { counts, controls: omissions.len() as u64, failures, remark, report })
    }
}

/// Adds the points of another run of the same program, which has the same points in the same order.
fn add(sum: &mut Vec<CoveragePoint>, points: Vec<CoveragePoint>) {
    if sum.is_empty() {
        *sum = points;
        return;
    }
    for (sum, point) in sum.iter_mut().zip(points) {
        // Bits begin each run with 0: one that rises in two runs has not fallen.
        sum.hits = if point.kind == CoverageKind::Toggle { sum.hits.max(point.hits) } else { sum.hits + point.hits };
    }
}

/// Whether a line or a branch was executed, or a bit has risen and fallen.
fn is_hit(point: &CoveragePoint) -> bool {
    point.hits >= if point.kind == CoverageKind::Toggle { 2 } else { 1 }
}

/// A design's text in Verilator.
struct Covered<'d> {
    design: &'d Design,
    text: Text,
    /// The bits that are proved to be constant, with their values.
    constants: BTreeMap<Bit, bool>,
    verilated: Verilated,
    /// Has the program.
    _folder: TempDir,
}

impl<'d> Covered<'d> {
    fn new(design: &'d Design) -> Result<Self, Error> {
        let (top, folder) = (&design.top, temporary_folder()?);
        let text = Text::new(&verilog::sources(top, &[])?);
        let Sources { files, .. } = Sources::write(top, folder.path())?;
        let options = Options { coverage: true, ..Options::default() };
        let verilated = Verilated::build_sources(&files, top, folder.path(), &options)?;
        Ok(Self { design, text, constants: BTreeMap::new(), verilated, _folder: folder })
    }

    /// The design and its text with enables in place of clock gates, for proofs with one clock, and without structures,
    /// so that each signal has its name in the netlist.
    fn for_proofs(&self) -> Result<(Arc<Module>, String), Error> {
        let top = plain(&with_enables(&self.design.top));
        let text = verilog::sources(&top, &[])?.into_iter().map(|source| source.text).collect();
        Ok((top, text))
    }

    /// The points with their hits in all runs. Outputs that are not the model's are failures.
    fn points(
        &self,
        runs: Range<u64>,
        seed: u64,
        omitted: Option<usize>,
        failures: &mut Vec<String>,
    ) -> Result<Vec<CoveragePoint>, Error> {
        let mut sum: Vec<CoveragePoint> = Vec::new();
        let (frames, expected): (Vec<_>, Vec<_>) = runs.map(|number| self.design.run(seed, number, omitted)).unzip();
        let toggles = toggles(&self.design.top, &frames)?;
        for (number, ((frames, expected), toggles)) in frames.into_iter().zip(expected).zip(toggles).enumerate() {
            let mut wrong = None;
            let mut points = self.verilated.coverage(frames, |cycle, words| {
                let expected = expected[cycle].as_ref().filter(|_| wrong.is_none());
                if let Some(what) = expected.and_then(|expected| expected.fault(&self.design.top, words)) {
                    wrong = Some(format!("run {number}, cycle {cycle}: {what}"));
                }
            })?;
            failures.extend(wrong);
            points.extend(toggles);
            add(&mut sum, points);
        }
        Ok(sum)
    }

    fn is_out_of_reach(&self, point: &CoveragePoint) -> bool {
        let constant = |name: &str| self.constants.get(&(point.module.clone(), name.to_string())).copied();
        match point.kind {
            CoverageKind::Line => self.text.is_default_of_complete_case(point),
            CoverageKind::Branch => self.text.always(point).and_then(constant) == Some(true),
            CoverageKind::Toggle => constant(&point.name).is_some(),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bit_that_rises_in_each_run_and_never_falls_is_not_covered() {
        let points = |hits: u64| {
            let point = |kind| CoveragePoint { kind, module: "m".into(), line: 1, name: "a".into(), hits };
            CoverageKind::ALL.map(point).to_vec()
        };
        let mut sum = Vec::new();
        for hits in [1, 0, 1] {
            add(&mut sum, points(hits));
        }
        assert_eq!(
            sum.iter().map(|point| (point.hits, is_hit(point))).collect::<Vec<_>>(),
            [(2, true), (2, true), (1, false)]
        );
        add(&mut sum, points(2));
        assert!(sum.iter().all(is_hit));
    }
}
