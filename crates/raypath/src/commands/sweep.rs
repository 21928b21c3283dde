//! Configurations from a TOML file: for each parameter the values that it shall take.
//!
//! ```toml
//! lanes = ["none", 16]
//! control = ["skid", "credit"]
//! ```

use crate::commands::Failure;
use raypath::rtl::Config;
use std::fmt::Display;
use std::fs;
use std::path::Path;
use std::str::FromStr;
use toml::{Table, Value};

/// Values by parameter, in the file's order.
#[derive(Debug)]
pub struct Sweep(Vec<(String, Vec<String>)>);

impl Sweep {
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let text = fs::read_to_string(path).map_err(|problem| Failure::file(path, "read", problem))?;
        let table: Table = text.parse().map_err(|problem: toml::de::Error| Failure::file(path, "read", problem))?;
        let parameters = table.into_iter().map(|(name, values)| {
            let values = match values {
                Value::Array(values) => values,
                single => vec![single],
            };
            let values = values.into_iter().map(|value| match value {
                Value::String(text) => text,
                other => other.to_string(),
            });
            (name, values.collect())
        });
        Ok(Self(parameters.collect()))
    }

    /// All combinations, each under a name that says its values. `path` is for messages.
    pub fn configurations(&self, path: &Path) -> Result<Vec<(String, Config)>, Failure> {
        let mut all = vec![(Vec::new(), Config::DEFAULT)];
        for (parameter, values) in &self.0 {
            let mut further = Vec::new();
            for (words, config) in &all {
                for value in values {
                    let config = set(*config, parameter, value)
                        .map_err(|problem| Failure::Unusable(format!("{}: {parameter}: {problem}", path.display())))?;
                    further.push(([words.as_slice(), &[format!("{parameter}-{value}")]].concat(), config));
                }
            }
            all = further;
        }
        let named = all.into_iter().map(|(words, config)| {
            let name = if words.is_empty() { "default".to_string() } else { words.join("-") };
            (name, config)
        });
        Ok(named.collect())
    }
}

/// A configuration with another value of a parameter.
fn set(mut config: Config, parameter: &str, value: &str) -> Result<Config, String> {
    match parameter {
        "rules" => put(&mut config.rules, value)?,
        "lanes" => put(&mut config.lanes, value)?,
        "format" => put(&mut config.format, value)?,
        "io" => put(&mut config.io, value)?,
        "registers" => put(&mut config.registers, value)?,
        "control" => put(&mut config.control, value)?,
        "sharing" => put(&mut config.sharing, value)?,
        "unit-latency" => put(&mut config.unit_latency, value)?,
        _ => {
            let known = "rules, lanes, format, io, registers, control, sharing or unit-latency";
            return Err(format!("no such parameter, expected {known}"));
        }
    }
    Ok(config)
}

fn put<T: FromStr<Err: Display>>(place: &mut T, value: &str) -> Result<(), String> {
    *place = value.parse().map_err(|problem: T::Err| problem.to_string())?;
    Ok(())
}
