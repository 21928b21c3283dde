//! Configurations in files: TOML whose keys are the command line's options (`docs/reference/configurations.md`).

use raypath_rtl::{Config, Preset, alternatives, parameters};
use std::fs::File;
use std::io::{Error, ErrorKind, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};
use thiserror::Error;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Why a file is no configuration.
#[derive(Debug, Error)]
pub enum ConfigurationError {
    /// The file cannot be read.
    #[error("{}: {problem}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        problem: std::io::Error,
    },
    /// It is no TOML.
    #[error("{}:{line}: '{text}': {problem}; expected lines like lanes = 16 or rules = \"paper\"", path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is there.
        text: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A key that is no parameter.
    #[error("{}:{line}: '{key}' is no parameter, expected {}", path.display(), keys())]
    UnknownKey {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The key.
        key: String,
    },
    /// A value that the parameter does not have.
    #[error("{}:{line}: {key}: {problem}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The parameter.
        key: String,
        /// Names the value and says what was expected.
        problem: String,
    },
}

/// The keys of a file, as `a, b or c`.
fn keys() -> String {
    let names: Vec<&str> = ["preset"].into_iter().chain(parameters().map(|parameter| parameter.name)).collect();
    alternatives(&names)
}

/// Reads a configuration from a file. What the file does not say is as in its `preset`, or as in the default.
///
/// ```no_run
/// let config = raypath_sim::configuration::read("small.toml".as_ref())?;
/// let datapath = raypath_rtl::Datapath::new(config)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// A file that cannot be read, is larger than 64 KiB or is no TOML, a key that is no parameter, a value that its
/// parameter does not have.
pub fn read(path: &Path) -> Result<Config, ConfigurationError> {
    parse(&text(path)?, path)
}

/// Reads a configuration from text; `path` is for messages.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, path: &Path) -> Result<Config, ConfigurationError> {
    Document { path, text }.config()
}

/// Reads many configurations from a file of the same keys whose values may be lists: all combinations, each under a
/// name of the values in which they differ.
///
/// ```toml
/// preset = "graphics"
/// control = ["skid", "credit"]
/// unit-latency = [1, 2]
/// ```
///
/// # Errors
/// As [`read`]; an empty list; more than 10,000 combinations.
pub fn sweep(path: &Path) -> Result<Vec<(String, Config)>, ConfigurationError> {
    parse_sweep(&text(path)?, path)
}

/// Reads many configurations from text; `path` is for messages.
///
/// # Errors
/// As [`sweep`].
pub fn parse_sweep(text: &str, path: &Path) -> Result<Vec<(String, Config)>, ConfigurationError> {
    Document { path, text }.sweep()
}

/// Bytes of a file at most.
const MOST_TEXT: u64 = 64 << 10;
/// Configurations of a sweep at most: all values of all parameters are some hundreds for each format.
const MOST_CONFIGURATIONS: usize = 10_000;

fn text(path: &Path) -> Result<String, ConfigurationError> {
    let mut text = String::new();
    // One byte more than there may be tells what is too large from what just fits.
    let read = File::open(path).and_then(|file| file.take(MOST_TEXT + 1).read_to_string(&mut text));
    let fits = read.and_then(|length| match length as u64 > MOST_TEXT {
        true => Err(Error::new(ErrorKind::FileTooLarge, format!("more than {MOST_TEXT} bytes, expected at most that"))),
        false => Ok(()),
    });
    fits.map_err(|problem| ConfigurationError::File { path: path.to_path_buf(), problem })?;
    Ok(text)
}

struct Document<'f> {
    path: &'f Path,
    text: &'f str,
}

/// A key, one value of it as text, and where it stands.
#[derive(Clone)]
struct Entry {
    key: String,
    value: String,
    line: usize,
}

