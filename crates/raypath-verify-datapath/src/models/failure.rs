//! A wrong outcome, and the file that shows it.

use crate::oracle::Oracle;
use crate::subjects::Subject;
use raypath_model::{Model, WordModel, Words};
use raypath_sim::transactions::{Transaction, text};
use raypath_verify::{Error, files};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A wrong outcome: the number of the stream of jobs, the job's position in it, and what was found.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// The number of the stream.
    pub stream: u64,
    /// The job's position in the stream.
    pub job: u64,
    /// What was found.
    pub what: String,
}

impl Failure {
    /// The first of two failures.
    pub fn first(one: Option<Self>, other: Option<Self>) -> Option<Self> {
        one.into_iter().chain(other).min_by_key(|failure| (failure.stream, failure.job))
    }

    /// Writes the last of these jobs, which has the wrong outcome, and the beats of its sum, as a transaction file with
    /// the exact oracle's outcomes to a subfolder of `folder`.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn report(
        &self,
        subject: &Subject,
        model: &WordModel,
        mut jobs: Vec<Words>,
        seed: u64,
        folder: &Path,
    ) -> Result<String, Error> {
        let Self { stream, job, what } = self;
        let config = subject.config;
        let oracle = || Oracle::new(config.semantics, model);
        let Some(kind) = jobs.last().map(Words::kind) else { return Ok(format!("{subject}: {what}")) };
        jobs.retain(|job| job.kind() == kind);
        let fails = |jobs: &[Words]| {
            let (mut oracle, mut model) = (oracle(), model.clone());
            jobs.iter().any(|job| differs(&mut oracle, &mut model, job).is_err())
        };
        // Earlier jobs matter for sums: the shortest sequence that still fails is enough.
        let fewest = (0..jobs.len()).rev().find(|&first| fails(&jobs[first..])).unwrap_or(0);
        let mut oracle = oracle();
        let transaction = |(seq, job): (u64, &Words)| {
            let expected = oracle.run(job).ok()?;
            Some(Transaction { seq, category: 0, job: job.clone(), expected })
        };
        let transactions: Vec<Transaction> = (0..).zip(&jobs[fewest..]).filter_map(transaction).collect();
        let path = folder.join(format!("failure-models-{seed}-{stream}")).join(format!("{}.txt", kind.name()));
        files::write(&path, &text(model, kind, &transactions, config))?;
        let command = format!("raypath replay {} --engine model {}", path.display(), subject.options());
        Ok(format!(
            "{subject}, stream {stream}, job {job}: {what}\n           shrunk to {} jobs; to replay it: {}",
            transactions.len(),
            command.trim_end()
        ))
    }
}

/// Runs a job. The outcome, or how those of oracle and functional model differ.
pub fn differs(oracle: &mut Oracle, model: &mut WordModel, job: &Words) -> Result<Words, String> {
    let (expected, found) = (oracle.run(job)?, model.run(job));
    if found == expected {
        return Ok(found);
    }
    Err(format!("the functional model's outcome is {found:?}, the oracle's {expected:?}; the job is {job:?}"))
}
