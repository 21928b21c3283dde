//! Configurations in files: TOML whose keys are the command line's options (`docs/reference/configurations.md`).

use crate::InputError;
use raypath_rtl::{Config, Preset, alternatives, parameters};
use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Reads a configuration from a file. Parameters that the file does not set have the value of its `preset`, or the
/// default value.
///
/// ```no_run
/// let config = raypath_sim::configuration::read("small.toml".as_ref())?;
/// let datapath = raypath_rtl::DatapathNetlist::new(config)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// A file that cannot be read, is larger than 64 KiB or is not TOML; a key that does not name a parameter; a value that
/// its parameter does not have.
pub fn read(path: &Path) -> Result<Config, InputError> {
    read_with(path, &[], &mut |_, _| Ok(()))
}

/// Reads a configuration from a file as [`parse_with`] does from text.
///
/// # Errors
/// The errors of [`read`]; those of `set`.
pub fn read_with(
    path: &Path,
    others: &[&str],
    set: &mut dyn FnMut(&str, &str) -> Result<(), String>,
) -> Result<Config, InputError> {
    parse_with(&text(path)?, path, others, set)
}

/// Reads a configuration from text. `path` appears in messages.
///
/// # Errors
/// The errors of [`read`], except those of the file.
pub fn parse(text: &str, path: &Path) -> Result<Config, InputError> {
    parse_with(text, path, &[], &mut |_, _| Ok(()))
}

/// Reads a configuration from text that also has parameters of something around the datapath. `set` gets the name and
/// the value of each parameter that is one of `others`, and returns what it expected instead of a value.
///
/// ```
/// let mut contexts = String::new();
/// let set = &mut |_: &str, value: &str| Ok(contexts = value.to_string());
/// let text = "lanes = 4\ncontexts = 16";
/// let config = raypath_sim::configuration::parse_with(text, "unit.toml".as_ref(), &["contexts"], set)?;
/// assert_eq!((config.semantics.lanes.count(), contexts.as_str()), (4, "16"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// The errors of [`parse`]; those of `set`.
pub fn parse_with(
    text: &str,
    path: &Path,
    others: &[&str],
    set: &mut dyn FnMut(&str, &str) -> Result<(), String>,
) -> Result<Config, InputError> {
    let document = Document { path, text };
    let entries = document.entries(false)?.into_iter().flatten();
    let (around, own): (Vec<Entry>, Vec<Entry>) = entries.partition(|entry| others.contains(&entry.key.as_str()));
    for entry in &around {
        set(&entry.key, &entry.value).map_err(|problem| document.invalid(entry, problem))?;
    }
    document.config_of(&own, others)
}

/// Reads a sweep from a file with the same keys, whose values may be lists. Returns all combinations of the values. The
/// name of a combination consists of the values in which the combinations differ.
///
/// ```toml
/// preset = "graphics"
/// control = ["skid", "credit"]
/// unit-latency = [1, 2]
/// ```
///
/// # Errors
/// The errors of [`read`]; an empty list; more than 10,000 combinations.
pub fn sweep(path: &Path) -> Result<Vec<(String, Config)>, InputError> {
    parse_sweep(&text(path)?, path)
}

/// Reads a sweep from text. `path` appears in messages.
///
/// # Errors
/// The errors of [`sweep`], except those of the file.
pub fn parse_sweep(text: &str, path: &Path) -> Result<Vec<(String, Config)>, InputError> {
    Document { path, text }.sweep()
}

/// The maximum length of a file in bytes.
const MAX_BYTES: u64 = 64 << 10;
const MAX_CONFIGURATIONS: usize = 10_000;

fn text(path: &Path) -> Result<String, InputError> {
    let mut bytes = Vec::new();
    // One byte more than allowed, to detect a longer file.
    let read = File::open(path).and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes));
    if read.map_err(|problem| InputError::in_file(path, problem))? as u64 > MAX_BYTES {
        return Err(InputError::in_file(path, format!("more than {MAX_BYTES} bytes, expected at most that")));
    }
    String::from_utf8(bytes).map_err(|problem| {
        let before = &problem.as_bytes()[..problem.utf8_error().valid_up_to()];
        let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
        InputError::at_line(path, line, "a byte that is not UTF-8, expected text".to_string())
    })
}

struct Document<'f> {
    path: &'f Path,
    text: &'f str,
}

/// A key with one of its values as text, and its line, from 1.
#[derive(Clone)]
struct Entry {
    key: String,
    value: String,
    line: usize,
}

