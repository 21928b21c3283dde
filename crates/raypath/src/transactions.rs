//! Files of transactions: jobs with the outcomes that were recorded for them.

use crate::transaction_format::{Column, columns};
use flate2::read::MultiGzDecoder;
use raypath_ops::{Job, JobKind, Outcome};
use std::collections::HashMap;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A job, where it stood in its stream, and what was answered.
#[derive(Debug, Clone, PartialEq)]
pub struct Transaction {
    /// Its position in the stream that the files share.
    pub seq: u64,
    /// The generator's category.
    pub category: u64,
    /// The job.
    pub job: Job,
    /// The recorded outcome.
    pub expected: Outcome,
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
    /// A line cannot be read: the compressed data are damaged, or it is no text.
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
    /// A line with too few or too many fields.
    #[error("{}:{line}: {found} fields, expected {expected} for {kind}", path.display())]
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
        /// What is there.
        value: String,
        /// What should be.
        expected: String,
    },
}

/// Reads a file, plain or gzip, with jobs of one kind: `kind`, or that which the file's name begins with. Empty lines
/// and lines that begin with `#` are passed over.
pub fn read(path: &Path, kind: impl Into<Option<JobKind>>) -> Result<Vec<Transaction>, TransactionError> {
    // Before the name is looked at: a file that is not there is the greater fault than a name that says nothing.
    let file = open(path).map_err(|problem| TransactionError::File { path: path.to_path_buf(), problem })?;
    let parser = Parser::new(path, kind.into().map_or_else(|| kind_of(path), Ok)?);
    let mut transactions = Vec::new();
    for (index, line) in file.lines().enumerate() {
        let unreadable = |problem| TransactionError::Line { path: path.to_path_buf(), line: index + 1, problem };
        let line = line.map_err(unreadable)?;
        if !line.trim().is_empty() && !line.starts_with('#') {
            transactions.push(parser.parse(index + 1, &line)?);
        }
    }
    Ok(transactions)
}

/// The kind of job that a file's name begins with: `triangle.txt.gz` has triangles.
fn kind_of(path: &Path) -> Result<JobKind, TransactionError> {
    let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    let kind = JobKind::ALL.into_iter().find(|kind| name.starts_with(kind.name()));
    kind.ok_or_else(|| TransactionError::UnknownKind(path.to_path_buf()))
}

fn open(path: &Path) -> std::io::Result<Box<dyn BufRead>> {
    let mut file = BufReader::new(File::open(path)?);
    let is_gzip = file.fill_buf()?.starts_with(&[0x1f, 0x8b]);
    let plain: Box<dyn Read> = if is_gzip { Box::new(MultiGzDecoder::new(file)) } else { Box::new(file) };
    Ok(Box::new(BufReader::new(plain)))
}

struct Parser<'p> {
    path: &'p Path,
    kind: JobKind,
    inputs: Vec<Column>,
    outputs: Vec<Column>,
}

impl<'p> Parser<'p> {
    fn new(path: &'p Path, kind: JobKind) -> Self {
        let columns = columns(kind);
        Self { path, kind, inputs: columns.inputs, outputs: columns.outputs }
    }

    fn parse(&self, line: usize, text: &str) -> Result<Transaction, TransactionError> {
        let fields: Vec<&str> = text.split_ascii_whitespace().collect();
        let expected = 2 + self.inputs.len() + self.outputs.len();
        if fields.len() != expected {
            let (path, kind, found) = (self.path.to_path_buf(), self.kind, fields.len());
            return Err(TransactionError::Fields { path, line, found, expected, kind });
        }
        let seq = self.number(line, 0, "seq", 64, fields[0])?;
        let category = self.number(line, 1, "cat", 64, fields[1])?;
        let first_output = 2 + self.inputs.len();
        let inputs = self.ports(line, 2, &self.inputs, &fields[2..first_output])?;
        let outputs = self.ports(line, first_output, &self.outputs, &fields[first_output..])?;
        let at = |ports: &HashMap<&str, u64>, name: &str| ports.get(name).copied().unwrap_or(0);
        Ok(Transaction {
            seq,
            category,
            job: Job::from_ports(self.kind, |name| at(&inputs, name)),
            expected: Outcome::from_ports(self.kind, |name| at(&outputs, name)),
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
            value: text.to_string(),
            expected: format!("hexadecimal digits, at most {:x}", u64::MAX >> (64 - width)),
        })
    }
}

/// One stream of all files, in the order of `seq`.
pub fn merge(files: Vec<Vec<Transaction>>) -> Vec<Transaction> {
    let mut stream: Vec<Transaction> = files.into_iter().flatten().collect();
    stream.sort_by_key(|transaction| transaction.seq);
    stream
}
