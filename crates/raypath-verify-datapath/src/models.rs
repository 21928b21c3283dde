//! The functional model against the exact oracle, job by job: the default configuration with many jobs, and every
//! datapath of [`datapaths::all`] with some. Oracles with a deliberate mistake, one for each rule that matters in a
//! datapath, must be refuted by the same jobs.

use crate::campaign::failure::reduced;
use crate::datapaths::{self, TestedDatapath};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use raypath_model::{Model, OperationId, WordModel, Words};
use raypath_ops::{Culling, Rounding, Rules};
use raypath_oracle::exact::{Mistake, Oracle};
use raypath_oracle::stimuli::Stimuli;
use raypath_rtl::{Accumulators, Lanes};
use raypath_sim::transactions::{Transaction, text};
use raypath_verify::campaign::{Campaign, Tally};
use raypath_verify::{Error, Request, Verdict, files};
use std::collections::BTreeMap;
use std::path::Path;

/// The number of jobs in a stream, which begins after a reset.
const JOBS_PER_STREAM: u64 = 2048;
/// The number of streams after which each mistake must be refuted: some show in few jobs only.
const ENOUGH: u64 = 32;

/// Runs the jobs. Writes a failure to a subfolder of `folder`.
///
/// # Errors
/// A file cannot be written.
pub fn verify(request: &mut Request<'_>, folder: &Path) -> Result<Verdict, Error> {
    let jobs = request.jobs.unwrap_or(request.level.pick(4_000_000, 20_000_000, 1_000_000_000));
    let of_each = request.level.pick(JOBS_PER_STREAM, 40 * JOBS_PER_STREAM, 400 * JOBS_PER_STREAM);
    let others = if request.is_chosen { Vec::new() } else { datapaths::all() };
    let subjects: Vec<TestedDatapath> = [TestedDatapath::of(request)].into_iter().chain(others).collect();
    // The streams of all subjects in turn; then those of the first, which has more.
    let (count, streams) = (subjects.len() as u64, jobs.div_ceil(JOBS_PER_STREAM));
    let in_turn = count * of_each.min(jobs).div_ceil(JOBS_PER_STREAM);
    let subject = |number: u64| if number < in_turn { (number % count) as usize } else { 0 };
    let campaign = Campaign::of_episodes(22, in_turn + streams.saturating_sub(in_turn / count));
    let seed = request.seed;
    let (tally, is_stopped) = campaign.run(
        request,
        || Ok(BTreeMap::new()),
        |prepared, number, rng, tally| {
            let index = subject(number);
            let prepared = prepared.entry(index).or_insert_with(|| Prepared::new(&subjects[index]));
            prepared.run(index, rng, tally);
            Ok(())
        },
    )?;
    let total = tally.count("streams") * JOBS_PER_STREAM;
    // For each mistake, the datapaths that show it, the streams that these ran, and how many of them refuted it.
    let mut mistakes: BTreeMap<String, [u64; 3]> = BTreeMap::new();
    let mut failures = Vec::new();
    for (index, subject) in subjects.iter().enumerate() {
        let run = tally.count(&index.to_string());
        for mistake in Prepared::new(subject).mistakes.iter().filter(|_| run > 0 && tally.failures() == 0) {
            let is_refuted = tally.count(&format!("{index} {mistake:?}")) > 0;
            let of = mistakes.entry(format!("{mistake:?}")).or_default();
            *of = [of[0] + 1, of[1] + run, of[2] + u64::from(is_refuted)];
            if run >= ENOUGH && !is_refuted {
                failures
                    .push(format!("the comparison cannot fail: nothing refutes the mistake {mistake:?} in {subject}"));
            }
        }
    }
    for (mistake, _) in mistakes.iter().filter(|(_, [_, run, refuted])| *run >= ENOUGH && *refuted == 0) {
        failures.push(format!("the comparison cannot fail: no datapath refutes the mistake {mistake}"));
    }
    let [tried, _, refuted] = mistakes.values().fold([0; 3], |sum, of| [0, 1, 2].map(|i| sum[i] + of[i]));
    if let Some((number, what)) = tally.first_failure() {
        let index = subject(number);
        let jobs = Prepared::new(&subjects[index]).jobs(&mut campaign.rng(seed, number));
        let folder = folder.join(format!("failure-models-{seed}-{number}"));
        let shown = Prepared::new(&subjects[index]).report(&subjects[index], jobs, &folder)?;
        failures.push(format!("{}, stream {number}: {what}\n           {shown}", subjects[index]));
    }
    Ok(Verdict {
        covered: format!("{total} jobs of {count} datapaths through exact oracle and functional model"),
        remarks: vec![format!("{refuted} of {tried} exact oracles with a deliberate mistake refuted")],
        failures,
        is_stopped,
    })
}

/// A datapath's model and oracle.
struct Prepared {
    model: WordModel,
    oracle: Oracle,
    mistakes: Vec<Mistake>,
}

impl Prepared {
    fn new(subject: &TestedDatapath) -> Self {
        let model = subject.datapath().model();
        let oracle = Oracle::new(subject.config.semantics, &model);
        Self { mistakes: mistakes(subject, &model.kinds()), model, oracle }
    }

    /// The jobs of a stream.
    fn jobs(&self, rng: &mut ChaCha8Rng) -> Vec<Words> {
        let (mut stimuli, mut words) = (Stimuli::new(&self.model, rng.random()), Vec::new());
        let job = |_| {
            let kind = stimuli.next(&mut words);
            self.model.job_of_words(kind, &words)
        };
        (0..JOBS_PER_STREAM).map(job).collect()
    }

