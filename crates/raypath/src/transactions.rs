//! Files of transactions: jobs with the outcomes that were recorded for them.

use crate::models::PaperModel;
use crate::transaction_format::{Column, Columns, columns};
use crate::transaction_lines::Lines;
use raypath_model::{Functional, OnPorts};
use raypath_ops::{JobKind, PortValue};
use raypath_rtl::Config;
use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A job, where it stood in its stream, and what was answered.
#[derive(Debug, Clone, PartialEq)]
pub struct Transaction<M: PaperModel = Functional> {
    /// Its position in the stream that the files share.
    pub seq: u64,
    /// The generator's category.
    pub category: u64,
    /// The job.
    pub job: M::Job,
    /// The recorded outcome.
    pub expected: M::Outcome,
}

/// Why a file is no file of transactions.
#[derive(Debug, Error)]
pub enum TransactionError {
    /// The file cannot be read.
    #[error("{}: {problem}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        problem: std::io::Error,
    },
    /// A line cannot be read: the compressed data are damaged, it is no text, or larger than text may be.
    #[error("{}:{line}: {problem}, expected text, plain or gzip", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What the system said.
        problem: std::io::Error,
    },
    /// The name does not say what kind of jobs it has.
    #[error("{}: the name begins with no kind of job, expected triangle, quadbox, euclidean or angular (or give --kind)", .0.display())]
    UnknownKind(PathBuf),
    /// Jobs that the configuration has no mode for.
    #[error("{}: {kind} jobs, but the configuration ({config}) has no distance modes, expected triangle or quadbox", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The kind.
        kind: JobKind,
        /// What it would run on.
        config: Config,
    },
    /// A line with too few or too many fields.
    #[error("{}:{line}: {found} fields, expected {expected} for {kind}{}", path.display(), in_words(*.lanes))]
    Fields {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// How many fields it has.
        found: usize,
        /// How many a line of this kind has.
        expected: usize,
        /// The kind.
        kind: JobKind,
        /// Lanes of its beats, where it has any.
        lanes: Option<usize>,
    },
    /// More transactions than are held at a time.
    #[error("{}:{line}: more than {MOST_TRANSACTIONS} transactions, expected at most that (divide the file)", path.display())]
    TooMany {
        /// The file.
        path: PathBuf,
        /// The line of the first that is too much, from 1.
        line: usize,
    },
    /// A field that is no number, or too large a one.
    #[error("{}:{line}: field {field} ({name}) is '{value}', expected {expected}", path.display())]
    Field {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The field, from 1.
        field: usize,
        /// What it stands for.
        name: String,
        /// What is there, or its beginning.
        value: String,
        /// What should be.
        expected: String,
    },
}

/// All transactions of a file are held at once; so many take some gigabytes at most.
const MOST_TRANSACTIONS: usize = 1 << 22;

fn in_words(lanes: Option<usize>) -> String {
    lanes.map(|lanes| format!(" with {lanes} lanes")).unwrap_or_default()
}

/// Reads a file, plain or gzip, with jobs of one kind for a configuration, whose model is `model`: `kind`, or that which
/// the file's name begins with. Empty lines and lines that begin with `#` are passed over.
///
/// # Errors
/// A file that cannot be read, a kind that the name does not tell or the configuration does not answer, lines that do not
/// fit the kind, the lanes or the format, and more than 4,194,304 transactions, 64 KiB in a line or 4 GiB of text.
pub fn read<M: PaperModel>(
    path: &Path,
    kind: impl Into<Option<JobKind>>,
    model: &M,
    config: Config,
) -> Result<Vec<Transaction<M>>, TransactionError> {
    // Before the name is looked at: a file that is not there is the greater fault than a name that says nothing.
    let file = File::open(path).map_err(|problem| TransactionError::File { path: path.to_path_buf(), problem })?;
    read_from(file, path, kind, model, config)
}

/// Reads a stream as [`read`] reads a file; `path` is for messages, and for the kind where none is given.
///
/// # Errors
/// As there.
pub fn read_from<M: PaperModel>(
    stream: impl Read,
    path: &Path,
    kind: impl Into<Option<JobKind>>,
    model: &M,
    config: Config,
) -> Result<Vec<Transaction<M>>, TransactionError> {
    let mut lines =
        Lines::new(stream).map_err(|problem| TransactionError::File { path: path.to_path_buf(), problem })?;
    let kind = kind.into().map_or_else(|| kind_of(path), Ok)?;
    if !config.kinds().contains(&kind) {
        return Err(TransactionError::Unsupported { path: path.to_path_buf(), kind, config });
    }
    let parser = Parser { path, kind, model, columns: columns(kind, config) };
    let mut transactions = Vec::new();
    for line in 1.. {
        let unreadable = |problem| TransactionError::Line { path: path.to_path_buf(), line, problem };
        let Some(text) = lines.next().map_err(unreadable)? else { break };
        if text.trim().is_empty() || text.starts_with('#') {
            continue;
        }
        if transactions.len() == MOST_TRANSACTIONS {
            return Err(TransactionError::TooMany { path: path.to_path_buf(), line });
        }
        transactions.push(parser.parse(line, text)?);
    }
    Ok(transactions)
}

