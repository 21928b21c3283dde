//! The host's side of the streams.

use crate::Shell;
use crate::frame::{Field, Frame};
use raypath_rtl::Config;
use raypath_sim::Words;
use raypath_sim::engine::PortEncoding;
use std::collections::HashMap;
use std::io::{self, BufReader, ErrorKind, Read, Write};

/// Sends jobs to a shell and compares the outcomes with those of the model, bit for bit.
#[derive(Debug)]
pub struct Host<'s> {
    shell: &'s Shell,
    encoding: PortEncoding,
}

/// The result of a comparison.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Comparison {
    /// Outcomes that were received.
    pub received: usize,
    /// Those that differ from the model's.
    pub different: usize,
    /// Messages about the first of them.
    pub differences: Vec<String>,
}

/// The most messages about differences.
const MAX_MESSAGES: usize = 5;

impl<'s> Host<'s> {
    /// The host of a shell around a datapath of this configuration.
    pub fn new(shell: &'s Shell, config: Config) -> Self {
        Self { shell, encoding: PortEncoding::of(config) }
    }

    /// The bytes of a job.
    pub fn job(&self, job: &Words) -> Vec<u8> {
        let frame = &self.shell.job;
        frame.encode(&self.values(frame, job))
    }

    /// The bytes that the shell must send for an outcome.
    pub fn outcome(&self, outcome: &Words) -> Vec<u8> {
        let frame = &self.shell.outcome;
        frame.encode(&self.values(frame, outcome))
    }

    /// Sends all jobs and reads their outcomes meanwhile. It ends early if the stream of outcomes ends.
    ///
    /// # Errors
    /// A stream that cannot be read or written.
    pub fn compare(
        &self,
        jobs: &[Words],
        outcomes: &[Words],
        mut to: impl Write + Send,
        from: impl Read,
    ) -> io::Result<Comparison> {
        // A thread writes while this one reads, so that neither side waits for the other with full buffers.
        std::thread::scope(|scope| {
            let sender = scope.spawn(move || {
                jobs.iter().try_for_each(|job| to.write_all(&self.job(job)))?;
                to.flush()
            });
            let compared = self.receive(outcomes, BufReader::new(from));
            let sent = sender.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            // If the other side has ended, the number of outcomes tells it.
            match sent {
                Err(problem) if problem.kind() != ErrorKind::BrokenPipe => Err(problem),
                _ => compared,
            }
        })
    }

    fn receive(&self, outcomes: &[Words], mut from: impl Read) -> io::Result<Comparison> {
        let frame = &self.shell.outcome;
        let mut comparison = Comparison::default();
        let mut bytes = vec![0; frame.bytes()];
        for outcome in outcomes {
            match from.read_exact(&mut bytes) {
                Err(problem) if problem.kind() == ErrorKind::UnexpectedEof => break,
                other => other?,
            }
            if bytes != self.outcome(outcome) {
                comparison.different += 1;
                if comparison.differences.len() < MAX_MESSAGES {
                    let difference = self.difference(&frame.decode(&bytes), outcome);
                    comparison.differences.push(format!("job {}: {difference}", comparison.received));
                }
            }
            comparison.received += 1;
        }
        Ok(comparison)
    }

    /// The first port that differs.
    fn difference(&self, found: &[u64], outcome: &Words) -> String {
        let frame = &self.shell.outcome;
        let expected = self.values(frame, outcome);
        let mut ports = frame.fields.iter().zip(found).zip(expected);
        let differing = ports.find(|((_, found), expected)| *found != expected);
        differing.map_or_else(
            || "the same values in another frame".to_string(),
            |((field, found), expected)| format!("{} is {found:x}, expected {expected:x}", field.port),
        )
    }

    /// The values of a frame's ports; 0 at those of other operations.
    fn values(&self, frame: &Frame, words: &Words) -> Vec<u64> {
        let ports = words.ports();
        let mut values: HashMap<&str, u64> =
            ports.iter().map(|port| (port.name.as_str(), self.encoding.to_port(port.kind, port.bits))).collect();
        values.insert("opcode", words.kind().opcode());
        let value = |field: &Field| values.get(field.name.as_str()).copied().unwrap_or(0);
        frame.fields.iter().map(value).collect()
    }
}
