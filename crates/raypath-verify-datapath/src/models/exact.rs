//! Datapaths of any configuration against the exact oracle.

use super::failure::{Failure, differs};
use super::in_order::InOrder;
use crate::layout::Layout;
use crate::oracle::Oracle;
use crate::stimuli::{Stimuli, splitmix64};
use crate::subjects::Subject;
use raypath_model::{Shape, WordModel, Words};
use raypath_sim::engine::shape;
use raypath_tools::pool;
use raypath_verify::{Error, Request, Verdict};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::atomic::Ordering;

/// The greatest number of jobs in a stream.
const JOBS_PER_STREAM: u64 = 10_000;

/// The counts of a worker, or of all.
#[derive(Serialize, Deserialize)]
struct Tally {
    streams: u64,
    /// For each subject, the number of streams that refuted the oracle with its mistake.
    refuted: Vec<u64>,
    wrong: Option<Failure>,
}

impl Tally {
    fn new(subjects: usize) -> Self {
        Self { streams: 0, refuted: vec![0; subjects], wrong: None }
    }

    fn and(mut self, other: Self) -> Self {
        self.streams += other.streams;
        self.refuted.iter_mut().zip(other.refuted).for_each(|(refuted, more)| *refuted += more);
        self.wrong = Failure::first(self.wrong, other.wrong);
        self
    }
}

/// Runs `jobs` jobs of each subject, in streams that each begin after a reset.
pub fn verify(request: &mut Request<'_>, subjects: &[Subject], jobs: u64, folder: &Path) -> Result<Verdict, Error> {
    let (seed, count, length) = (request.seed, subjects.len() as u64, jobs.clamp(1, JOBS_PER_STREAM));
    let streams = jobs.div_ceil(length) * count;
    let cases = request.cases(streams, 1);
    let stream = |number: u64| Stream::new(&subjects[(number % count) as usize], seed, number);
    let empty = || Tally::new(subjects.len());
    let mut is_stopped = false;
    let shards = request.parts.phase(|| {
        let finished = pool::run::<_, Error>(cases, pool::ALL_CORES, request.proceed, |queue| {
            let mut tally = empty();
            queue.run(|number, stop| {
                let stream = stream(number)?;
                tally.streams += 1;
                tally.refuted[(number % count) as usize] += u64::from(stream.refutes(length));
                if let Some(wrong) = stream.run(length) {
                    tally.wrong.get_or_insert(wrong);
                    stop.store(true, Ordering::Relaxed);
                }
                Ok(())
            });
            Ok(tally)
        })?;
        is_stopped = finished.is_stopped;
        Ok::<_, Error>(finished.workers.into_iter().fold(empty(), Tally::and))
    })?;
    let tally = shards.into_iter().fold(empty(), Tally::and);
    let found = tally.refuted.iter().filter(|&&streams| streams > 0).count();
    let datapaths = if count == 1 { subjects[0].to_string() } else { format!("{count} datapaths") };
    let run = tally.streams * length;
    let mut verdict = Verdict {
        covered: format!("{run} jobs of {datapaths} through exact oracle, functional and cycle-exact model"),
        remarks: vec![format!("exact oracles with a deliberate mistake, one for each datapath: {found} refuted")],
        failures: Vec::new(),
        is_stopped,
    };
    let is_whole = tally.streams == streams && tally.wrong.is_none();
    let missed = subjects.iter().zip(&tally.refuted).filter(|(_, streams)| is_whole && **streams == 0);
    verdict.failures.extend(missed.map(|(subject, _)| {
        format!("the comparison cannot fail: it does not refute the mistake {:?} in {subject}", subject.mistake)
    }));
    if let Some(wrong) = tally.wrong {
        let stream = stream(wrong.stream)?;
        let jobs = stream.jobs().take(wrong.job as usize + 1).collect();
        verdict.failures.push(wrong.report(stream.subject, &stream.model, jobs, seed, folder)?);
    }
    Ok(verdict)
}

/// A sequence of jobs of a subject, reproducible by seed and number.
struct Stream<'s> {
    subject: &'s Subject,
    seed: u64,
    number: u64,
    model: WordModel,
    layout: Layout,
    shape: Shape,
}

impl<'s> Stream<'s> {
    fn new(subject: &'s Subject, seed: u64, number: u64) -> Result<Self, Error> {
        let datapath = subject.datapath();
        let (model, shape) = (datapath.model(), shape(subject.config, &datapath.elaborate()?));
        Ok(Self { subject, seed, number, layout: Layout::of(&model), model, shape })
    }

    fn jobs(&self) -> impl Iterator<Item = Words> + '_ {
        let own = splitmix64(splitmix64(self.seed).wrapping_add(2) ^ self.number);
        let mut stimuli = Stimuli::new(&self.layout, &self.model, own);
        let mut words = Vec::new();
        std::iter::repeat_with(move || {
            let kind = stimuli.next(&mut words);
            self.model.job_of_words(kind, &words)
        })
    }

    fn oracle(&self) -> Oracle {
        Oracle::new(self.subject.config.semantics, &self.model)
    }

    /// Whether an oracle with the subject's mistake differs from the functional model.
    fn refutes(&self, length: u64) -> bool {
        self.difference(self.oracle().with(self.subject.mistake), length).is_some()
    }

    /// The first job for which oracle and functional model differ, and how.
    fn difference(&self, mut oracle: Oracle, length: u64) -> Option<(u64, String)> {
        let mut model = self.model.clone();
        (0..length)
            .zip(self.jobs())
            .find_map(|(index, job)| Some((index, differs(&mut oracle, &mut model, &job).err()?)))
    }

    /// Runs the stream up to the first wrong outcome.
    fn run(&self, length: u64) -> Option<Failure> {
        let (mut oracle, mut model) = (self.oracle(), self.model.clone());
        let mut cycles = InOrder::new(self.model.clone(), &self.shape);
        let stream = self.number;
        let failure = |(job, what)| Some(Failure { stream, job, what });
        for (index, job) in (0..length).zip(self.jobs()) {
            match differs(&mut oracle, &mut model, &job) {
                Err(what) => return failure((index, what)),
                Ok(outcome) => {
                    if let Some(what) = cycles.next(&job, outcome) {
                        return failure((index, what));
                    }
                }
            }
        }
        cycles.finish().and_then(|what| failure((length - 1, what)))
    }
}