impl Document<'_> {
    fn config(&self) -> Result<Config, ConfigurationError> {
        let entries: Vec<Entry> = self.entries(false)?.into_iter().flatten().collect();
        self.config_of(&entries)
    }

    fn sweep(&self) -> Result<Vec<(String, Config)>, ConfigurationError> {
        let lists = self.entries(true)?;
        // Each value by itself first: what is multiplied below are short names of parameters and values.
        for entry in lists.iter().flatten() {
            self.config_of(std::slice::from_ref(entry))?;
        }
        let mut combinations: Vec<(Vec<String>, Vec<Entry>)> = vec![Default::default()];
        for values in lists {
            if let [first, ..] = values.as_slice()
                && combinations.len() * values.len() > MOST_CONFIGURATIONS
            {
                let problem = format!("makes more than {MOST_CONFIGURATIONS} configurations, expected at most that");
                let (path, line, key) = (self.path.to_path_buf(), first.line, first.key.clone());
                return Err(ConfigurationError::Value { path, line, key, problem });
            }
            let differs = values.len() > 1;
            let with = |(words, entries): &(Vec<String>, Vec<Entry>), entry: &Entry| {
                let word =
                    if entry.key == "preset" { entry.value.clone() } else { format!("{}-{}", entry.key, entry.value) };
                let words = words.iter().cloned().chain(differs.then_some(word)).collect();
                (words, entries.iter().chain([entry]).cloned().collect())
            };
            combinations =
                combinations.iter().flat_map(|so_far| values.iter().map(|entry| with(so_far, entry))).collect();
        }
        let named = combinations.iter().map(|(words, entries)| {
            let name = if words.is_empty() { "only".to_string() } else { words.join("-") };
            Ok((name, self.config_of(entries)?))
        });
        named.collect()
    }

    /// What the entries say, the preset first.
    fn config_of(&self, entries: &[Entry]) -> Result<Config, ConfigurationError> {
        let (presets, others): (Vec<&Entry>, Vec<&Entry>) = entries.iter().partition(|entry| entry.key == "preset");
        let mut config = Config::DEFAULT;
        for entry in presets {
            let preset: Result<Preset, _> = entry.value.parse();
            config = preset.map_err(|problem| self.wrong(entry, problem.to_string()))?.config;
        }
        for entry in others {
            let Some(parameter) = parameters().find(|parameter| parameter.name == entry.key) else {
                let (path, line, key) = (self.path.to_path_buf(), entry.line, beginning(&entry.key));
                return Err(ConfigurationError::UnknownKey { path, line, key });
            };
            parameter.set(&mut config, &entry.value).map_err(|problem| self.wrong(entry, problem))?;
        }
        Ok(config)
    }

    /// Each key with its value, or, where there may be `lists`, with its values; in the order of the file.
    fn entries(&self, lists: bool) -> Result<Vec<Vec<Entry>>, ConfigurationError> {
        let table = DeTable::parse(self.text).map_err(|error| {
            let line = self.line(error.span().unwrap_or_default());
            let text = beginning(self.text.lines().nth(line - 1).unwrap_or_default().trim());
            let problem = error.message().to_string();
            ConfigurationError::Syntax { path: self.path.to_path_buf(), line, text, problem }
        })?;
        let mut entries = Vec::new();
        for (key, value) in table.get_ref() {
            let (line, key) = (self.line(key.span()), key.get_ref().to_string());
            let entry = |value: &Spanned<DeValue<'_>>| {
                let value = self.in_words(value.get_ref(), value.span());
                Entry { key: key.clone(), value, line }
            };
            entries.push(match value.get_ref() {
                DeValue::Array(values) if lists && values.is_empty() => {
                    let (path, problem) = (self.path.to_path_buf(), "an empty list, expected a value".to_string());
                    return Err(ConfigurationError::Value { path, line, key, problem });
                }
                DeValue::Array(values) if lists => values.iter().map(entry).collect(),
                _ => vec![entry(value)],
            });
        }
        entries.sort_by_key(|values: &Vec<Entry>| values.first().map(|entry| entry.line));
        Ok(entries)
    }

    /// A string without its quotes; other values as they are written, of long ones the first line.
    fn in_words(&self, value: &DeValue<'_>, span: Range<usize>) -> String {
        match value {
            DeValue::String(text) => beginning(text),
            _ => beginning(self.text.get(span).and_then(|text| text.lines().next()).unwrap_or_default()),
        }
    }

    fn wrong(&self, entry: &Entry, problem: String) -> ConfigurationError {
        ConfigurationError::Value { path: self.path.to_path_buf(), line: entry.line, key: entry.key.clone(), problem }
    }

    fn line(&self, span: Range<usize>) -> usize {
        1 + self.text.bytes().take(span.start).filter(|&byte| byte == b'\n').count()
    }
}

/// As much of a text as a message has room for, and a mark where that is not all. No key and no value is as long.
fn beginning(text: &str) -> String {
    match text.char_indices().nth(80) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}
