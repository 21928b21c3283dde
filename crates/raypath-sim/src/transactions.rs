//! Files of transactions (`docs/reference/transactions.md`): jobs of any operation with their recorded outcomes.

mod format;
mod lines;

use crate::InputError;
use format::{Column, Columns, columns};
use lines::Lines;
use raypath_model::{OperationId, WordModel, Words};
use raypath_ops::operations::NAMES;
use raypath_ops::{JobKind, PortValue};
use raypath_rtl::{Config, alternatives};
use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// A job with its recorded outcome.
#[derive(Debug, Clone, PartialEq)]
pub struct Transaction {
    /// The position in the stream from which the files were made.
    pub seq: u64,
    /// The category that the generator of the job assigned.
    pub category: u64,
    /// The job.
    pub job: Words,
    /// The recorded outcome.
    pub expected: Words,
}

/// The maximum number of transactions in a file. They are all in memory, and this many take some gigabytes.
const MAX_TRANSACTIONS: usize = 1 << 22;

/// Reads a file, plain or gzip, of jobs of one operation. Empty lines and lines that begin with `#` are ignored.
///
/// `model` is the model of the datapath that `config` configures. `kind` is the operation; if it is `None`, the file
/// name must begin with the name of the operation.
///
/// # Errors
/// A file that cannot be read; a file name without an operation; an operation that the model does not have; lines that
/// do not match the operation's ports or the format; more than 4,194,304 transactions, 64 KiB in a line or 4 GiB of
/// text.
pub fn read(
    path: &Path,
    kind: impl Into<Option<OperationId>>,
    model: &WordModel,
    config: Config,
) -> Result<Vec<Transaction>, InputError> {
    // A missing file is reported before a file name without an operation.
    let file = File::open(path).map_err(|problem| InputError::in_file(path, problem))?;
    read_from(file, path, kind, model, config)
}

/// Reads a stream as [`read`] reads a file. `path` appears in messages and replaces the file name.
///
/// # Errors
/// The errors of [`read`].
pub fn read_from(
    stream: impl Read,
    path: &Path,
    kind: impl Into<Option<OperationId>>,
    model: &WordModel,
    config: Config,
) -> Result<Vec<Transaction>, InputError> {
    let mut lines = Lines::new(stream).map_err(|problem| InputError::in_file(path, problem))?;
    let kind = kind.into().map_or_else(|| kind_of(path, model, config), Ok)?;
    let parser = Parser { kind, model, columns: columns(model, kind, config.semantics.format) };
    let mut transactions = Vec::new();
    for line in 1.. {
        let error = |problem| InputError::at_line(path, line, problem);
        let text = lines.next().map_err(|problem| error(format!("{problem}, expected text, plain or gzip")))?;
        let Some(text) = text else { break };
        if text.trim().is_empty() || text.starts_with('#') {
            continue;
        }
        if transactions.len() == MAX_TRANSACTIONS {
            let expected = "expected at most that (divide the file)";
            return Err(error(format!("more than {MAX_TRANSACTIONS} transactions, {expected}")));
        }
        transactions.push(parser.parse(text).map_err(error)?);
    }
    Ok(transactions)
}

/// The operation of a model with this name.
///
/// # Errors
/// The model does not have the operation.
pub fn kind_named(name: &str, model: &WordModel) -> Result<OperationId, InputError> {
    model.kind(name).ok_or_else(|| {
        let problem =
            format!("'{name}' is not a valid kind of job{}, expected {}", hint(name), alternatives(&model.kinds()));
        InputError { path: None, line: None, problem }
    })
}

/// The operation whose name the file name begins with: `triangle.txt.gz` has triangle jobs. If several names match,
/// the longest decides. Names that only other datapaths have match too, for the sake of the message.
fn kind_of(path: &Path, model: &WordModel, config: Config) -> Result<OperationId, InputError> {
    let file = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    let known = JobKind::ALL.iter().map(|kind| kind.name()).chain(NAMES).map(|name| (name, None));
    let own = model.kinds().into_iter().map(|kind| (kind.name(), Some(kind)));
    let matching = known.chain(own).filter(|(name, _)| file.starts_with(&name.to_lowercase()));
    let kinds = alternatives(&model.kinds());
    // The last of equal names is the model's own.
    let problem = match matching.max_by_key(|(name, _)| name.len()) {
        Some((_, Some(kind))) => return Ok(kind),
        Some((name, None)) => {
            format!("{name} jobs, but the datapath ({config}) cannot answer them{}, expected {kinds}", hint(name))
        }
        None => format!("the name begins with no kind of job, expected {kinds} (or give --kind)"),
    };
    Err(InputError::in_file(path, problem))
}