/// The kind of job that a file's name begins with: `triangle.txt.gz` has triangles.
fn kind_of(path: &Path) -> Result<JobKind, TransactionError> {
    let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    let kind = JobKind::ALL.into_iter().find(|kind| name.starts_with(kind.name()));
    kind.ok_or_else(|| TransactionError::UnknownKind(path.to_path_buf()))
}

struct Parser<'p, M> {
    path: &'p Path,
    kind: JobKind,
    model: &'p M,
    columns: Columns,
}

impl<M: PaperModel> Parser<'_, M> {
    fn parse(&self, line: usize, text: &str) -> Result<Transaction<M>, TransactionError> {
        let Columns { inputs, outputs, lanes } = &self.columns;
        let fields: Vec<&str> = text.split_ascii_whitespace().collect();
        let first_output = 2 + inputs.len();
        let expected = first_output + outputs.len();
        if fields.len() != expected {
            let (path, kind, found) = (self.path.to_path_buf(), self.kind, fields.len());
            return Err(TransactionError::Fields { path, line, found, expected, kind, lanes: *lanes });
        }
        let seq = self.number(line, 0, "seq", 64, fields[0])?;
        let category = self.number(line, 1, "cat", 64, fields[1])?;
        let inputs = self.ports(line, 2, inputs, &fields[2..first_output])?;
        let outputs = self.ports(line, first_output, outputs, &fields[first_output..])?;
        let at = |ports: &HashMap<&str, u64>, name: &str| ports.get(name).copied().unwrap_or(0);
        Ok(Transaction {
            seq,
            category,
            job: self.model.job(self.kind, |name| at(&inputs, name)),
            expected: self.model.outcome(self.kind, |name| at(&outputs, name)),
        })
    }

    fn ports<'c>(
        &self,
        line: usize,
        first: usize,
        columns: &'c [Column],
        fields: &[&str],
    ) -> Result<HashMap<&'c str, u64>, TransactionError> {
        let mut ports = HashMap::new();
        for (index, (column, field)) in columns.iter().zip(fields).enumerate() {
            let value = self.number(line, first + index, &column.port, column.width, field)?;
            *ports.entry(column.port.as_str()).or_insert(0) |= value << column.bit.unwrap_or(0);
        }
        Ok(ports)
    }

    fn number(&self, line: usize, index: usize, name: &str, width: u32, text: &str) -> Result<u64, TransactionError> {
        let plain_digits = text.bytes().all(|byte| byte.is_ascii_hexdigit());
        let value = u64::from_str_radix(text, 16).ok().filter(|_| plain_digits);
        value.filter(|value| width == 64 || value >> width == 0).ok_or_else(|| TransactionError::Field {
            path: self.path.to_path_buf(),
            line,
            field: index + 1,
            name: name.to_string(),
            value: text.chars().take(40).flat_map(char::escape_debug).collect(),
            expected: format!("hexadecimal digits, at most {:x}", u64::MAX >> (64 - width)),
        })
    }
}

/// One stream of all files, in the order of `seq`.
pub fn merge<M: PaperModel>(files: Vec<Vec<Transaction<M>>>) -> Vec<Transaction<M>> {
    let mut stream: Vec<Transaction<M>> = files.into_iter().flatten().collect();
    stream.sort_by_key(|transaction| transaction.seq);
    stream
}

/// Transactions of one kind as the text of a file.
pub fn text<M: PaperModel>(kind: JobKind, transactions: &[Transaction<M>], config: Config) -> String {
    let columns = columns(kind, config);
    let mut text = String::new();
    for Transaction { seq, category, job, expected } in transactions {
        let inputs = written(&columns.inputs, &job.ports());
        let outputs = written(&columns.outputs, &expected.ports());
        text += &format!("{seq:x} {category:x} {inputs} {outputs}\n");
    }
    text
}

fn written(columns: &[Column], ports: &[PortValue]) -> String {
    let of_column = |column: &Column| {
        let bits = ports.iter().find(|port| port.name == column.port).map_or(0, |port| port.bits);
        let mask = u64::MAX >> (64 - column.width);
        format!("{:x}", bits >> column.bit.unwrap_or(0) & mask)
    };
    columns.iter().map(of_column).collect::<Vec<_>>().join(" ")
}
