//! Files of transactions (`docs/reference/transactions.md`): jobs of any operation, with the outcomes that were
//! recorded for them.

mod format;
mod lines;

use format::{Column, Columns, columns};
use lines::Lines;
use raypath_model::{OperationId, WordModel, Words};
use raypath_ops::operations::NAMES;
use raypath_ops::{JobKind, PortValue};
use raypath_rtl::{Config, alternatives};
use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
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
    pub job: Words,
    /// The recorded outcome.
    pub expected: Words,
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
    #[error("{}: the name begins with no kind of job, expected {kinds} (or give --kind)", path.display())]
    UnknownKind {
        /// The file.
        path: PathBuf,
        /// The kinds that there are.
        kinds: String,
    },
    /// A name that is no kind of job.
    #[error("'{name}' is no kind of job{}, expected {kinds}", lacking(.name))]
    NoKind {
        /// The name.
        name: String,
        /// The kinds that there are.
        kinds: String,
    },
    /// Jobs of an operation that the datapath does not have.
    #[error("{}: {kind} jobs, but the datapath ({config}) cannot answer them{}, expected {kinds}", path.display(), lacking(.kind))]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The operation.
        kind: String,
        /// What it would run on.
        config: Config,
        /// The kinds that there are.
        kinds: String,
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
        kind: String,
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

/// Why an operation may be missing: what could be done about it.
fn lacking(kind: &str) -> String {
    if matches!(kind.parse(), Ok(JobKind::Euclidean | JobKind::Angular)) {
        " (no distance modes)".to_string()
    } else if NAMES.contains(&kind) {
        format!(" (without --with {kind})")
    } else {
        String::new()
    }
}

/// Reads a file, plain or gzip, with jobs of one kind for a configuration, whose model is `model`: `kind`, or that
/// which the file's name begins with. Empty lines and lines that begin with `#` are passed over.
///
/// # Errors
/// A file that cannot be read, a kind that the name does not tell or the model does not answer, lines that do not
/// fit the kind's ports or the format, and more than 4,194,304 transactions, 64 KiB in a line or 4 GiB of text.
pub fn read(
    path: &Path,
    kind: impl Into<Option<OperationId>>,
    model: &WordModel,
    config: Config,
) -> Result<Vec<Transaction>, TransactionError> {
    // Before the name is looked at: a file that is not there is the greater fault than a name that says nothing.
    let file = File::open(path).map_err(|problem| TransactionError::File { path: path.to_path_buf(), problem })?;
    read_from(file, path, kind, model, config)
}

/// Reads a stream as [`read`] reads a file; `path` is for messages, and for the kind where none is given.
///
/// # Errors
/// As there.
pub fn read_from(
    stream: impl Read,
    path: &Path,
    kind: impl Into<Option<OperationId>>,
    model: &WordModel,
    config: Config,
) -> Result<Vec<Transaction>, TransactionError> {
    let mut lines =
        Lines::new(stream).map_err(|problem| TransactionError::File { path: path.to_path_buf(), problem })?;
    let kind = kind.into().map_or_else(|| kind_of(path, model, config), Ok)?;
    let parser = Parser { path, kind, model, columns: columns(model, kind, config.semantics.format) };
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

/// The kind of job that has this name.
///
/// # Errors
/// A name that none of the model's has.
pub fn kind_named(name: &str, model: &WordModel) -> Result<OperationId, TransactionError> {
    let kind = model.kinds().into_iter().find(|kind| kind.to_string() == name);
    kind.ok_or_else(|| TransactionError::NoKind { name: name.to_string(), kinds: alternatives(&model.kinds()) })
}

/// The kind of job that a file's name begins with: `triangle.txt.gz` has triangles. Where it begins with several names
/// the longest is meant, of the model's operations and of others that are known.
fn kind_of(path: &Path, model: &WordModel, config: Config) -> Result<OperationId, TransactionError> {
    let file = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    let known = JobKind::ALL.iter().map(|kind| kind.name()).chain(NAMES);
    let own = model.kinds().into_iter().map(|kind| (kind.to_string(), Some(kind)));
    let all = known.map(|name| (name.to_string(), None)).chain(own);
    let meant = all.filter(|(name, _)| file.starts_with(&name.to_lowercase()));
    // Of equal ones the last: the model's own.
    match meant.max_by_key(|(name, _)| name.len()) {
        Some((_, Some(kind))) => Ok(kind),
        Some((kind, None)) => Err(TransactionError::Unsupported {
            path: path.to_path_buf(),
            kind,
            config,
            kinds: alternatives(&model.kinds()),
        }),
        None => Err(TransactionError::UnknownKind { path: path.to_path_buf(), kinds: alternatives(&model.kinds()) }),
    }
}

struct Parser<'p> {
    path: &'p Path,
    kind: OperationId,
    model: &'p WordModel,
    columns: Columns,
}

impl Parser<'_> {
    fn parse(&self, line: usize, text: &str) -> Result<Transaction, TransactionError> {
        let Columns { inputs, outputs, lanes } = &self.columns;
        let fields: Vec<&str> = text.split_ascii_whitespace().collect();
        let first_output = 2 + inputs.len();
        let expected = first_output + outputs.len();
        if fields.len() != expected {
            let (path, kind, found) = (self.path.to_path_buf(), self.kind.to_string(), fields.len());
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
pub fn merge(files: Vec<Vec<Transaction>>) -> Vec<Transaction> {
    let mut stream: Vec<Transaction> = files.into_iter().flatten().collect();
    stream.sort_by_key(|transaction| transaction.seq);
    stream
}

/// Transactions of one of a model's kinds as the text of a file.
pub fn text(model: &WordModel, kind: OperationId, transactions: &[Transaction], config: Config) -> String {
    let columns = columns(model, kind, config.semantics.format);
    let mut text = String::new();
    for Transaction { seq, category, job, expected } in transactions {
        let fields = [seq, category].map(|number| format!("{number:x}")).into_iter();
        let fields =
            fields.chain(written(&columns.inputs, job.ports())).chain(written(&columns.outputs, expected.ports()));
        text += &fields.collect::<Vec<_>>().join(" ");
        text += "\n";
    }
    text
}

fn written(columns: &[Column], ports: Vec<PortValue>) -> impl Iterator<Item = String> {
    columns.iter().map(move |column| {
        let bits = ports.iter().find(|port| port.name == column.port).map_or(0, |port| port.bits);
        let mask = u64::MAX >> (64 - column.width);
        format!("{:x}", bits >> column.bit.unwrap_or(0) & mask)
    })
}