impl Document<'_> {
    fn sweep(&self) -> Result<Vec<(String, Config)>, InputError> {
        let lists = self.entries(true)?;
        // Check each value alone first, so that an error is reported before combinations are built.
        for entry in lists.iter().flatten() {
            self.config_of(std::slice::from_ref(entry), &[])?;
        }
        let mut combinations: Vec<(Vec<String>, Vec<Entry>)> = vec![Default::default()];
        for values in lists {
            if let [first, ..] = values.as_slice()
                && combinations.len() * values.len() > MAX_CONFIGURATIONS
            {
                let problem = format!("makes more than {MAX_CONFIGURATIONS} configurations, expected at most that");
                return Err(self.invalid(first, problem));
            }
            let differs = values.len() > 1;
            let with = |(words, entries): &(Vec<String>, Vec<Entry>), entry: &Entry| {
                let Entry { key, value, .. } = entry;
                let word = if key == "preset" { value.clone() } else { format!("{key}-{value}") };
                let words = words.iter().cloned().chain(differs.then_some(word)).collect();
                (words, entries.iter().chain([entry]).cloned().collect())
            };
            combinations =
                combinations.iter().flat_map(|so_far| values.iter().map(|entry| with(so_far, entry))).collect();
        }
        let named = combinations.iter().map(|(words, entries)| {
            let name = if words.is_empty() { "only".to_string() } else { words.join("-") };
            Ok((name, self.config_of(entries, &[])?))
        });
        named.collect()
    }

    /// The configuration that the entries set, the preset first. `names` are those that are valid besides, for
    /// messages.
    fn config_of(&self, entries: &[Entry], names: &[&str]) -> Result<Config, InputError> {
        let (presets, others): (Vec<&Entry>, Vec<&Entry>) = entries.iter().partition(|entry| entry.key == "preset");
        let mut config = Config::DEFAULT;
        for entry in presets {
            let preset: Result<Preset, _> = entry.value.parse();
            config = preset.map_err(|problem| self.invalid(entry, problem.to_string()))?.config;
        }
        for entry in others {
            let Some(parameter) = parameters().find(|parameter| parameter.name == entry.key) else {
                let own = ["preset"].into_iter().chain(parameters().map(|known| known.name));
                let keys: Vec<&str> = own.chain(names.iter().copied()).collect();
                let (key, expected) = (beginning(&entry.key), alternatives(&keys));
                let problem = format!("'{key}' is not a valid parameter, expected {expected}");
                return Err(InputError::at_line(self.path, entry.line, problem));
            };
            parameter.set(&mut config, &entry.value).map_err(|problem| self.invalid(entry, problem))?;
        }
        Ok(config)
    }

    /// Each key with its values, in the order of the file. A list counts as one value unless `lists` are allowed.
    fn entries(&self, lists: bool) -> Result<Vec<Vec<Entry>>, InputError> {
        let table = DeTable::parse(self.text).map_err(|error| {
            let line = self.line(error.span().unwrap_or_default());
            let text = beginning(self.text.lines().nth(line - 1).unwrap_or_default().trim());
            let expected = "expected lines like lanes = 16 or rules = \"paper\"";
            InputError::at_line(self.path, line, format!("'{text}': {}; {expected}", error.message()))
        })?;
        let mut entries = Vec::new();
        for (key, value) in table.get_ref() {
            let (line, key) = (self.line(key.span()), key.get_ref().to_string());
            let entry = |value: &Spanned<DeValue<'_>>| Entry {
                key: key.clone(),
                value: self.value(value.get_ref(), value.span()),
                line,
            };
            entries.push(match value.get_ref() {
                DeValue::Array(values) if lists && values.is_empty() => {
                    return Err(self.invalid(&entry(value), "an empty list, expected a value".to_string()));
                }
                DeValue::Array(values) if lists => values.iter().map(entry).collect(),
                _ => vec![entry(value)],
            });
        }
        entries.sort_by_key(|values: &Vec<Entry>| values.first().map(|entry| entry.line));
        Ok(entries)
    }

    /// The text of a value: a string without its quotes, another value as written, up to the end of its first line.
    fn value(&self, value: &DeValue<'_>, span: Range<usize>) -> String {
        match value {
            DeValue::String(text) => beginning(text),
            _ => beginning(self.text.get(span).and_then(|text| text.lines().next()).unwrap_or_default()),
        }
    }

    fn invalid(&self, entry: &Entry, problem: String) -> InputError {
        InputError::at_line(self.path, entry.line, format!("{}: {problem}", entry.key))
    }

    fn line(&self, span: Range<usize>) -> usize {
        1 + self.text.bytes().take(span.start).filter(|&byte| byte == b'\n').count()
    }
}

/// The first 80 characters of a text, for messages. Valid keys and values are shorter.
fn beginning(text: &str) -> String {
    match text.char_indices().nth(80) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}