/// The option that would add a known operation to the datapath.
fn hint(name: &str) -> String {
    if matches!(name.parse(), Ok(JobKind::Euclidean | JobKind::Angular)) {
        " (no distance modes)".to_string()
    } else if NAMES.contains(&name) {
        format!(" (without --with {name})")
    } else {
        String::new()
    }
}

struct Parser<'p> {
    kind: OperationId,
    model: &'p WordModel,
    columns: Columns,
}

impl Parser<'_> {
    fn parse(&self, text: &str) -> Result<Transaction, String> {
        let Columns { inputs, outputs, lanes } = &self.columns;
        let fields: Vec<&str> = text.split_ascii_whitespace().collect();
        let first_output = 2 + inputs.len();
        let expected = first_output + outputs.len();
        if fields.len() != expected {
            let lanes = lanes.map(|lanes| format!(" with {lanes} lanes")).unwrap_or_default();
            return Err(format!("{} fields, expected {expected} for {}{lanes}", fields.len(), self.kind));
        }
        let (seq, category) = (number(0, "seq", 64, fields[0])?, number(1, "cat", 64, fields[1])?);
        let inputs = ports(2, inputs, &fields[2..first_output])?;
        let outputs = ports(first_output, outputs, &fields[first_output..])?;
        let at = |ports: &HashMap<&str, u64>, name: &str| ports.get(name).copied().unwrap_or(0);
        Ok(Transaction {
            seq,
            category,
            job: self.model.job(self.kind, |name| at(&inputs, name)),
            expected: self.model.outcome(self.kind, |name| at(&outputs, name)),
        })
    }
}

/// The port values of some columns, whose first field is number `first` of the line.
fn ports<'c>(first: usize, columns: &'c [Column], fields: &[&str]) -> Result<HashMap<&'c str, u64>, String> {
    let mut ports = HashMap::new();
    for (index, (column, field)) in columns.iter().zip(fields).enumerate() {
        let value = number(first + index, &column.port, column.width, field)?;
        *ports.entry(column.port.as_str()).or_insert(0) |= value << column.bit.unwrap_or(0);
    }
    Ok(ports)
}

fn number(index: usize, name: &str, width: u32, text: &str) -> Result<u64, String> {
    let plain_digits = text.bytes().all(|byte| byte.is_ascii_hexdigit());
    let value = u64::from_str_radix(text, 16).ok().filter(|_| plain_digits);
    value.filter(|value| width == 64 || value >> width == 0).ok_or_else(|| {
        let (field, max) = (index + 1, u64::MAX >> (64 - width));
        let found: String = text.chars().take(40).flat_map(char::escape_debug).collect();
        format!("field {field} ({name}) is '{found}', expected hexadecimal digits, at most {max:x}")
    })
}

/// The transactions of all files as one stream, in the order of `seq`.
pub fn merge(files: Vec<Vec<Transaction>>) -> Vec<Transaction> {
    let mut stream: Vec<Transaction> = files.into_iter().flatten().collect();
    stream.sort_by_key(|transaction| transaction.seq);
    stream
}

/// The text of a file with these transactions of one operation.
pub fn text(model: &WordModel, kind: OperationId, transactions: &[Transaction], config: Config) -> String {
    let Columns { inputs, outputs, .. } = columns(model, kind, config.semantics.format);
    let mut text = String::new();
    for Transaction { seq, category, job, expected } in transactions {
        let numbers = [seq, category].map(|number| format!("{number:x}")).into_iter();
        let fields = numbers.chain(written(&inputs, job.ports())).chain(written(&outputs, expected.ports()));
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