    /// Runs a stream up to the first wrong outcome, and counts the mistakes that it refutes. A mistake that this worker
    /// has refuted is not tried again.
    fn run(&mut self, index: usize, rng: &mut ChaCha8Rng, tally: &mut Tally) {
        let jobs = self.jobs(rng);
        self.model.reset();
        let mut oracle = self.oracle.clone();
        let outcomes: Vec<Words> = jobs.iter().map(|job| self.model.run(job)).collect();
        tally.add("streams", 1_u64);
        tally.add(index.to_string(), 1_u64);
        for (place, (job, found)) in jobs.iter().zip(&outcomes).enumerate() {
            if let Some(what) = differs(&mut oracle, job, found) {
                return tally.fail(|| format!("job {place}: {what}"));
            }
        }
        self.mistakes.retain(|mistake| {
            let mut wrong = self.oracle.clone().with(*mistake);
            let is_refuted = jobs.iter().zip(&outcomes).any(|(job, found)| differs(&mut wrong, job, found).is_some());
            tally.add(format!("{index} {mistake:?}"), is_refuted);
            !is_refuted
        });
    }

    /// Writes the fewest jobs that still have a wrong outcome as a transaction file with the oracle's outcomes.
    fn report(&self, subject: &TestedDatapath, jobs: Vec<Words>, folder: &Path) -> Result<String, Error> {
        let fails = |jobs: &[Words]| {
            let (mut oracle, mut model) = (self.oracle.clone(), self.model.clone());
            jobs.iter().any(|job| differs(&mut oracle, job, &model.run(job)).is_some())
        };
        let jobs = reduced(jobs, fails);
        let Some(kind) = jobs.last().map(Words::kind) else { return Ok("the failure does not repeat".to_string()) };
        let mut oracle = self.oracle.clone();
        let transaction = |(seq, job): (u64, &Words)| {
            let expected = oracle.run(job).ok()?;
            Some(Transaction { seq, category: 0, job: job.clone(), expected })
        };
        let transactions: Vec<Transaction> = (0..).zip(&jobs).filter_map(transaction).collect();
        let path = folder.join(format!("{}.txt", kind.name()));
        files::write(&path, &text(&self.model, kind, &transactions, subject.config))?;
        let command = format!("raypath replay {} --engine model {}", path.display(), subject.options());
        Ok(format!("shrunk to {} jobs; to replay it: {}", jobs.len(), command.trim_end()))
    }
}

/// How the oracle's outcome of a job differs from the one that was found.
fn differs(oracle: &mut Oracle, job: &Words, found: &Words) -> Option<String> {
    match oracle.run(job) {
        Ok(expected) if expected == *found => None,
        Ok(expected) => Some(format!("the outcome is {found:?}, expected {expected:?}; the job is {job:?}")),
        Err(problem) => Some(problem),
    }
}

/// The mistakes that change an outcome of a datapath with these operations.
fn mistakes(subject: &TestedDatapath, kinds: &[OperationId]) -> Vec<Mistake> {
    let (semantics, features) = (subject.config.semantics, subject.config.semantics.features);
    let has = |names: &[&str]| kinds.iter().any(|kind| names.contains(&kind.name()));
    let (is_chisel, is_sum) = (semantics.rules == Rules::Chisel, semantics.rounding == Rounding::Sum);
    let is_bounds = matches!(semantics.rules_in_full(), Rules::Bounds(_)) && has(&["quadbox"]);
    let (has_triangles, has_sums) = (has(&["triangle"]), has(&["euclidean"]));
    // Boxes that are sorted by ruling 5, and limited by ruling 3.
    let has_sorted = has(&["octbox", "quantised_box"]) || has(&["quadbox"]) && !is_chisel;
    let table = [
        (Mistake::TiesAway, true),
        (Mistake::ShortSignificand, true),
        (Mistake::FlushedSubnormals, true),
        (Mistake::NoUnderflow, features.exception_flags),
        (Mistake::ShortWindow, is_sum && has_triangles),
        (Mistake::NoMargin, is_bounds),
        (Mistake::StrictBoxes, has(&["quadbox", "octbox"])),
        (Mistake::DirectionIgnored, has(&["quadbox", "octbox", "quantised_box"])),
        (Mistake::ExtentIgnored, has_sorted),
        (Mistake::TiesReversed, has_sorted),
        (Mistake::UnusedChildren, has(&["quantised_box"])),
        (Mistake::OtherOrder, !is_sum && has_triangles),
        (Mistake::OpenEdges, !is_chisel && has_triangles),
        (Mistake::CullingIgnored, features.culling != Culling::None && has_triangles),
        (Mistake::OpenRange, features.range && has_triangles),
        (Mistake::MasksIgnored, has_sums),
        (Mistake::Neighbours, !is_sum && has_sums && semantics.lanes != Lanes::Two),
        (Mistake::NeverRestarted, has_sums),
        (Mistake::OneAccumulator, features.accumulators != Accumulators::One && has_sums),
        (Mistake::StrictKeys, has(&["key_compare"])),
        (Mistake::OpenPoints, has(&["point_in_box"])),
        (Mistake::SpheresBehind, has(&["sphere"])),
    ];
    table.into_iter().filter(|(_, shows)| *shows).map(|(mistake, _)| mistake).collect()
}
